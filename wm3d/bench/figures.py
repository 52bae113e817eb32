"""Figures of a run: pure functions of its rows."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import cycle
from typing import Any, cast

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wm3d.bench.store import RunDirectory
from wm3d.bench.tables import cells
from wm3d.mesh import write_whole
from wm3d.stats import d_prime, roc

LEAST_LOG10_PF = -8.0
"""Left end of the ROC curves; the paper counted no further."""

NULL_CAPTION = (
    "Statistic: z of the detector. Null: uniform keys on the mesh under test, exact (saddlepoint tail).\n"
    "A trial is detected if its p-value is at most Pf. Bands: 95 % Clopper–Pearson."
)
"""What a reader must know to read Pf, under every ROC figure."""

STYLE: dict[str, Any] = {
    "figure.dpi": 150,
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "legend.frameon": False,
    "svg.hashsalt": "wm3d",
    "svg.fonttype": "none",
}


def roc_figure(rows: pd.DataFrame) -> Figure:
    """Pd against log10 Pf from 1e-8 to 1, a panel for each mesh and scheme, a curve for each attack.

    Each trial is held to Pf by the exact key null of its own mesh; bands are 95 % Clopper–Pearson.
    """
    panels: dict[tuple[str, str], dict[str, pd.DataFrame]] = {}
    for (mesh, scheme, attack), group in cells(rows, "H1"):
        panels.setdefault((mesh, scheme), {})[attack] = group
    with _style():
        figure = Figure(figsize=(6.4, 5.2 * len(panels)), layout="constrained")
        axes = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
        for panel, ((mesh, scheme), curves) in zip(axes, panels.items(), strict=True):
            trials = max(len(group) for group in curves.values())
            panel.set_title(f"{mesh}, {scheme}, {trials} keys", loc="left")
            _roc_panel(panel, curves)
        figure.supxlabel(NULL_CAPTION, fontsize=7, x=0.0, ha="left")
    return figure


def _roc_panel(panel: Axes, curves: dict[str, pd.DataFrame]) -> None:
    grid = np.linspace(LEAST_LOG10_PF, 0, 401)
    styles = cycle(["-", "--", "-.", ":"])
    for (attack, group), style in zip(curves.items(), styles, strict=False):
        scored = group[group["log10_p"].notna()]
        curve = roc(scored["log10_p"], grid)
        label = f"{attack} (d' = {d_prime(scored['z']):.1f})"
        (line,) = panel.plot(grid, curve.pd, style, label=label)
        panel.fill_between(grid, curve.low, curve.high, color=line.get_color(), alpha=0.12, linewidth=0)
    panel.plot(grid, 10**grid, color="0.6", linewidth=0.8, label="no information")
    panel.set(xlim=(LEAST_LOG10_PF, 0), ylim=(-0.02, 1.02), xlabel="log10 Pf", ylabel="Pd")
    panel.legend(loc="upper left", bbox_to_anchor=(0.0, -0.14), fontsize=8)


def save(figure: Figure, directory: RunDirectory, name: str) -> None:
    """Write figures/NAME.png and figures/NAME.svg, the same bytes for the same figure."""
    with _style():
        for ending, metadata in (("png", {"Software": None}), ("svg", {"Date": None, "Creator": None})):
            buffer = io.BytesIO()
            figure.savefig(buffer, format=ending, bbox_inches="tight", metadata=metadata)
            write_whole(directory.path / "figures" / f"{name}.{ending}", buffer.getvalue())


@contextmanager
def _style() -> Iterator[None]:
    # matplotlib types its parameters by literal names, which a plain dict cannot meet
    with mpl.rc_context(cast("Any", STYLE)):
        yield
