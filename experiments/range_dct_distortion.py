"""Pd of range-dct against the distortion of its mark: the table and the figures of results/range_dct."""

import math
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from wm3d.bench.figures import COLORS, caption, styled
from wm3d.mesh import datasets

PF = 1e-6
LIRIS_BUDGETS = (0.02, 0.08)
"""MRMS in % of the diagonal that the LIRIS benchmark allows (Wang et al., SMI 2010)."""

CLOSE = 0.05
"""How near to a budget, relatively, a calibrated mark comes."""

AXES = {
    "mrms_percent": "MRMS of the mark in % of the diagonal",
    "snr_db": "SNR of the mark in dB",
}
ACROSS = 3


def distortion(run: Path) -> pd.DataFrame:
    """Return Pd and z of each mesh, attack and budget, with the MRMS and the SNR of the marks."""
    tables = {
        name: pd.read_csv(run / "tables" / f"{name}.csv") for name in ("detection", "calibration", "snr")
    }
    both = ["mesh", "scheme"]
    found = [f"pd_{pf:g}{end}" for pf in (PF, 1e-12) for end in ("", "_low", "_high")]
    kept = ["attack", "trials", "z_mean", "z_std", *found]
    reached = tables["calibration"].set_index(both)["reached"].rename("mrms_percent")
    snr = tables["snr"].set_index(both)["snr_db"]
    return tables["detection"][both + kept].join(reached, on=both).join(snr, on=both)


def by_strength(table: pd.DataFrame) -> pd.DataFrame:
    """Return the lines in the order of the curves, the faintest mark first."""
    return table.sort_values(["mesh", "attack", "mrms_percent"], kind="stable", ignore_index=True)


def held(table: pd.DataFrame) -> pd.DataFrame:
    """Return the faintest mark that was always found, as were all louder ones, by attack and mesh."""
    lines = []
    for attack in dict.fromkeys(table["attack"]):
        for mesh, group in table[table["attack"] == attack].groupby("mesh", sort=False):
            loud_first = group.sort_values("mrms_percent", ascending=False)
            found = (loud_first[f"pd_{PF:g}"] == 1).cumprod().astype(bool)
            faintest = loud_first.loc[found, "mrms_percent"].min()
            lines.append({"attack": attack, "mesh": mesh, "faintest_mrms_percent": faintest})
    return pd.DataFrame(lines)


def at_budget(table: pd.DataFrame, budget: float) -> pd.DataFrame:
    """Return the lines of the marks of this MRMS."""
    return table[(table["mrms_percent"] / budget - 1).abs() < CLOSE]


def weakest(table: pd.DataFrame) -> dict[float, dict[str, Any]]:
    """Return, for each of `LIRIS_BUDGETS`, the line of least mean z."""
    return {
        budget: at_budget(table, budget).nsmallest(1, "z_mean").to_dict("records")[0]
        for budget in LIRIS_BUDGETS
    }


def curves(table: pd.DataFrame, against: str) -> Figure:
    """Draw Pd at `PF` against one of `AXES`: a panel an attack that a mark is lost to, a line a mesh."""
    attacks = list(dict.fromkeys(table.loc[table[f"pd_{PF:g}"] < 1, "attack"]))
    meshes = list(dict.fromkeys(table["mesh"]))
    rows = math.ceil(len(attacks) / ACROSS)
    with styled():
        figure = Figure(figsize=(9.4, 2.3 * rows + 1.0), layout="constrained")
        panels = figure.subplots(rows, ACROSS, sharex=True, sharey=True, squeeze=False).ravel()
        for panel, attack in zip(panels, attacks, strict=False):
            for order, (color, mesh) in enumerate(zip(COLORS, meshes, strict=False)):
                line = table[(table["attack"] == attack) & (table["mesh"] == mesh)].sort_values(against)
                low, high = line[f"pd_{PF:g}_low"], line[f"pd_{PF:g}_high"]
                wide = 1.3 * (len(meshes) - order)  # so that equal lines show below each other
                panel.plot(line[against], line[f"pd_{PF:g}"], color=color, linewidth=wide, label=mesh)
                panel.fill_between(line[against], low, high, color=color, alpha=0.08, linewidth=0)
            if against == "mrms_percent":
                panel.set_xscale("log")
                budgets = sorted(set(table[against].round(2)))
                panel.set_xticks(budgets, [f"{budget:g}" for budget in budgets])
                panel.minorticks_off()
                for budget in LIRIS_BUDGETS:
                    panel.axvline(budget, color="0.5", linewidth=0.8, linestyle="--")
            panel.set_title(attack, fontsize=8)
            panel.set_ylim(-0.03, 1.03)
            panel.tick_params(labelbottom=True)
        for panel in panels[len(attacks) :]:
            panel.set_axis_off()
        figure.supylabel(f"Pd at Pf = {PF:g}", fontsize=9)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(meshes), title=AXES[against])
        fewest, most = table["trials"].min(), table["trials"].max()
        keys = f"{fewest} to {most}" if most > fewest else f"{most}"
        text = (
            f"{keys} keys a point. Statistic: z of the detector, large is marked. Null: "
            "uniform keys on the mesh under test, exact. Bands: 95 % Clopper–Pearson. Not drawn: "
            f"{table['attack'].nunique() - len(attacks)} attacks after which every mark was found."
        )
        if against == "mrms_percent":
            text += " Dashed: budgets of the LIRIS benchmark."
        caption(figure, text, meshes, {mesh: datasets.credit(mesh) for mesh in meshes})
    return figure
