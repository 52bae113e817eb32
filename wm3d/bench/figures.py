"""Figures of a run: pure functions of its rows."""

import io
import re
import textwrap
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import cycle
from typing import Any, cast

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D

from wm3d.arrays import FloatArray
from wm3d.bench.store import RunDirectory
from wm3d.bench.tables import cells
from wm3d.mesh import write_whole
from wm3d.stats import d_prime, roc

LEAST_LOG10_PF = -8
"""Left end of the ROC curves; the paper counted no further."""

NULL_CAPTION = (
    "Statistic: z of the detector, large is marked. Null: uniform keys on the mesh under test, exact "
    "(saddlepoint tail). A trial is detected if its p-value is at most Pf. Bands: 95 % Clopper–Pearson."
)
"""What a reader must know to read Pf, under every ROC figure."""

FALSE_ALARM_CAPTION = (
    "Counted: share of random keys whose z reaches a threshold, from 10/Pf keys on, with its 95 % interval "
    "over batches of keys. Exact: tail of the key null. Both on the attacked mesh of one trial."
)
"""What a reader must know under a figure of counted false alarms."""

POINT_EVERY = 4
"""Thresholds from one point of a false-alarm curve to the next; the table has them all."""

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
"""Okabe and Ito's palette for all kinds of colour vision, without the yellow that white paper swallows."""

DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (5, 1.5, 1, 1.5)), (0, (1, 1)))

STYLE: dict[str, Any] = {
    "figure.dpi": 150,
    "font.family": "DejaVu Sans",  # comes with matplotlib, so every machine draws the same
    "font.size": 9,
    "text.parse_math": False,  # names of meshes may hold dollars
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "svg.hashsalt": "wm3d",
    "svg.fonttype": "none",
}


def roc_figure(rows: pd.DataFrame, credits: Mapping[str, str | None]) -> Figure:
    """Draw Pd against log10 Pf, a panel for each mesh and scheme, a curve for each attack.

    Each trial is held to Pf by the exact key null of its own mesh; bands are 95 % Clopper–Pearson. A panel
    whose attacks are more than there are colours is split.

    Parameters
    ----------
    rows : DataFrame
    credits : mapping of str to str or None
        Line that a figure of a mesh must carry, by its name.
    """
    cases: dict[tuple[str, str], dict[str, pd.DataFrame]] = {}
    for (mesh, scheme, attack), group in cells(rows, "H1"):
        cases.setdefault((mesh, scheme), {})[attack] = group
    panels = [(case, attacks) for case, curves in cases.items() for attacks in _panels(curves)]
    heights = [3.5 + 0.17 * _legend_rows(attacks) for _, attacks in panels]
    with _style():
        figure = Figure(figsize=(6.4, sum(heights) + 0.5), layout=ConstrainedLayoutEngine(hspace=0.05))
        axes = figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights)[:, 0]
        for panel, ((mesh, scheme), attacks) in zip(axes, panels, strict=True):
            curves = {attack: cases[mesh, scheme][attack] for attack in attacks}
            keys = max(map(len, curves.values()))
            panel.set_title(textwrap.fill(f"{mesh}, {scheme}, {keys} keys", 85), loc="left", fontsize=10)
            _roc_panel(panel, curves)
        _caption(figure, NULL_CAPTION, [mesh for mesh, _ in cases], credits)
    return figure


def _caption(figure: Figure, text: str, meshes: Iterable[str], credits: Mapping[str, str | None]) -> None:
    owed = list(dict.fromkeys(filter(None, map(credits.get, meshes))))
    text += f" Meshes: {'; '.join(owed)}." if owed else ""
    figure.supxlabel(textwrap.fill(text, 125), fontsize=6.5, x=0.01, ha="left", color="0.45")


