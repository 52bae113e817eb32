"""Curves of a run as figures: the ROC of its rows, and counted false alarms beside exact ones."""

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import cycle, groupby
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from wm3d.arrays import FloatArray
from wm3d.bench.figures import COLORS, SIGMA_CAPTION, attack_name, caption, power_of_ten, styled
from wm3d.bench.tables import Sigmas, cells
from wm3d.stats import d_prime, roc

LEAST_LOG10_PF = -8
"""Left end of the ROC curves; the paper counted no further."""

NULL_CAPTION = (
    "Statistic: z of the detector, large is marked. Null: uniform keys on the mesh under test, exact. "
    "A trial is detected if its p-value is at most Pf. Bands: 95 % Clopper–Pearson."
)
"""What a reader must know to read Pf, under every ROC figure."""

FALSE_ALARM_CAPTION = (
    "Counted: share of random keys whose z reaches a threshold, from 10/Pf keys on, with its 95 % interval "
    "over batches of keys. Exact: tail of the key null. Both on the attacked mesh of one trial."
)
"""What a reader must know under a figure of counted false alarms."""

POINT_EVERY = 4
"""Thresholds from one point of a false-alarm curve to the next; the table has them all."""

TITLE_WIDTH = 72
"""Characters of a panel's title in one line."""

DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (5, 1.5, 1, 1.5)), (0, (1, 1)))


def roc_figure(rows: pd.DataFrame, credits: Mapping[str, str | None], sigmas: Sigmas | None = None) -> Figure:
    """Draw Pd against log10 Pf, a panel for each mesh and scheme, a curve for each attack.

    Each trial is held to Pf by the exact key null of its own mesh; bands are 95 % Clopper–Pearson. Where the
    attacks are more than there are colours, those that the mark always survives share one curve and the
    others several panels.

    Parameters
    ----------
    rows : DataFrame
    credits : mapping of str to str or None
        Line that a figure of a mesh must carry, by its name.
    sigmas : mapping of str to mapping of str to float, optional
        Noise in its common unit, by mesh and label of the attack.
    """
    cases: dict[tuple[str, str], dict[str, pd.DataFrame]] = {}
    for (mesh, scheme, attack), group in cells(rows, "H1"):
        cases.setdefault((mesh, scheme), {})[attack] = group
    panels, noise = [], sigmas or {}
    for (mesh, scheme), attacks in cases.items():
        keys = max(map(len, attacks.values()))
        title = textwrap.fill(f"{mesh}, {scheme}, {keys} keys", TITLE_WIDTH)
        panels += [(title, curves) for curves in _shared_out(_curves(attacks, keys, noise.get(mesh, {})))]
    heights = [3.5 + 0.17 * _legend_lines(curves) for _, curves in panels]
    with styled():
        figure = Figure(figsize=(6.4, sum(heights) + 0.5), layout=ConstrainedLayoutEngine(hspace=0.05))
        axes = figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights)[:, 0]
        for panel, (title, curves) in zip(axes, panels, strict=True):
            panel.set_title(title, loc="left", fontsize=10)
            _roc_panel(panel, curves)
        text = NULL_CAPTION + (SIGMA_CAPTION if any(noise.values()) else "")
        caption(figure, text, [mesh for mesh, _ in cases], credits)
    return figure


