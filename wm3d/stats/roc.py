"""ROC curves from exact p-values, and the numbers that sum them up."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wm3d.arrays import FloatArray, IntArray
from wm3d.errors import Wm3dError
from wm3d.stats.intervals import DEFAULT_CONFIDENCE, clopper_pearson
from wm3d.stats.saddlepoint import LN10


def exceedances(scores: ArrayLike, thresholds: ArrayLike) -> IntArray:
    """Count the scores that are at least each threshold: the one primitive under every curve here.

    Parameters
    ----------
    scores : (n,) array_like of float
        Scores, larger meaning more marked; infinite ones are ordered as usual.
    thresholds : (m,) array_like of float
        In any order; infinite ones are allowed.

    Returns
    -------
    (m,) ndarray of int
        Ties count: a score equal to the threshold reaches it.

    Raises
    ------
    Wm3dError
        If a score or a threshold is NaN.
    """
    ordered = np.sort(np.asarray(scores, dtype=np.float64).ravel())
    limits = np.asarray(thresholds, dtype=np.float64)
    if np.isnan(ordered).any() or np.isnan(limits).any():
        raise Wm3dError("A score or a threshold is NaN, which no ROC curve can place.")
    counts: IntArray = len(ordered) - np.searchsorted(ordered, limits, side="left").astype(np.int64)
    return counts


@dataclass(frozen=True, eq=False)
class RocCurve:
    """Detection against false alarm at m operating points.

    Parameters
    ----------
    log10_pf : (m,) ndarray of float
        log10 of the false-alarm probability.
    pd : (m,) ndarray of float
        Share of the H1 trials detected; NaN without trials.
    low, high : (m,) ndarray of float
        Clopper–Pearson band of Pd, point by point; (0, 1) without trials.
    trials : int
        H1 trials.
    """

    log10_pf: FloatArray
    pd: FloatArray
    low: FloatArray
    high: FloatArray
    trials: int


def roc(log10_p: ArrayLike, log10_pf: ArrayLike, confidence: float = DEFAULT_CONFIDENCE) -> RocCurve:
    """Return the constant-false-alarm ROC of trials that carry exact p-values.

    Parameters
    ----------
    log10_p : (n,) array_like of float
        log10 of the p-value of each H1 trial; -inf is a certain detection.
    log10_pf : (m,) array_like of float
        log10 of the false-alarm probabilities to evaluate.
    confidence : float
        Coverage of the band.

    Returns
    -------
    RocCurve
        Pd(Pf) is the share of trials with log10 p ≤ log10 Pf: each is held to Pf on its own null.
    """
    wanted = np.atleast_1d(np.asarray(log10_pf, dtype=np.float64))
    trials = int(np.size(log10_p))
    hits = exceedances(-np.asarray(log10_p, dtype=np.float64), -wanted)
    band = clopper_pearson(hits, trials, confidence)
    pd = hits / trials if trials else np.full(hits.shape, np.nan)
    return RocCurve(wanted, pd, band.low, band.high, trials)


def d_prime(z: ArrayLike) -> float:
    """Return the detectability index d': how many null standard deviations H1 lies above H0.

    Parameters
    ----------
    z : (n,) array_like of float
        H1 scores. NaN is returned without any.

    Returns
    -------
    float
        The mean of z, whose null has mean 0 and variance 1 exactly. The variance of H1 plays no part.
    """
    signal = np.asarray(z, dtype=np.float64)
    return float(signal.mean()) if signal.size else float("nan")


def auc(log10_p: ArrayLike) -> float:
    """Return the area under the ROC of exact p-values: H0 p-values are uniform, so it is the mean of 1 − p.

    Parameters
    ----------
    log10_p : (n,) array_like of float
        log10 of the p-value of each H1 trial. NaN is returned without any.
    """
    logs = np.asarray(log10_p, dtype=np.float64)
    return float(0.0 - np.expm1(logs * LN10).mean()) if logs.size else float("nan")


def eer(log10_p: ArrayLike) -> float:
    """Return the equal error rate of the ROC of exact p-values: where the share missed meets Pf.

    Parameters
    ----------
    log10_p : (n,) array_like of float
        log10 of the p-value of each H1 trial. NaN is returned without any.

    Returns
    -------
    float
        The least Pf at which no more than that share of the trials is missed.
    """
    p = 10.0 ** np.sort(np.asarray(log10_p, dtype=np.float64).ravel())
    if p.size == 0:
        return float("nan")
    missed = 1 - np.arange(p.size + 1) / p.size  # above the k smallest p-values
    return float(np.maximum(np.concatenate([[0.0], p]), missed).min())
