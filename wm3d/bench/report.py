"""Reports: tables and figures from the rows of a run directory; runs nothing."""

import json
from pathlib import Path

import pandas as pd

from wm3d.bench import figures
from wm3d.bench.config import Experiment, load_experiment
from wm3d.bench.store import RunDirectory
from wm3d.bench.tables import all_tables
from wm3d.errors import Wm3dError


def write_report(run_dir: str | Path) -> int:
    """Write tables and figures from the cells that the manifest lists.

    Parameters
    ----------
    run_dir : str or Path

    Returns
    -------
    int
        Number of trials whose attack failed.

    Raises
    ------
    Wm3dError
        If this is not a run directory, or a cell is missing or damaged.
    """
    directory = RunDirectory(run_dir)
    experiment, rows = read_run(directory)
    directory.write_tables(all_tables(rows, experiment.pf))
    if (rows["hypothesis"] == "H1").any():
        figures.save(figures.roc_figure(rows), directory, "roc")
    return int(rows["log10_p"].isna().sum())


def read_run(directory: RunDirectory) -> tuple[Experiment, pd.DataFrame]:
    """Return the config and all rows of a run, in plan order."""
    try:
        listed = json.loads((directory.path / "manifest.json").read_text())["cells"]
    except (OSError, ValueError, KeyError, TypeError):
        raise Wm3dError(f"{directory.path}: is not the directory of a finished run (no manifest).") from None
    experiment = load_experiment(directory.path / "config.yaml")
    parts = []
    for digest in listed:
        rows = directory.read_cell(digest)
        if rows is None:
            raise Wm3dError(f"{directory.cell_path(digest)}: is missing; run the config again to restore it.")
        parts.append(rows)
    if not parts:
        raise Wm3dError(f"{directory.path}: holds no finished cells.")
    return experiment, pd.concat(parts, ignore_index=True)
