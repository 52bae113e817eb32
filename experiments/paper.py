"""Run every config in `configs/paper` and refresh `results/paper`: tables, figures, manifest, README.

    WM3D_DATA=folder-with-the-meshes python experiments/paper.py

What an earlier call has run is kept; a call that was interrupted goes on where it stopped.
"""

import argparse
import json
import shutil
import time
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure
from paper_readme import crossing, readme

from wm3d.bench import run_config
from wm3d.bench.figures import COLORS, caption, save, styled
from wm3d.bench.store import RunDirectory
from wm3d.mesh import datasets, write_whole

ROOT = Path(__file__).resolve().parent.parent
CONFIGS = sorted((ROOT / "configs" / "paper").glob("*.yaml"))
RESULTS = RunDirectory(ROOT / "results" / "paper")
PD_PAPER, PF_PAPER = 0.97, 1e-6


def run_all(runs: Path, workers: int | None) -> None:
    """Run what is missing."""
    begun = time.monotonic()
    for config in CONFIGS:
        run_config(config, out=runs / config.stem, workers=workers)
    print(f"all configs: {(time.monotonic() - begun) / 60:.1f} minutes")


def write_results(runs: Path) -> None:
    """Write results/paper from the run directories as they are."""
    for folder in ("tables", "figures"):
        (RESULTS.path / folder).mkdir(parents=True, exist_ok=True)
    manifests = {
        config.stem: json.loads((runs / config.stem / "manifest.json").read_text())
        for config in CONFIGS
        if (runs / config.stem / "manifest.json").exists()
    }
    tables = collect(runs, list(manifests))
    RESULTS.write_tables(tables)
    for name in {"fig6a", "fig6b"} & manifests.keys():
        for ending in ("png", "svg"):
            shutil.copyfile(
                runs / name / "figures" / f"roc.{ending}", RESULTS.path / "figures" / f"{name}.{ending}"
            )
    amplitude = noise_amplitude(runs / "noise-amplitude")
    RESULTS.write_tables({"noise_amplitude": amplitude})
    save(amplitude_figure(amplitude), RESULTS, "noise_amplitude")
    for entry in manifests.values():
        entry["cells"] = len(entry["cells"])
    RESULTS.write_text("manifest.json", json.dumps(manifests, indent=2, ensure_ascii=False) + "\n")
    write_whole(RESULTS.path / "README.md", readme(tables, amplitude, manifests).encode())


def collect(runs: Path, names: list[str]) -> dict[str, pd.DataFrame]:
    """Return the tables of all runs, those of one kind in one, with the run in the first column."""
    parts: dict[str, list[pd.DataFrame]] = {}
    for name in names:
        if name == "noise-amplitude":
            continue  # has a table of its own
        for path in sorted((runs / name / "tables").glob("*.csv")):
            table = pd.read_csv(path)
            if len(table):
                table.insert(0, "config", name)
                parts.setdefault(path.stem, []).append(table)
    return {kind: pd.concat(tables, ignore_index=True) for kind, tables in parts.items()}


def noise_amplitude(run: Path) -> pd.DataFrame:
    """Return Pd at 1e-6 for each model and amplitude, under both names of the amplitude."""
    table = pd.read_csv(run / "tables" / "detection.csv")
    percent = table["attack"].str.extract(r"gaussian-noise ([\d.]+) rms-vector")[0].astype(float)
    pd_name = f"pd_{PF_PAPER:g}"
    return pd.DataFrame(
        {
            "mesh": table["mesh"],
            "rms_vector_percent": percent,
            "per_axis_percent": percent / 3**0.5,
            "trials": table["trials"],
            "d_prime": table["d_prime"],
            "pd": table[pd_name],
            "pd_low": table[f"{pd_name}_low"],
            "pd_high": table[f"{pd_name}_high"],
        }
    )


def amplitude_figure(table: pd.DataFrame) -> Figure:
    """Pd at Pf = 1e-6 against the noise, and the amplitude at which each model meets the paper's 0.97."""
    with styled():
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        panel = figure.subplots()
        for color, (mesh, group) in zip(COLORS, table.groupby("mesh", sort=False), strict=False):
            percent = group["rms_vector_percent"]
            label = f"{mesh}: {PD_PAPER} reached up to {crossing(group, PD_PAPER):.2f} %"
            panel.plot(percent, group["pd"], "o-", color=color, markersize=3, label=label)
            panel.fill_between(percent, group["pd_low"], group["pd_high"], color=color, alpha=0.15)
        panel.axhline(PD_PAPER, color="0.5", linewidth=0.8, linestyle="--")
        for percent, reading in ((0.6, "rms-vector"), (0.6 * 3**0.5, "per-axis")):
            panel.axvline(percent, color="0.5", linewidth=0.8)
            panel.annotate(
                f"0.6 % read as {reading} ", (percent, 0.5), rotation=90, fontsize=7, ha="right", va="center"
            )
        panel.set(
            xlabel="noise, rms length of the vector in % of the diagonal", ylabel=f"Pd at Pf = {PF_PAPER:g}"
        )
        second = panel.secondary_xaxis("top", functions=(lambda x: x / 3**0.5, lambda x: x * 3**0.5))
        second.set_xlabel("the same noise as standard deviation per axis, in % of the diagonal")
        panel.legend(loc="upper left", bbox_to_anchor=(0.0, -0.16))
        text = (
            f"{table['trials'].max()} keys a point. Statistic: z of the detector, large is marked. Null: "
            "uniform keys on the mesh under test, exact. Bands: 95 % Clopper–Pearson."
        )
        meshes = list(dict.fromkeys(table["mesh"]))
        caption(figure, text, meshes, {mesh: datasets.credit(mesh) for mesh in meshes})
    return figure


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--runs", type=Path, default=ROOT / "runs" / "paper", help="where the run directories are kept"
    )
    parser.add_argument("--workers", type=int)
    parser.add_argument(
        "--report-only", action="store_true", help="run nothing: results of the runs as they are"
    )
    arguments = parser.parse_args()
    if not arguments.report_only:
        run_all(arguments.runs, arguments.workers)
    write_results(arguments.runs)
