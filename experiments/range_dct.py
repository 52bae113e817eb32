"""Run every config in `configs/range_dct` and refresh `results/range_dct`: tables, figures, README.

    WM3D_DATA=folder-with-the-meshes python experiments/range_dct.py [--trials N] [--report-only]

What an earlier call has run is kept; more trials add to it. Of each line of a table that of the newest
version of its scheme stands, and of these that of most keys, whether its run is at hand or not. The ablation
is `experiments/ablation.py`, other models are those of
`experiments/other_models.py --out results/range_dct/other_models.csv`.
"""

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, StrictUndefined
from range_dct_distortion import (
    AXES,
    LIRIS_BUDGETS,
    at_budget,
    by_strength,
    curves,
    distortion,
    held,
    weakest,
)
from scipy.stats import norm

from wm3d.bench import load_experiment, run_config
from wm3d.bench.figures import save
from wm3d.bench.heatmap import heatmap_figure
from wm3d.bench.report import read_manifest
from wm3d.bench.store import RunDirectory
from wm3d.errors import Wm3dError
from wm3d.mesh import datasets, write_whole
from wm3d.stats import DEFAULT_PF, tolerance_bound

ROOT = Path(__file__).resolve().parent.parent
CONFIGS = {
    name: ROOT / "configs" / "range_dct" / f"{name}.yaml"
    for name in (
        "paper_attacks",
        "other_attacks",
        "slow_attacks",
        "coarse_buddha",
        "broken_meshes",
        "blocks",
        "distortion",
        "strength",
        "nulls",
    )
}
RESULTS = RunDirectory(ROOT / "results" / "range_dct")
DRAWN = {
    "paper_attacks": ("paper_attacks",),
    "other_attacks": ("other_attacks", "slow_attacks", "coarse_buddha"),
    "broken_meshes": ("broken_meshes",),
}
"""Tables that each heat map shows."""
OTHER_MODELS = RESULTS.path / "other_models.csv"
TEMPLATE = Path(__file__).with_name("range_dct_readme.md.j2")
SHARE = 0.99
"""Share of the keys that are to be found."""

READS_ALIKE = 8
"""First version of range-dct that reads as the present one does, turned parts aside."""

THRESHOLD = {pf: float(norm.isf(pf)) for pf in (1e-6, 1e-12)}
"""z of a detection; a sum of signs is more often below it than a Gaussian."""

COUNTED_AT = (2.0, 3.0, 4.0)
"""z at which counted and exact false alarms stand side by side."""

CELL = ("mesh", "scheme", "attack")
"""Columns that name a line."""

KEPT = [
    "mesh", "scheme", "attack", "sigma_percent", "trials", "failed", "unreadable", "z_mean", "z_std",
    "d_prime", "d_prime_low", "d_prime_high", "pd_1e-06", "pd_1e-06_low", "pd_1e-06_high",
    "pd_1e-12", "pd_1e-12_low", "pd_1e-12_high", "version",
]  # fmt: skip


def run_all(runs: Path, trials: int | None, workers: int | None) -> None:
    """Run what is missing."""
    for name, config in CONFIGS.items():
        overrides = [] if trials is None else [f"trials={trials}"]
        run_config(config, out=runs / name, workers=workers, overrides=overrides)


