"""What all figures of a run share: colours, style, captions, files."""

import io
import math
import re
import textwrap
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, cast

import matplotlib as mpl
import pandas as pd
from matplotlib.figure import Figure

from wm3d.bench.store import RunDirectory
from wm3d.mesh import write_whole

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
"""Okabe and Ito's palette for all kinds of colour vision, without the yellow that white paper swallows."""

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


SIGMA_CAPTION = " σ: standard deviation of noise on each coordinate in % of the diagonal of the bounding box."
"""What a reader must know under a figure with noise in it."""


CAPTION_DENSITY = 25
"""Characters of a caption in an inch of a figure's width."""


def caption(figure: Figure, text: str, meshes: Iterable[str], credits: Mapping[str, str | None]) -> None:
    """Write below a figure what a reader must know, and the credits that its meshes owe."""
    owed = list(dict.fromkeys(filter(None, map(credits.get, meshes))))
    text += f" Meshes: {'; '.join(owed)}." if owed else ""
    width = min(125, int(CAPTION_DENSITY * figure.get_figwidth()))
    figure.supxlabel(textwrap.fill(text, width), fontsize=6.5, x=0.01, ha="left", color="0.45")


def keys(detection: pd.DataFrame) -> str:
    """Write how many keys the cells of a table have: the range of it where they differ."""
    least, most = detection["trials"].min(), detection["trials"].max()
    return f"{most}" if least == most else f"{least} to {most}"


def attack_name(attack: str, sigmas: Iterable[float]) -> str:
    """Write an attack with its noise in the common unit, the range of it where several meshes differ."""
    values = sorted(sigma for sigma in set(sigmas) if not math.isnan(sigma))
    if not values:
        return attack
    ends = dict.fromkeys(f"{sigma:.2g}" for sigma in (values[0], values[-1]))
    return f"{attack} (σ {'–'.join(ends)} %)"


def power_of_ten(exponent: float) -> str:
    """Write 10^exponent with superscripts, and 1 for 10^0."""
    digits = str.maketrans("-0123456789.", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹·")
    return "10" + f"{exponent:g}".translate(digits) if exponent else "1"


def save(figure: Figure, directory: RunDirectory, name: str) -> str:
    """Write figures/NAME.png and figures/NAME.svg, the same bytes for the same figure; return the SVG."""
    with styled(), _any_script():
        figure.draw_without_rendering()
        figure.set_layout_engine(None)  # laid out once for both files
    png, svg = _drawn(figure, "png", "Software"), _drawn(figure, "svg", "Date", "Creator", "Format", "Type")
    write_whole(directory.path / "figures" / f"{name}.png", png)
    write_whole(directory.path / "figures" / f"{name}.svg", svg)
    return svg.decode()


def _drawn(figure: Figure, ending: str, *left_out: str) -> bytes:
    buffer = io.BytesIO()
    with styled(), _any_script():
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
def _any_script() -> Iterator[None]:
    """Be silent where the font lacks a letter, as of a mesh named in another script."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


@contextmanager
def styled() -> Iterator[None]:
    """Draw in `STYLE`."""
    # matplotlib types its parameters by literal names, which a plain dict cannot meet
    with mpl.rc_context(cast("Any", STYLE)):
        yield