def _panels(attacks: Mapping[str, object]) -> Iterator[list[str]]:
    """Share out the attacks so that a panel repeats no colour and breaks no family of attacks in two.

    A family with more members than there are colours is broken all the same.
    """
    panel: list[str] = []
    families: dict[str, list[str]] = {}
    for attack in attacks:
        families.setdefault(attack.partition(" ")[0], []).append(attack)
    for family in families.values():
        if panel and len(panel) + len(family) > len(COLORS):
            yield panel
            panel = []
        for attack in family:
            if len(panel) == len(COLORS):
                yield panel
                panel = []
            panel.append(attack)
    yield panel


def _legend_rows(attacks: list[str]) -> int:
    return -(-(len(attacks) + 1) // _legend_columns(attacks))


def _legend_columns(attacks: list[str]) -> int:
    return 2 if max(map(len, attacks)) < 42 else 1


def _roc_panel(panel: Axes, curves: Mapping[str, pd.DataFrame]) -> None:
    """Draw the curves; those that coincide everywhere share one line, striped in the colours of all."""
    coinciding: dict[bytes, list[str]] = {}
    colors = dict(zip(curves, COLORS, strict=False))
    logs = {
        attack: np.sort(np.maximum(group["log10_p"].dropna().to_numpy(np.float64), LEAST_LOG10_PF))
        for attack, group in curves.items()
    }
    for attack, log10_p in logs.items():
        coinciding.setdefault(log10_p.tobytes(), []).append(attack)
    dashes = cycle(DASHES)
    styles: dict[str, Any] = {}
    for together in coinciding.values():
        _band(panel, logs[together[0]], colors[together[0]] if len(together) == 1 else "0.5")
        for k, attack in enumerate(together):
            styles[attack] = next(dashes) if len(together) == 1 else _stripe(k, len(together))
            grid, pd_ = _steps(logs[attack])[:2]
            width = 1.7 if len(together) == 1 else 3.4
            panel.step(
                grid, pd_, where="post", color=colors[attack], linestyle=styles[attack], linewidth=width,
                zorder=3 if len(together) == 1 else 2.5, dash_capstyle="butt",
            )  # fmt: skip
    chance = np.linspace(LEAST_LOG10_PF, 0, 161)
    panel.plot(chance, 10**chance, color="0.5", linewidth=0.8, linestyle=(0, (2, 2)))
    _decorate(panel, curves, colors, styles)


def _steps(log10_p: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Corners of an exact step curve: log10 Pf, Pd and its band; Pd jumps where Pf meets a p-value."""
    grid = np.unique(np.concatenate([[LEAST_LOG10_PF], log10_p, [0.0]]))
    curve = roc(log10_p, grid)
    return grid, curve.pd, curve.low, curve.high


def _band(panel: Axes, log10_p: FloatArray, color: str) -> None:
    grid, _, low, high = _steps(log10_p)
    if len(log10_p):
        panel.fill_between(grid, low, high, step="post", color=color, alpha=0.13, linewidth=0)


def _stripe(k: int, of: int) -> tuple[float, tuple[float, float]]:
    """Dash pattern of the k-th of several coinciding lines: each shows in the gaps of the others."""
    on = 3.0
    return ((of - k) % of * on, (on, (of - 1) * on))


def _decorate(
    panel: Axes, curves: Mapping[str, pd.DataFrame], colors: Mapping[str, str], styles: Mapping[str, Any]
) -> None:
    handles = []
    keys = max(len(group) for group in curves.values())
    for attack, group in curves.items():
        scored = group[group["log10_p"].notna()]
        label = f"{attack}: d′ = {d_prime(scored['z']):.1f}"
        label += f" ({len(scored)} of {keys} keys)" if len(scored) < keys else ""
        style: Any = styles[attack] if styles[attack] in DASHES else "-"
        handles.append(Line2D([], [], color=colors[attack], linestyle=style, linewidth=2, label=label))
    handles.append(Line2D([], [], color="0.5", linewidth=0.8, linestyle=(0, (2, 2)), label="chance: Pd = Pf"))
    panel.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(-0.02, -0.15), fontsize=7, borderaxespad=0,
        ncols=_legend_columns(list(curves)), handlelength=2.4, columnspacing=1.2,
    )  # fmt: skip
    decades = range(LEAST_LOG10_PF, 1)
    panel.set_xticks(list(decades), [power_of_ten(decade) for decade in decades])
    panel.set(xlim=(LEAST_LOG10_PF, 0), ylim=(-0.02, 1.04), xlabel="Pf", ylabel="Pd")


def false_alarm_figure(table: pd.DataFrame, credits: Mapping[str, str | None]) -> Figure:
    """Draw counted Pf over exact Pf against exact Pf, a panel for each mesh and scheme, points by attack.

    Parameters
    ----------
    table : DataFrame
        `wm3d.bench.tables.counted`.
    credits : mapping of str to str or None
        As for `roc_figure`.
    """
    cases = list(table.groupby(["mesh", "scheme"], sort=False))
    with _style():
        figure = Figure(figsize=(6.4, 3.4 * len(cases) + 0.4), layout="constrained")
        axes = figure.subplots(len(cases), 1, squeeze=False)[:, 0]
        for panel, ((mesh, scheme), group) in zip(axes, cases, strict=True):
            title = f"{mesh}, {scheme}, {group['keys'].max():,} keys an attack"
            panel.set_title(textwrap.fill(title, 85), loc="left", fontsize=10)
            _ratio_panel(panel, group)
        _caption(figure, FALSE_ALARM_CAPTION, dict.fromkeys(table["mesh"]), credits)
    return figure


def _ratio_panel(panel: Axes, table: pd.DataFrame) -> None:
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
            label=str(attack),
        )  # fmt: skip
    panel.axhline(1, color="0.5", linewidth=0.8)
    least = int(np.floor(table.loc[table["pf"].notna(), "log10_pf_exact"].to_numpy().min(initial=-1)))
    decades = range(least, 1)
    panel.set_xticks(list(decades), [power_of_ten(decade) for decade in decades])
    panel.set(xlabel="exact Pf", ylabel="counted Pf / exact Pf", ylim=(0, 2), xlim=(least, 0))
    panel.legend(fontsize=7, loc="upper right", ncols=2)


def power_of_ten(exponent: float) -> str:
    """Write 10^exponent with superscripts, and 1 for 10^0."""
    digits = str.maketrans("-0123456789.", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹·")
    return "10" + f"{exponent:g}".translate(digits) if exponent else "1"


def save(figure: Figure, directory: RunDirectory, name: str) -> str:
    """Write figures/NAME.png and figures/NAME.svg, the same bytes for the same figure; return the SVG."""
    png, svg = _drawn(figure, "png", "Software"), _drawn(figure, "svg", "Date", "Creator", "Format", "Type")
    write_whole(directory.path / "figures" / f"{name}.png", png)
    write_whole(directory.path / "figures" / f"{name}.svg", svg)
    return svg.decode()


def _drawn(figure: Figure, ending: str, *left_out: str) -> bytes:
    buffer = io.BytesIO()
    with _style(), warnings.catch_warnings():
        # of a mesh named in another script
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        figure.savefig(buffer, format=ending, metadata=dict.fromkeys(left_out))
    return buffer.getvalue()


def inline_svg(svg: str, name: str) -> str:
    """Turn the SVG file of a figure into an element of HTML, on no ground, black as the text around it.

    Parameters
    ----------
    svg : str
    name : str
        Unique in the page; put before every id of the drawing.
    """
    svg = svg[svg.index("<svg") :].strip()
    svg = re.sub(r"<style.*?</style>", "", svg, flags=re.DOTALL)  # it would style the whole page
    svg = re.sub(r'\b(id="|href="#|url\(#)', rf"\g<1>{name}-", svg)
    svg = re.sub(r'<svg([^>]*?) width="[^"]*" height="[^"]*"', r"<svg\1", svg, count=1)
    return svg.replace("fill: #ffffff", "fill: none").replace("#000000", "currentColor")


@contextmanager
def _style() -> Iterator[None]:
    # matplotlib types its parameters by literal names, which a plain dict cannot meet
    with mpl.rc_context(cast("Any", STYLE)):
        yield
