"""The experiment harness: config -> plan -> run -> store -> tables, figures, report.

What `__all__` names is imported when it is first used, for a worker needs neither figures nor pages.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wm3d.bench.config import Experiment, load_experiment
    from wm3d.bench.report import write_report
    from wm3d.bench.run import Outcome, run_config
else:
    _HOMES = {
        "Experiment": "wm3d.bench.config",
        "Outcome": "wm3d.bench.run",
        "load_experiment": "wm3d.bench.config",
        "run_config": "wm3d.bench.run",
        "write_report": "wm3d.bench.report",
    }

    def __getattr__(name: str) -> Any:
        if name not in _HOMES:
            raise AttributeError(f"module 'wm3d.bench' has no attribute {name!r}")
        return getattr(import_module(_HOMES[name]), name)


__all__ = ["Experiment", "Outcome", "load_experiment", "run_config", "write_report"]
