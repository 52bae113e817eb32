"""Fill `benchmark_readme.md.j2`, the page that says who survives what, from the tables of the benchmark."""

from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment, StrictUndefined

from wm3d.bench.summary import DETECTED, LOST, quoted_pf

TEMPLATE = Path(__file__).with_name("benchmark_readme.md.j2")
FAMILIES = {
    "none, order, pose": ("clean", "reorder", "similarity"),
    "noise": ("gaussian-noise", "uniform-noise"),
    "smoothing": ("laplacian-smoothing",),
    "quantization": ("quantize",),
    "subdivision": ("subdivide",),
    "simplification": ("simplify",),
    "cropping": ("crop",),
}
"""Attacks by name; one of none of them is a family of its own."""


def readme(tables: Path, board: dict[str, Any], manifest: dict[str, Any], minutes: float) -> str:
    """Return the page.

    Parameters
    ----------
    tables : Path
        Folder of the tables of the run.
    board : dict
        Content of leaderboard.json.
    manifest : dict
        Content of manifest.json.
    minutes : float
        That one processor was busy.
    """
    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    environment.tests["startswith"] = str.startswith
    calibration, detection, axes = (
        pd.read_csv(tables / f"{name}.csv", keep_default_na=True)
        for name in ("calibration", "detection", "axes")
    )
    named = calibration.drop_duplicates("scheme").set_index("scheme")[["method", "budget"]]
    detection = detection.join(named, on="scheme")
    detection["found"] = detection[f"pd_{quoted_pf([board['pf']]):g}"]
    for table in (detection, axes):
        table["family"] = table["attack"].map(family)
    page = environment.from_string(TEMPLATE.read_text(encoding="utf-8")).render(
        board=board,
        manifest=manifest,
        minutes=minutes,
        detected=DETECTED,
        lost=LOST,
        budgets=[budget["label"] for budget in board["budgets"]],
        shares={budget: shares(group) for budget, group in detection.groupby("budget", sort=False)},
        leaders=leaders(detection, blind(board)),
        verdicts=verdicts(detection, blind(board)),
        angles=angles(axes, detection, named),
        left_out=calibration["error"].dropna().tolist(),
    )
    return page.rstrip() + "\n"


def family(attack: str) -> str:
    """Return the family of an attack from its label."""
    name = attack.partition(" ")[0]
    return next((family for family, names in FAMILIES.items() if name in names), name)


def blind(board: dict[str, Any]) -> list[str]:
    """Return the schemes that read without the original."""
    return list(dict.fromkeys(entry["scheme"] for entry in board["entries"] if entry["blind"]))


def shares(detection: pd.DataFrame) -> pd.DataFrame:
    """Return mean Pd by scheme and family."""
    order = list(dict.fromkeys(detection["family"]))
    table = detection.groupby(["method", "family"])["found"].mean().unstack()[order]
    return table.loc[table.mean(axis=1).sort_values(ascending=False, kind="stable").index]


def leaders(detection: pd.DataFrame, blind: list[str]) -> list[dict[str, Any]]:
    """Return for each family the blind schemes that find most and least, over all budgets."""
    lines = []
    kept = detection[detection["method"].isin(blind)]
    for name, group in kept.groupby("family", sort=False):
        means = group.groupby("method")["found"].mean().sort_values(kind="stable")
        best, worst = (means.index[means.round(9) == round(end, 9)] for end in (means.max(), means.min()))
        lines.append(
            {
                "family": name,
                "best": list(best),
                "most": means.max(),
                "worst": list(worst),
                "least": means.min(),
            }
        )
    return lines


def verdicts(detection: pd.DataFrame, blind: list[str]) -> dict[str, list[str]]:
    """Return the attacks that every blind scheme survives, and those that every one is lost to."""
    means = (
        detection[detection["method"].isin(blind)].groupby(["attack", "scheme"], sort=False)["found"].mean()
    )
    by_attack = means.groupby("attack", sort=False)
    least, most = by_attack.min(), by_attack.max()
    return {"all": list(least.index[least >= DETECTED]), "none": list(most.index[most < LOST])}


def angles(axes: pd.DataFrame, detection: pd.DataFrame, named: pd.DataFrame) -> list[dict[str, Any]]:
    """Return, for schemes that pose the model, the axes' mean angle and Pd in each family that turns them."""
    joined = axes.join(named, on="scheme")
    joined = joined[joined["mean_deg"].notna() | (joined["flipped"] > 0)]
    lines = []
    for (method, name), group in joined.groupby(["method", "family"], sort=False):
        found = detection[(detection["method"] == method) & (detection["family"] == name)]["found"].mean()
        lines.append(
            {
                "method": method,
                "family": name,
                "degrees": group["mean_deg"].mean(),
                "flipped": group["flipped"].mean(),
                "found": found,
            }
        )
    return lines
