"""Reports: tables, figures and report.html from the rows of a run directory; runs nothing."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from wm3d.bench import figures
from wm3d.bench.columns import CALIBRATION, FALSE_ALARMS, GONE, TRIALS
from wm3d.bench.config import load_experiment
from wm3d.bench.curves import false_alarm_figure, roc_figure
from wm3d.bench.heatmap import LEAST_ATTACKS, heatmap_figure
from wm3d.bench.html import Run, render
from wm3d.bench.leaderboard import leaderboard
from wm3d.bench.quality import quality_figure
from wm3d.bench.ranking import over_meshes, ranking
from wm3d.bench.store import RunDirectory, report_files
from wm3d.bench.summary import left_out, quoted_pf, refusals
from wm3d.bench.tables import Sigmas, all_tables
from wm3d.errors import Wm3dError

MOST_ROC_SETTINGS = 12
"""Pairs of mesh and scheme up to which a run has a figure of ROC curves; more make a tower of panels."""


@dataclass(frozen=True, eq=False)
class Report:
    """What a report left behind.

    Attributes
    ----------
    page : Path
        report.html.
    failed : int
        Trials whose attack failed.
    tables : dict of str to DataFrame
        The tables by name.
    refused : mapping of (str, str) to str
        `wm3d.bench.summary.refusals`.
    pf : float
        The false-alarm probability that page and terminal speak of.
    """

    page: Path
    failed: int
    tables: dict[str, pd.DataFrame]
    refused: Mapping[tuple[str, str], str]
    pf: float


def write_report(run_dir: str | Path) -> Report:
    """Write tables, figures and report.html of a finished run; an earlier report goes.

    Parameters
    ----------
    run_dir : str or Path

    Returns
    -------
    Report

    Raises
    ------
    Wm3dError
        If this is not a run directory, another run is writing there, a cell is missing or damaged, or no
        scheme could be calibrated.
    """
    directory = RunDirectory(run_dir)
    read_manifest(directory)  # where there is none, no lock is left behind
    with directory.locked():
        return report_of(directory)


def report_of(directory: RunDirectory) -> Report:
    """Do what `write_report` does in a directory that this process holds."""
    manifest = read_manifest(directory)
    experiment = load_experiment(directory.path / "config.yaml")
    calibration = _read_calibration(directory, manifest)
    rows = read_rows(directory, manifest["cells"])
    false_alarms = read_rows(directory, manifest["false_alarm_cells"], FALSE_ALARMS)
    directory.create()  # a copy of a run may lack its empty folders
    sigmas: Sigmas = manifest.get("sigma_percent", {})  # runs of earlier versions have none
    tables = all_tables(rows, experiment.pf, false_alarms, sigmas)
    pf = quoted_pf(experiment.pf)
    if len(calibration):
        ranked = ranking(calibration, tables["detection"], tables["snr"], tables["timing"], pf)
        tables = {"leaderboard": ranked, "calibration": calibration} | tables
        directory.write_text("leaderboard.json", leaderboard(experiment, manifest, ranked, calibration, pf))
    directory.write_tables(tables)
    credits = {name: mesh["credit"] for name, mesh in manifest["meshes"].items()}
    drawn = _figures(rows, tables, credits, sigmas, pf)
    saved = {name: figures.save(figure, directory, name) for name, figure in drawn.items()}
    run = Run(
        experiment=experiment,
        config=(directory.path / "config.yaml").read_text(encoding="utf-8"),
        manifest=manifest,
        rows=rows,
        tables=tables,
        refused=refusals(rows),
        figures={name: figures.inline_svg(svg, name) for name, svg in saved.items()},
    )
    directory.write_text("report.html", render(run))
    directory.drop_report(keep=report_files(tables, drawn))
    failed = int(rows["log10_p"].isna().sum())
    return Report(directory.path / "report.html", failed, tables, run.refused, pf)


def _read_calibration(directory: RunDirectory, manifest: Mapping[str, Any]) -> pd.DataFrame:
    # runs of earlier versions have no calibration
    calibration = read_rows(directory, manifest.get("calibration_cells", []), CALIBRATION)
    if not manifest["cells"] and (reasons := left_out(calibration)):
        remedy = "change the config's budgets or schemes"
        if (calibration["error"] == GONE).any():
            remedy = "run it again, with fewer --workers if memory is short"
        raise Wm3dError(
            f"{directory.path}: holds no trials, for no scheme could be calibrated; {remedy}:\n  "
            + "\n  ".join(reasons)
        )
    return calibration


def _figures(
    rows: pd.DataFrame,
    tables: Mapping[str, pd.DataFrame],
    credits: Mapping[str, str | None],
    sigmas: Sigmas,
    pf: float,
) -> dict[str, Figure]:
    """Return the figures by name, as far as there are rows for them."""
    drawn = {}
    settings = tables["detection"].groupby(["mesh", "scheme"]).ngroups
    if 0 < settings <= MOST_ROC_SETTINGS:
        drawn["roc"] = roc_figure(rows, credits, sigmas)
    if tables["detection"]["attack"].nunique() >= LEAST_ATTACKS:
        if "calibration" in tables:
            shown = over_meshes(tables["calibration"], tables["detection"], pf)
            owed = "; ".join(dict.fromkeys(filter(None, credits.values()))) or None
            drawn["heatmap"] = heatmap_figure(shown, pf, dict.fromkeys(shown["mesh"], owed))
        else:
            drawn["heatmap"] = heatmap_figure(tables["detection"], pf, credits)
    if "leaderboard" in tables and tables["leaderboard"]["score"].notna().any():
        meshes = dict.fromkeys(tables["calibration"]["mesh"])
        drawn["quality"] = quality_figure(tables["leaderboard"], tables["detection"], pf, meshes, credits)
    if "false_alarms" in tables:
        drawn["false_alarms"] = false_alarm_figure(tables["false_alarms"], credits, sigmas)
    return drawn


def read_manifest(directory: RunDirectory) -> dict[str, Any]:
    """Return the manifest of a run.

    Raises
    ------
    Wm3dError
        If there is none, or it is not one.
    """
    try:
        manifest: dict[str, Any] = json.loads((directory.path / "manifest.json").read_bytes())
        missing = {"meshes", "cells", "false_alarm_cells"} - manifest.keys()
    except (OSError, ValueError, AttributeError):
        raise Wm3dError(
            f"{directory.path}: is not the directory of a finished run (no manifest); where one was stopped, "
            "the same `wm3d run` goes on."
        ) from None
    if missing:
        raise Wm3dError(
            f"{directory.path}: its manifest lacks {', '.join(sorted(missing))}; run the config again."
        )
    return manifest


def read_rows(directory: RunDirectory, cells: list[str], columns: Mapping[str, str] = TRIALS) -> pd.DataFrame:
    """Return the rows of cells, in their order.

    Raises
    ------
    Wm3dError
        If a cell is missing or damaged, or there is none of those that hold trials.
    """
    parts = []
    for digest in cells:
        rows = directory.read_cell(digest, columns)
        if rows is None:
            raise Wm3dError(f"{directory.cell_path(digest)}: is missing; run the config again to restore it.")
        parts.append(rows)
    if columns is TRIALS and not parts:
        raise Wm3dError(f"{directory.path}: holds no finished cells; run the config again.")
    none = pd.DataFrame(columns=list(columns)).astype(dict(columns))
    return pd.concat([part for part in parts if len(part)] or [none], ignore_index=True)