def write_results(runs: Path) -> None:
    """Write results/range_dct from the run directories as they are."""
    for folder in ("tables", "figures"):
        (RESULTS.path / folder).mkdir(parents=True, exist_ok=True)
    tables = {file.stem: pd.read_csv(file) for file in sorted((RESULTS.path / "tables").glob("*.csv"))}
    for name in CONFIGS:
        if name not in ("distortion", "nulls") and (runs / name / "tables" / "detection.csv").exists():
            detection = read(runs, name, "detection")
            lines = detection[[column for column in KEPT if column in detection]]
            tables[name] = in_order(best(lines, tables.get(name)), CONFIGS[name])
    if (runs / "distortion" / "tables").exists():
        lines = distortion(runs / "distortion").assign(version=versions(runs, "distortion")["range-dct"])
        tables["distortion"] = by_strength(best(lines, tables.get("distortion")))
        for against in AXES:
            save(curves(tables["distortion"], against), RESULTS, f"pd_against_{against}")
    if (runs / "nulls" / "tables").exists():
        lines, curve = read(runs, "nulls", "nulls"), counted(read(runs, "nulls", "false_alarms"))
        tables["nulls"] = best(lines, tables.get("nulls"), (*CELL, "hypothesis", "subject"))
        tables["random_keys"] = best(curve, tables.get("random_keys"), ("mesh", "attack", "z"), count="keys")
    tables |= {name: bounded(tables[name]) for name in CONFIGS if name in tables and name != "nulls"}
    for name in DRAWN:
        shown = drawn(tables, name)
        if len(shown):
            credits = {mesh: datasets.credit(mesh) for mesh in shown["mesh"].unique()}
            save(heatmap_figure(shown, DEFAULT_PF, credits), RESULTS, name)
    tables["beside_song2002"] = ratios(tables)
    RESULTS.write_tables(tables)
    write_whole(RESULTS.path / "README.md", page(tables).encode())


def read(runs: Path, name: str, table: str) -> pd.DataFrame:
    """Return a table of a run, with the version of the scheme of each line."""
    lines = pd.read_csv(runs / name / "tables" / f"{table}.csv")
    known = versions(runs, name)
    return lines.assign(version=[known[label.split()[0]] for label in lines["scheme"]])


def versions(runs: Path, name: str) -> dict[str, int]:
    """Return the version that each scheme had when a run was made."""
    manifest = read_manifest(RunDirectory(runs / name))
    if "schemes" not in manifest:
        raise Wm3dError(
            f"{runs / name}: its manifest tells no versions of schemes; run wm3d run {CONFIGS[name]} --out "
            f"{runs / name} again, which keeps what is there."
        )
    schemes: dict[str, int] = manifest["schemes"]
    return schemes


def best(
    new: pd.DataFrame, old: pd.DataFrame | None, names: Sequence[str] = CELL, *, count: str = "trials"
) -> pd.DataFrame:
    """Return, of lines with the same `names`, the newest version with the most keys, as `count` has them."""
    lines = new if old is None else pd.concat([new, old], ignore_index=True)
    ranked = lines.sort_values(["version", count], ascending=False, kind="stable")
    return ranked.drop_duplicates(list(names)).sort_index().reset_index(drop=True)


def in_order(lines: pd.DataFrame, config: Path) -> pd.DataFrame:
    """Return lines in the order in which a config names meshes, schemes and attacks, whatever was merged."""
    experiment = load_experiment(config)
    named = {
        "mesh": [mesh for case in experiment.cases for mesh in case.meshes],
        "scheme": [scheme.label() for case in experiment.cases for scheme in case.schemes],
        "attack": [attack.label() for attack in experiment.attacks],
    }

    def place(column: pd.Series) -> pd.Series:
        plain = column.str.split(" at ").str[0]  # without the budget of a calibrated scheme
        return plain.map(named[str(column.name)].index)

    return lines.sort_values(list(named), key=place, kind="stable", ignore_index=True)


def bounded(lines: pd.DataFrame) -> pd.DataFrame:
    """Return lines with the z that 99 % of all keys exceed, with a confidence of 0.95, if z is Gaussian."""
    return lines.assign(z_99=tolerance_bound(lines["z_mean"], lines["z_std"], lines["trials"], SHARE))


def short(lines: pd.DataFrame) -> dict[str, Any]:
    """Return how many cells there are, in how many of them 99 % are found, and those where not, at 1e-12.

    That is where the bound is a detection and no less were: the law of z knows of no place that is missed.
    """
    found = {pf: (lines["z_99"] > z) & (lines[f"pd_{pf:g}"] >= SHARE) for pf, z in THRESHOLD.items()}
    below = lines.loc[~found[1e-12], ["mesh", "attack", "z_99", "pd_1e-12"]]
    return {
        "cells": len(lines),
        "found": {pf: int(cells.sum()) for pf, cells in found.items()},
        "below": below.sort_values("z_99").to_dict("records"),
    }


