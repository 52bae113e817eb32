"""The heat map of a run: Pd and d' of every attack on every mesh with every scheme, a number in each cell."""

import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PatchCollection
from matplotlib.colors import LinearSegmentedColormap, Normalize, to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from scipy.stats import norm

from wm3d.arrays import FloatArray
from wm3d.bench.figures import SIGMA_CAPTION, attack_name, caption, keys, power_of_ten, styled

LEAST_ATTACKS = 4
"""A run of fewer attacks has its table; a picture of it would hold nothing to see."""

LOST, BETWEEN, FOUND = "#d55e00", "#f0ece4", "#0072b2"
"""Colours of cells: apart for all kinds of colour vision."""

UNTRIED = "#d0d0d0"
REFUSED = "×"
"""Where the scheme marked the mesh with no key."""

DARK_INK, LIGHT_INK = "#1c2024", "#fdfdfd"
"""Numbers on light and on dark cells: no plain black and white, which the report turns round at night."""

LUMINANCE, DARK_BELOW = np.array([0.299, 0.587, 0.114]), 0.58
"""Weights of red, green and blue (ITU-R BT.601), and up to where a cell is dark."""

CELL = 0.36, 0.21
"""Least width, and height, of a cell in inches."""

LEAST_WIDTH = 2.4
"""Least width of a panel in inches."""

MOST_BESIDE = 9
"""Columns up to which d' stands beside Pd and not below."""

GROUP_GAP = 0.35
"""Space between groups of columns, in widths of a cell."""

CHARACTER = 0.063
"""Width of a character of a heading in inches, about."""

HEADING_WIDTH = 30
"""Characters in one line of an upright heading."""

D_PRIME_SPAN = 3.0
"""The colours of d' end at this many times the z at which a mark is detected."""


@dataclass(frozen=True, eq=False)
class _Grid:
    """One table as a picture: `values` and `texts` (attacks, columns).

    A value is NaN where nothing was tried, and infinite where the mesh was refused.
    """

    title: str
    values: FloatArray
    texts: list[list[str]]
    middle: float
    top: float

    def colors(self) -> tuple[Normalize, LinearSegmentedColormap]:
        """Return the scale from 0 to `top`, with the change of colour at `middle`."""
        nodes = [(0.0, LOST), (self.middle / self.top, BETWEEN), (1.0, FOUND)]
        return Normalize(0, self.top, clip=True), LinearSegmentedColormap.from_list(self.title, nodes)


def heatmap_figure(detection: pd.DataFrame, pf: float, credits: Mapping[str, str | None]) -> Figure:
    """Draw Pd at one Pf, and d', a row for each attack and a column for each mesh and scheme.

    Where there are several schemes, those on one mesh stand side by side.

    Parameters
    ----------
    detection : DataFrame
        `wm3d.bench.tables.detection`.
    pf : float
        One of the Pf that the table quotes.
    credits : mapping of str to str or None
        Line that a figure of a mesh must carry, by its name.
    """
    columns = sorted(
        dict.fromkeys(zip(detection["mesh"], detection["scheme"], strict=True)),
        key=lambda column: list(detection["mesh"]).index(column[0]),
    )
    attacks = list(dict.fromkeys(detection["attack"]))
    names = [
        attack_name(str(attack), detection.loc[detection["attack"] == attack, "sigma_percent"])
        for attack in attacks
    ]
    beside = len(columns) <= MOST_BESIDE
    rows, across = (1, 2) if beside else (2, 1)
    labels, _ = _headings(columns)
    width = _cell_width(len(columns)) * len(columns)
    above = _heading_height(labels) if _upright(labels, _cell_width(len(columns))) else 0.15
    with styled():
        size = (
            0.062 * max(map(len, names)) + across * (width + 0.1) + 0.1,
            rows * (CELL[1] * len(attacks) + above + 0.9) + 0.5,
        )
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(rows, across, squeeze=False, sharey=beside).ravel()
        for panel, grid in zip(panels, _grids(detection, attacks, columns, pf), strict=True):
            _draw(panel, grid, names, columns)
        for panel in panels[1:across]:
            panel.tick_params(labelleft=False)
        text = (
            f"Pd: share of {keys(detection)} keys found, each held to Pf by the exact key null of its own "
            "mesh; where a mesh cannot be read, the mark is not found. d′: mean of z, whose null has mean 0 "
            f"and variance 1. Its colour turns at z = {norm.isf(pf):.2f}, from which a mark is found. "
            "95 % intervals stand in the table of detection."
        )
        if (_refused(detection) > 0).any():
            text += f" {REFUSED}: the scheme refused to mark the mesh."
        if detection["sigma_percent"].notna().any():
            text += SIGMA_CAPTION
        caption(figure, text, dict.fromkeys(detection["mesh"]), credits)
    return figure


def _cell_width(columns: int) -> float:
    return max(CELL[0], LEAST_WIDTH / columns)


def _grids(
    detection: pd.DataFrame, attacks: list[str], columns: list[tuple[str, str]], pf: float
) -> tuple[_Grid, _Grid]:
    # chance alone reaches a Pf of a half and more
    found, threshold = f"pd_{pf:g}", max(float(norm.isf(pf)), 0.1)
    by_cell = detection.set_index(["attack", "mesh", "scheme"])
    cells = pd.MultiIndex.from_tuples([(attack, *column) for attack in attacks for column in columns])
    shape = len(attacks), len(columns)
    refused = (_refused(by_cell).reindex(cells) > 0).to_numpy().reshape(shape)
    pd_, d = (
        np.where(refused, np.inf, by_cell[name].reindex(cells).to_numpy(np.float64).reshape(shape))
        for name in (found, "d_prime")
    )
    return (
        _Grid(f"Pd at Pf = {power_of_ten(np.log10(pf))}", pd_, _written(pd_, 2), 0.5, 1.0),
        _Grid("d′", d, _written(d, 1), threshold, D_PRIME_SPAN * threshold),
    )


