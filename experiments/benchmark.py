"""Run the benchmark and refresh `results/benchmark`: leaderboard, tables, figures, README.

    WM3D_DATA=folder-with-the-meshes python experiments/benchmark.py
    python experiments/benchmark.py --config configs/benchmark_small.yaml --results benchmark-small

What an earlier call has run is kept; a call that was interrupted goes on where it stopped.
"""

import argparse
import json
import shutil
from pathlib import Path

import pandas as pd
from benchmark_readme import readme

from wm3d.bench import load_experiment, run_config, write_report
from wm3d.bench.report import read_manifest, read_rows
from wm3d.bench.store import RunDirectory
from wm3d.mesh import write_whole

ROOT = Path(__file__).resolve().parent.parent


def write_results(run: RunDirectory, results: Path) -> None:
    """Write the results from a run directory as it is."""
    for folder, ending in (("tables", "csv"), ("figures", "png")):
        (results / folder).mkdir(parents=True, exist_ok=True)
        for file in sorted((run.path / folder).glob(f"*.{ending}")):
            shutil.copyfile(file, results / folder / file.name)
    shutil.copyfile(run.path / "leaderboard.json", results / "leaderboard.json")
    manifest = read_manifest(run)
    board = json.loads((results / "leaderboard.json").read_text())
    write_whole(results / "README.md", readme(results / "tables", board, manifest, minutes(run)).encode())


def minutes(run: RunDirectory) -> float:
    """Return the minutes that one processor was busy with all that the run holds, however often it paused."""
    rows = read_rows(run, read_manifest(run)["cells"])
    marks = rows[rows["hypothesis"] == "H1"].drop_duplicates(["mesh", "scheme", "trial"])
    calibration = pd.read_csv(run.path / "tables" / "calibration.csv")
    return (rows["seconds"].sum() + marks["embed_seconds"].sum() + calibration["seconds"].sum()) / 60


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--config", type=Path, default=ROOT / "configs" / "benchmark.yaml")
    parser.add_argument("--out", type=Path, help="the run directory, runs/NAME by default")
    parser.add_argument("--results", type=Path, default=ROOT / "results" / "benchmark")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--set", action="append", metavar="PATH=VALUE", help="as of `wm3d run`")
    parser.add_argument("--report-only", action="store_true", help="run nothing: results of the run as it is")
    arguments = parser.parse_args()
    out = arguments.out or ROOT / "runs" / load_experiment(arguments.config, arguments.set).name
    if arguments.report_only:
        write_report(out)
    else:
        run_config(arguments.config, out=out, workers=arguments.workers, overrides=arguments.set)
    write_results(RunDirectory(out), arguments.results)
