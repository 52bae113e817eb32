"""The quality–robustness figure: how much of the attacks a scheme survives at each budget of distortion."""

import math
from collections.abc import Iterable, Mapping

import pandas as pd
from matplotlib.figure import Figure

from wm3d.bench.figures import COLORS, caption, keys, power_of_ten, styled
from wm3d.bench.ranking import METHOD
from wm3d.bench.summary import DETECTED

MARKERS = "osD^vPX*"


def quality_figure(
    ranked: pd.DataFrame,
    detection: pd.DataFrame,
    pf: float,
    meshes: Iterable[str],
    credits: Mapping[str, str | None],
) -> Figure:
    """Draw mean Pd, and the share of attacks survived, against the SNR that the marks have at each budget.

    SNR is the common scale of budgets in other metrics too; a line joins the budgets of one scheme.

    Parameters
    ----------
    ranked : DataFrame
        `wm3d.bench.ranking.ranking`.
    detection : DataFrame
        The table of detection that it ranks.
    pf : float
        The false-alarm probability of the scores.
    meshes : iterable of str
    credits : mapping of str to str or None
        Line that a figure of a mesh must carry, by its name.
    """
    with styled():
        figure = Figure(figsize=(8.2, 4.6), layout="constrained")
        left, right = figure.subplots(1, 2, sharex=True, sharey=True)
        for index, (method, group) in enumerate(ranked.groupby("method", sort=False)):
            met = group.dropna(subset="score").sort_values("snr_db")
            color, marker = COLORS[index % len(COLORS)], MARKERS[index % len(MARKERS)]
            for panel, name in ((left, "score"), (right, "survived")):
                panel.plot(
                    met["snr_db"],
                    met[name],
                    marker=marker,
                    color=color,
                    markersize=4,
                    linewidth=1,
                    label=str(method) if panel is left else None,
                )
            left.vlines(met["snr_db"], met["score_low"], met["score_high"], color=color, linewidth=0.6)
        left.set(ylim=(-0.03, 1.03), ylabel=f"mean Pd at Pf = {power_of_ten(math.log10(pf))}")
        right.set(ylabel=f"share of attacks and meshes with Pd ≥ {DETECTED:g}")
        for panel in (left, right):
            panel.set_xlabel("SNR of the marks in dB, fainter to the right")
        figure.legend(loc="outside right upper")
        budgets = ", ".join(dict.fromkeys(ranked["budget"]))
        text = (
            f"A point a scheme and budget: {budgets}. Pd: share of {keys(detection)} keys found, each held "
            f"to Pf by the exact key null of its own mesh. Bars: 95 %. {METHOD}"
        )
        caption(figure, text, meshes, credits)
    return figure
