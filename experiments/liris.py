"""Run song2002 over the whole LIRIS benchmark and refresh `results/liris`: table, heat map, README.

    WM3D_DATA=folder-with-the-meshes python experiments/liris.py [--trials N] [--report-only]

What an earlier call has run is kept; more trials add to it.
"""

import argparse
import shutil
from pathlib import Path

import pandas as pd

from wm3d.bench import run_config
from wm3d.mesh import write_whole

ROOT = Path(__file__).resolve().parent.parent
CONFIG = ROOT / "configs" / "liris.yaml"
RESULTS = ROOT / "results" / "liris"
INTRODUCTION = """\
# song2002 over the LIRIS benchmark

`WM3D_DATA=… python experiments/liris.py` wrote this page from a run of `configs/liris.yaml` with {keys} keys
a cell (`--trials`; the config asks for 40). α = 1.3 on every mesh. Pd at Pf = 1e-6, by the exact key null on
the mesh under test, with its 95 % Clopper–Pearson interval; d' with Student's t; σ: deviation of the noise on
each coordinate, in % of the diagonal. All columns: [detection.csv](detection.csv); how far the axes turn:
[axes.csv](axes.csv).
"""


def page(detection: pd.DataFrame, axes: pd.DataFrame) -> str:
    """Return the page: Pd at 1e-6 and d' with their intervals, one line an attack."""
    meshes = list(dict.fromkeys(detection["mesh"]))
    lines = [
        INTRODUCTION.format(keys=int(detection["trials"].max())),
        "![Pd and d' by attack and mesh](heatmap.png)",
        "",
        "| attack |" + "".join(f" {mesh}: Pd | d' |" for mesh in meshes),
        "|---|" + "--:|--:|" * len(meshes),
    ]
    for attack in dict.fromkeys(detection["attack"]):
        cells = [_cell(detection, attack, mesh) for mesh in meshes]
        sigma = detection.loc[detection["attack"] == attack, "sigma_percent"]
        unit = "" if sigma.isna().all() else f" (σ {sigma.mean():.3f} %)"
        lines.append(f"| {attack}{unit} |" + "".join(cells))
    simplified = axes[axes["attack"].str.startswith("simplify")].groupby("mesh", sort=False)
    turned = [
        f"by over 90° in {line['flipped'].mean():.0%} of the trials on {mesh}, in the others by "
        f"{line['mean_deg'].mean():.0f}° on average"
        for mesh, line in simplified
    ]
    lines += [
        "",
        "Marks are lost where the pose is. Under simplification the axes of the vertices turn "
        + "; ".join(turned)
        + ". Crops move the mean of the vertices and so the axes with it.",
    ]
    return "\n".join(lines) + "\n"


def _cell(detection: pd.DataFrame, attack: str, mesh: str) -> str:
    line = detection[(detection["attack"] == attack) & (detection["mesh"] == mesh)].iloc[0]
    pd_, low, high = (line[f"pd_1e-06{end}"] for end in ("", "_low", "_high"))
    d, d_low, d_high = (line[f"d_prime{end}"] for end in ("", "_low", "_high"))
    return f" {pd_:.2f} ({low:.2f}–{high:.2f}) | {d:.1f} ({d_low:.1f}–{d_high:.1f}) |"


def write_results(run: Path) -> None:
    """Write results/liris from the run directory as it is."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    for name in ("detection", "axes"):
        shutil.copyfile(run / "tables" / f"{name}.csv", RESULTS / f"{name}.csv")
    shutil.copyfile(run / "figures" / "heatmap.png", RESULTS / "heatmap.png")
    detection, axes = (pd.read_csv(RESULTS / f"{name}.csv") for name in ("detection", "axes"))
    write_whole(RESULTS / "README.md", page(detection, axes).encode())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=Path("runs/liris"), help="the run directory")
    parser.add_argument("--trials", type=int, help="keys a cell, instead of those of the config")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--report-only", action="store_true", help="run nothing")
    options = parser.parse_args()
    if not options.report_only:
        overrides = [] if options.trials is None else [f"trials={options.trials}"]
        run_config(CONFIG, out=options.out, workers=options.workers, overrides=overrides)
    write_results(options.out)
