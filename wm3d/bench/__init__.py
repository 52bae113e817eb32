"""The experiment harness: config -> plan -> run -> store -> tables, figures, report."""

from wm3d.bench.config import Experiment, load_experiment
from wm3d.bench.report import write_report
from wm3d.bench.run import Outcome, run_config

__all__ = ["Experiment", "Outcome", "load_experiment", "run_config", "write_report"]