def _refused(detection: pd.DataFrame) -> "pd.Series[float]":
    """Return 1 where the scheme marked the mesh with no key at all, else 0."""
    never = detection["refused"] == detection["trials"] if "refused" in detection else False
    return pd.Series(never & (detection["trials"] > 0), detection.index, dtype=float)


def _written(values: FloatArray, decimals: int) -> list[list[str]]:
    """Write numbers in four characters; 1 and 0 of Pd are written short only where they are exact."""

    def short(value: float) -> str:
        if np.isnan(value):
            return "–"
        if np.isinf(value):
            return REFUSED
        if decimals == 2 and value in (0, 1):
            return f"{value:.0f}"
        if decimals == 2:
            # .995 of 1000 keys is not all of them
            return f"{np.clip(value, 0.01, 0.99):.2f}"
        text = f"{value:.{decimals if abs(value) < 100 else 0}f}"
        return text.replace("-0.0", "0.0").replace("-", "−")

    return [[short(value) for value in line] for line in values]


def _upright(labels: list[str], width: float) -> bool:
    """Whether headings must stand upright over columns of that width in inches."""
    return CHARACTER * max(map(len, labels)) > width


def _heading_height(labels: list[str]) -> float:
    """Inches that upright headings take."""
    return CHARACTER * min(max(map(len, labels)), HEADING_WIDTH)


def _headings(columns: list[tuple[str, str]]) -> tuple[list[str], list[tuple[str, int, int]]]:
    """Return a heading for each column, and groups (heading, first, count) where they are worth a line."""
    meshes, schemes = ({column[k] for column in columns} for k in (0, 1))
    groups, first = [], 0
    for mesh, members in groupby(columns, key=lambda column: column[0]):
        count = len(list(members))
        groups.append((mesh, first, count))
        first += count
    if len(schemes) == 1:
        return [mesh for mesh, _ in columns], []
    if len(meshes) == 1:
        return [scheme for _, scheme in columns], []
    width = _cell_width(len(columns))
    if all(CHARACTER * len(mesh) <= width * count for mesh, _, count in groups):
        return [scheme for _, scheme in columns], groups
    return [f"{mesh}, {scheme}" for mesh, scheme in columns], []


def _places(columns: list[tuple[str, str]]) -> FloatArray:
    """Left ends of the columns in widths of a cell; groups stand apart."""
    places = np.arange(len(columns), dtype=np.float64)
    for _, first, _ in _headings(columns)[1][1:]:
        places[first:] += GROUP_GAP
    return places


def _draw(panel: Axes, grid: _Grid, names: list[str], columns: list[tuple[str, str]]) -> None:
    rows = len(grid.values)
    scale, colormap = grid.colors()
    colors = colormap(scale(np.nan_to_num(grid.values)))
    colors[~np.isfinite(grid.values)] = to_rgba(UNTRIED)
    places = _places(columns)
    boxes = [Rectangle((x + 0.02, y + 0.03), 0.96, 0.94) for y in range(rows) for x in places]
    panel.add_collection(PatchCollection(boxes, facecolors=colors.reshape(-1, 4), edgecolors="none"))
    dark = colors[..., :3] @ LUMINANCE < DARK_BELOW
    for y, line in enumerate(grid.texts):
        for x, text in enumerate(line):
            ink = LIGHT_INK if dark[y, x] else DARK_INK
            panel.text(places[x] + 0.5, y + 0.53, text, ha="center", va="center", fontsize=6.5, color=ink)
    for y in range(1, rows):
        if names[y].partition(" ")[0] != names[y - 1].partition(" ")[0]:
            panel.axhline(y, color="0.5", linewidth=0.5)  # between families of attacks
    panel.set(xlim=(0, places[-1] + 1), ylim=(rows, 0))
    panel.grid(False)
    panel.spines[:].set_visible(False)
    panel.tick_params(length=0, labelsize=7)
    panel.set_yticks(np.arange(rows) + 0.5, names)
    _head(panel, columns)
    panel.set_title(grid.title, loc="left", fontsize=9)
    bar = panel.figure.colorbar(
        ScalarMappable(scale, colormap), ax=panel, location="bottom", aspect=30, pad=0.01, shrink=0.9
    )
    bar.set_ticks([0, grid.middle, grid.top], labels=["0", f"{grid.middle:.3g}", f"{grid.top:.3g}"])
    bar.ax.tick_params(labelsize=6.5, length=2)
    bar.ax.grid(False)


def _head(panel: Axes, columns: list[tuple[str, str]]) -> None:
    """Write the headings of the columns, and of their groups above them."""
    (labels, groups), places = _headings(columns), _places(columns)
    upright = _upright(labels, _cell_width(len(columns)))
    wrapped = [textwrap.fill(label, HEADING_WIDTH) for label in labels] if upright else labels
    panel.xaxis.tick_top()
    panel.set_xticks(places + 0.5, wrapped, rotation=90 if upright else 0, va="bottom")
    if groups:
        above = panel.secondary_xaxis("top")
        middles = [(places[first] + places[first + size - 1] + 1) / 2 for _, first, size in groups]
        above.set_xticks(middles, [mesh for mesh, _, _ in groups])
        above.tick_params(length=0, labelsize=8, pad=72 * _heading_height(labels) + 6 if upright else 16)
        above.spines[:].set_visible(False)