@dataclass(frozen=True, eq=False)
class _Curve:
    """One line: label, family of the attack, sorted p-values with those off the picture at its edge."""

    label: str
    family: str
    log10_p: FloatArray

    def steps(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the corners of the exact curve, log10 Pf and Pd with its band; Pd jumps at the p-values."""
        grid = np.unique(np.concatenate([[LEAST_LOG10_PF], self.log10_p, [0.0]]))
        curve = roc(self.log10_p, grid)
        return grid, curve.pd, curve.low, curve.high


def _curves(attacks: Mapping[str, pd.DataFrame], keys: int, sigmas: Mapping[str, float]) -> list[_Curve]:
    curves = []
    for attack, group in attacks.items():
        scored = group[group["log10_p"].notna()]
        name = attack_name(attack, [sigmas.get(attack, np.nan)])
        distance = f"d′ = {d_prime(scored['z']):.1f}" if len(scored) else "failed"
        label = textwrap.fill(f"{name}: {distance}", 80)
        label += f" ({len(scored)} of {keys} keys)" if len(scored) < keys else ""
        log10_p = np.sort(np.maximum(scored["log10_p"].to_numpy(np.float64), LEAST_LOG10_PF))
        curves.append(_Curve(label, attack.partition(" ")[0], log10_p))
    certain = [curve for curve in curves if np.array_equal(curve.log10_p, [LEAST_LOG10_PF] * keys)]
    if len(curves) > len(COLORS) and len(certain) > 1:
        together = _Curve(f"{len(certain)} attacks: Pd = 1 throughout", "", certain[0].log10_p)
        curves = [together, *(curve for curve in curves if curve not in certain)]
    return curves


def _shared_out(curves: list[_Curve]) -> Iterator[list[_Curve]]:
    """Share out the curves so that a panel repeats no colour and breaks no family of attacks in two.

    A family with more members than there are colours is broken all the same.
    """
    panel: list[_Curve] = []
    for _, members in groupby(curves, key=lambda curve: curve.family):
        family = list(members)
        if panel and len(panel) + len(family) > len(COLORS):
            yield panel
            panel = []
        for curve in family:
            if len(panel) == len(COLORS):
                yield panel
                panel = []
            panel.append(curve)
    yield panel


def _legend_columns(curves: list[_Curve]) -> int:
    return 2 if max(len(curve.label) for curve in curves) < 52 else 1


def _legend_lines(curves: list[_Curve]) -> int:
    lines = 1 + sum(1 + curve.label.count("\n") for curve in curves)
    return -(-lines // _legend_columns(curves))


def _roc_panel(panel: Axes, curves: list[_Curve]) -> None:
    """Draw the curves; those that coincide everywhere share one line, striped in the colours of all."""
    coinciding: dict[bytes, list[int]] = {}
    for k, curve in enumerate(curves):
        coinciding.setdefault(curve.log10_p.tobytes(), []).append(k)
    dashes = cycle(DASHES)
    handles: list[Line2D] = [Line2D([], [])] * len(curves)
    for together in coinciding.values():
        alone = len(together) == 1
        grid, pd_, low, high = curves[together[0]].steps()
        if len(curves[together[0]].log10_p):
            color = COLORS[together[0]] if alone else "0.5"
            panel.fill_between(grid, low, high, step="post", color=color, alpha=0.13, linewidth=0)
        for place, k in enumerate(together):
            look: Any = next(dashes) if alone else _stripe(place, len(together))
            panel.step(
                grid, pd_, where="post", color=COLORS[k], linestyle=look, linewidth=1.7 if alone else 3.4,
                zorder=3 if alone else 2.5, dash_capstyle="butt",
            )  # fmt: skip
            handles[k] = Line2D(
                [], [], color=COLORS[k], linestyle=look if alone else "-", linewidth=2, label=curves[k].label
            )
    grid = np.linspace(LEAST_LOG10_PF, 0, 161)
    handles += panel.plot(
        grid, 10**grid, color="0.5", linewidth=0.8, linestyle=(0, (2, 2)), label="chance: Pd = Pf"
    )
    panel.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(-0.02, -0.15), fontsize=7, borderaxespad=0,
        ncols=_legend_columns(curves), handlelength=2.4, columnspacing=1.2,
    )  # fmt: skip
    _decades(panel, LEAST_LOG10_PF)
    panel.set(ylim=(-0.02, 1.04), xlabel="Pf", ylabel="Pd")


def _stripe(k: int, of: int) -> tuple[float, tuple[float, float]]:
    """Dash pattern of the k-th of several coinciding lines: each shows in the gaps of the others."""
    on = 3.0
    return ((of - k) % of * on, (on, (of - 1) * on))


def _decades(panel: Axes, least: int) -> None:
    decades = range(least, 1)
    panel.set_xticks(list(decades), [power_of_ten(decade) for decade in decades])
    panel.set_xlim(least, 0)


def false_alarm_figure(
    table: pd.DataFrame, credits: Mapping[str, str | None], sigmas: Sigmas | None = None
) -> Figure:
    """Draw counted Pf over exact Pf against exact Pf, a panel for each mesh and scheme, points by attack.

    Parameters
    ----------
    table : DataFrame
        `wm3d.bench.tables.counted`.
    credits, sigmas
        As for `roc_figure`.
    """
    cases, noise = list(table.groupby(["mesh", "scheme"], sort=False)), sigmas or {}
    with styled():
        figure = Figure(figsize=(6.4, 3.4 * len(cases) + 0.4), layout="constrained")
        axes = figure.subplots(len(cases), 1, squeeze=False)[:, 0]
        for panel, ((mesh, scheme), group) in zip(axes, cases, strict=True):
            title = f"{mesh}, {scheme}, {group['keys'].max():,} keys an attack"
            panel.set_title(textwrap.fill(title, TITLE_WIDTH), loc="left", fontsize=10)
            _ratio_panel(panel, group, noise.get(str(mesh), {}))
        text = FALSE_ALARM_CAPTION + (SIGMA_CAPTION if any(noise.values()) else "")
        caption(figure, text, dict.fromkeys(table["mesh"]), credits)
    return figure


def _ratio_panel(panel: Axes, table: pd.DataFrame, sigmas: Mapping[str, float]) -> None:
    attacks = list(table.groupby("attack", sort=False))
    for k, ((attack, curve), color) in enumerate(zip(attacks, cycle(COLORS), strict=False)):
        quoted = curve[curve["pf"].notna() & (curve["z"] > 0)].iloc[::POINT_EVERY]
        exact = 10 ** quoted["log10_pf_exact"]
        low, ratio, high = (quoted[column] / exact for column in ("pf_low", "pf", "pf_high"))
        beside = quoted["log10_pf_exact"] + 0.025 * (
            k - (len(attacks) - 1) / 2
        )  # or they would hide each other
        panel.errorbar(
            beside, ratio, [ratio - low, high - ratio], fmt=".", markersize=4, linewidth=0.9, color=color,
            label=attack_name(str(attack), [sigmas.get(str(attack), np.nan)]),
        )  # fmt: skip
    panel.axhline(1, color="0.5", linewidth=0.8)
    least = int(np.floor(table.loc[table["pf"].notna(), "log10_pf_exact"].to_numpy().min(initial=-1)))
    _decades(panel, least)
    panel.set(xlabel="exact Pf", ylabel="counted Pf / exact Pf", ylim=(0, 2))
    panel.legend(fontsize=7, loc="upper right", ncols=2)
