"""The ranking of schemes at equal distortion: mean Pd over attacks, bootstrapped over meshes."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from wm3d.arrays import FloatArray
from wm3d.bench.summary import DETECTED
from wm3d.stats.intervals import DEFAULT_CONFIDENCE

RESAMPLES = 10_000
"""Draws of meshes with replacement, the same ones for every scheme."""

SEED = 2002

METHOD = (
    "The score is Pd, averaged over attacks and then over meshes. Its 95 % interval and that of the rank are "
    f"percentiles over {RESAMPLES:,} draws of the meshes with replacement, the same draws for every scheme: "
    "they tell how much hangs on the choice of meshes, not on that of keys. A scheme that cannot meet the "
    "budget on a mesh, or on which an attack failed there with every key, has a score on the others and no "
    "rank. The strength is set with one key on each mesh; other keys may come out fainter or louder."
)
"""What a reader must know under a ranking."""


def interval_words(meshes: int) -> str:
    """Return how wide the interval of a score is with so many meshes."""
    if meshes == 1:
        return "With one mesh there is no interval."
    draws = meshes**meshes
    if 1 / draws > (1 - DEFAULT_CONFIDENCE) / 2:
        return (
            f"With {meshes} meshes one draw in {draws} is the worst mesh throughout and another the best, so "
            "the interval of a score reaches from the score on the worst mesh to that on the best."
        )
    return f"With {meshes} meshes it is narrower than the range of the scores on single meshes."


def ranking(
    calibration: pd.DataFrame,
    detection: pd.DataFrame,
    snr: pd.DataFrame,
    timing: pd.DataFrame,
    pf: float,
) -> pd.DataFrame:
    """Return a line for each budget and scheme, best first.

    Parameters
    ----------
    calibration : DataFrame
        With the columns `wm3d.bench.columns.CALIBRATION`.
    detection, snr, timing : DataFrame
        Tables of `wm3d.bench.tables`.
    pf : float
        One of the Pf that `detection` quotes.

    Returns
    -------
    DataFrame
        `score` is the mean Pd, `survived` the share of attacks and meshes with Pd of at least `DETECTED`;
        `log10_pf_least`, `ber`, `snr_db` and seconds are means over attacks and meshes, `embed_mb` is the
        maximum; `snr_apart` is how far keys lie apart in SNR, in dB, on the mesh where most. `score` is over
        the meshes that `meshes` counts, the others over all that have numbers; where the former are not all,
        `rank` is NaN.
    """
    lines = [
        line
        for _, group in calibration.groupby("budget", sort=False)
        for line in _of_budget(group, detection, f"pd_{pf:g}")
    ]
    table = pd.DataFrame(lines)
    costs = timing.groupby("scheme").agg(
        embed_seconds=("embed_seconds", "mean"),
        detect_seconds=("score_seconds", "mean"),
        embed_mb=("embed_mb", "max"),
    )
    distances = (
        snr.assign(apart=(snr["max"] - snr["min"]).round(2))
        .groupby("scheme")
        .agg(snr_db=("snr_db", "mean"), snr_apart=("apart", "max"))
    )
    return table.join(distances, on="scheme").join(costs, on="scheme")


def over_meshes(calibration: pd.DataFrame, detection: pd.DataFrame, pf: float) -> pd.DataFrame:
    """Average a detection table over the meshes, for a heat map with a column for each budget and scheme.

    Returns
    -------
    DataFrame
        What `wm3d.bench.heatmap.heatmap_figure` draws, with the budget as `mesh` and the method as `scheme`.
    """
    named = calibration.drop_duplicates("scheme").set_index("scheme")[["budget", "method"]]
    table = detection.join(named, on="scheme")
    means = table.groupby(["budget", "method", "attack"], sort=False).agg(
        trials=("trials", "sum"),
        sigma_percent=("sigma_percent", "mean"),
        d_prime=("d_prime", "mean"),
        found=(f"pd_{pf:g}", "mean"),
    )
    names = {"budget": "mesh", "method": "scheme", "found": f"pd_{pf:g}"}
    return means.reset_index().rename(columns=names)


def _of_budget(calibration: pd.DataFrame, detection: pd.DataFrame, found: str) -> Iterator[dict[str, Any]]:
    """Yield the lines of one budget, best first, then those without a rank."""
    meshes = list(dict.fromkeys(calibration["mesh"]))
    scores: dict[str, FloatArray] = {}
    lines: dict[str, dict[str, Any]] = {}
    for scheme, group in calibration.groupby("scheme", sort=False):
        trials = detection[detection["scheme"] == scheme]
        by_mesh = trials.groupby("mesh", sort=False)[found]
        # an attack that failed throughout leaves no score
        means = {str(mesh): float(shares.mean(skipna=False)) for mesh, shares in by_mesh}
        met = np.array([means[mesh] for mesh in meshes if np.isfinite(means.get(mesh, np.nan))])
        if len(met) == len(meshes):
            scores[str(scheme)] = met
        lines[str(scheme)] = {
            "budget": group["budget"].iloc[0],
            "rank": np.nan,
            "rank_low": np.nan,
            "rank_high": np.nan,
            "scheme": scheme,
            "method": group["method"].iloc[0],
            "score": met.mean() if len(met) else np.nan,
            **dict(zip(("score_low", "score_high"), _percentiles(_resampled(met)), strict=True)),
            "survived": (trials[found].dropna() >= DETECTED).mean() if len(met) else np.nan,
            "meshes": len(met),
            "log10_pf_least": trials["log10_pf_least"].mean(),
            "ber": trials["ber"].mean(),
        }
    for scheme, ranks in _ranks(scores).items():
        lines[scheme] |= dict(zip(("rank", "rank_low", "rank_high"), ranks, strict=True))
    yield from sorted(lines.values(), key=lambda line: (np.isnan(line["rank"]), line["rank"], -line["score"]))


def _ranks(scores: dict[str, FloatArray]) -> dict[str, tuple[float, float, float]]:
    """Rank schemes by their scores on the meshes, with intervals; equal scores share the better rank."""
    if not scores:
        return {}
    ranks = _places(np.array([[values.mean()] for values in scores.values()]))[:, 0]
    drawn = _places(np.array([_resampled(values) for values in scores.values()]))
    return {
        scheme: (float(rank), *_percentiles(places))
        for scheme, rank, places in zip(scores, ranks, drawn, strict=True)
    }


def _places(scores: FloatArray) -> FloatArray:
    """Return 1 + the number of better schemes, column by column: (schemes, draws)."""
    rounded = scores.round(12)  # sums in another order are no difference
    better = [(rounded > line).sum(axis=0) for line in rounded]
    return np.where(np.isnan(rounded), np.nan, 1.0 + np.array(better, np.float64))


def _resampled(scores: FloatArray) -> FloatArray:
    """Return the mean score of every draw of meshes, (RESAMPLES,); none from fewer than two meshes."""
    if len(scores) < 2:
        return np.full(RESAMPLES, np.nan)
    draws = np.random.default_rng(SEED).integers(len(scores), size=(RESAMPLES, len(scores)))
    means: FloatArray = scores[draws].mean(axis=1)
    return means


def _percentiles(draws: FloatArray) -> tuple[float, float]:
    if np.isnan(draws).any():
        return float("nan"), float("nan")
    tail = 50 * (1 - DEFAULT_CONFIDENCE)
    # of the draws themselves: between two of few values there is nothing
    low, high = np.percentile(draws, [tail, 100 - tail], method="inverted_cdf")
    return float(low), float(high)