def drawn(tables: dict[str, pd.DataFrame], name: str) -> pd.DataFrame:
    """Return the lines that the heat map `name` shows; none where nothing has been run."""
    parts = [tables[part] for part in DRAWN[name] if part in tables]
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()


def ratios(tables: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Return d' of both schemes and their ratio, for each mesh and attack of the paper's kind."""
    lines = tables["paper_attacks"]
    robust, paper = (
        lines[lines["scheme"].str.startswith(name)].set_index(["mesh", "attack"])
        for name in ("range-dct", "song2002")
    )
    both = robust.add_suffix("_range_dct").join(paper.add_suffix("_song2002"), how="inner")
    ratio = both["d_prime_range_dct"] / both["d_prime_song2002"].where(both["d_prime_song2002"] > 0)
    columns = [f"{what}_{who}" for what in ("d_prime", "pd_1e-06") for who in ("range_dct", "song2002")]
    return both[columns].assign(d_prime_ratio=ratio).reset_index()


def least_ratio(tables: dict[str, pd.DataFrame]) -> dict[str, Any]:
    """Return the least ratio of d' where song2002 has any, with a 95 % interval (of the logarithm)."""
    both = tables["beside_song2002"]
    line = both[both["d_prime_song2002"] >= 1].nsmallest(1, "d_prime_ratio").to_dict("records")[0]
    paper = tables["paper_attacks"]
    here = paper[(paper["mesh"] == line["mesh"]) & (paper["attack"] == line["attack"])]
    half = (here["d_prime_high"] - here["d_prime_low"]) / 2 / here["d_prime"]
    factor = math.exp(math.hypot(*half))
    return line | {"low": line["d_prime_ratio"] / factor, "high": line["d_prime_ratio"] * factor}


def counted(curve: pd.DataFrame) -> pd.DataFrame:
    """Return the random keys that reached the z of `COUNTED_AT`, beside the exact probability."""
    lines = curve[curve["z"].round(3).isin(COUNTED_AT)].copy()
    lines["pf_exact"] = 10 ** lines.pop("log10_pf_exact")
    lines["inside"] = lines["pf_exact"].between(lines["pf_low"], lines["pf_high"])
    return lines.drop(columns="scheme").reset_index(drop=True)


def page(tables: dict[str, pd.DataFrame]) -> str:
    """Return the page that goes with the tables."""
    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    ablation, others = pd.read_csv(RESULTS.path / "ablation.csv"), pd.read_csv(OTHER_MODELS)
    paper = tables["paper_attacks"]
    shown = {name: drawn(tables, name) for name in DRAWN}
    curve = tables.get("distortion", pd.DataFrame())
    return (
        environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
        .render(
            # of nulls, those of one key; wrong keys are scored on the same meshes
            trials={name: int(robust(tables[name])["trials"].min()) for name in CONFIGS if name in tables},
            most={name: int(robust(tables[name])["trials"].max()) for name in CONFIGS if name in tables},
            paper_trials=int(paper.loc[paper["scheme"].str.startswith("song2002"), "trials"].min()),
            paper=pivot(robust(paper)),
            older={name: older_meshes(robust(tables[name])) for name in CONFIGS if name in tables},
            version={name: int(robust(tables[name])["version"].min()) for name in CONFIGS if name in tables}
            | {"ablation": int(ablation["version"].min()), "other_models": int(others["version"].min())},
            alike=READS_ALIKE,
            spread=robust(paper)["z_std"].max(),
            ratios=tables["beside_song2002"].to_dict("records"),
            least=least_ratio(tables),
            other=pivot(shown["other_attacks"]),
            broken=pivot(shown["broken_meshes"]),
            blocks=by_blocks(tables["blocks"]) if "blocks" in tables else {},
            short={name: short(robust(table)) for name, table in shown.items() if len(table)}
            | {budget: short(at_budget(curve, budget)) for budget in LIRIS_BUDGETS if len(curve)},
            threshold=THRESHOLD,
            share=SHARE,
            strength=by_budget(tables["strength"]) if "strength" in tables else {},
            faintest=faintest(curve) if len(curve) else {},
            weakest=weakest(curve) if len(curve) else {},
            nulls=tables["nulls"].to_dict("records") if "nulls" in tables else [],
            counted=tables["random_keys"].to_dict("records") if "random_keys" in tables else [],
            others=others.to_dict("records"),
            ablation=ablation_table(ablation),
            ablation_keys=int(ablation["keys"].min()),
        )
        .rstrip()
        + "\n"
    )


def robust(table: pd.DataFrame) -> pd.DataFrame:
    """Return the lines of range-dct."""
    return table[table["scheme"].str.startswith("range-dct")]


def older_meshes(table: pd.DataFrame) -> list[str]:
    """Return the meshes that were read with a version before `READS_ALIKE`; empty if all or none were."""
    old = table.loc[table["version"] < READS_ALIKE, "mesh"].unique().tolist()
    return [] if len(old) == table["mesh"].nunique() else old


def pivot(detection: pd.DataFrame) -> dict[str, dict[str, dict[str, float]]]:
    """Return the lines of a table by attack and mesh, in the order of the configs; meshes as in the first."""
    lines: dict[str, dict[str, dict[str, float]]] = {}
    for mesh in detection["mesh"].unique() if len(detection) else ():
        for line in detection[detection["mesh"] == mesh].to_dict("records"):
            lines.setdefault(line["attack"], {})[mesh] = line
    return lines


def by_blocks(detection: pd.DataFrame) -> dict[str, dict[str, dict[int, dict[str, float]]]]:
    """Return the lines of a table by mesh, attack and number of blocks, fewest first."""
    detection = detection.assign(blocks=detection["scheme"].str.extract(r"blocks=(\d+)")[0].astype(int))
    lines: dict[str, dict[str, dict[int, dict[str, float]]]] = {}
    for line in detection.sort_values("blocks", kind="stable").to_dict("records"):
        lines.setdefault(line["mesh"], {}).setdefault(line["attack"], {})[line["blocks"]] = line
    return lines


def by_budget(detection: pd.DataFrame) -> dict[str, dict[str, dict[str, float]]]:
    """Return the lines of a table by attack and budget, in the order of the config."""
    lines: dict[str, dict[str, dict[str, float]]] = {}
    for line in detection.to_dict("records"):
        lines.setdefault(line["attack"], {})[line["scheme"].split(" at SNR ")[1]] = line
    return lines


def faintest(table: pd.DataFrame) -> dict[str, dict[str, float]]:
    """Return the faintest mark that held, in MRMS, by attack and mesh."""
    lines: dict[str, dict[str, float]] = {}
    for line in held(table).to_dict("records"):
        lines.setdefault(line["attack"], {})[line["mesh"]] = line["faintest_mrms_percent"]
    return lines


def ablation_table(table: pd.DataFrame) -> dict[str, dict[str, dict[str, float]]]:
    """Return z by mesh, ingredient and attack."""
    lines: dict[str, dict[str, dict[str, float]]] = {}
    for line in table.to_dict("records"):
        lines.setdefault(line["mesh"], {}).setdefault(line["without"], {})[line["attack"]] = line["z_mean"]
    return lines


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=Path, default=Path("runs/range_dct"), help="where the runs are kept")
    parser.add_argument("--trials", type=int, help="keys a cell, instead of those of the configs")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--report-only", action="store_true", help="run nothing")
    options = parser.parse_args()
    if not options.report_only:
        run_all(options.runs, options.trials, options.workers)
    write_results(options.runs)
