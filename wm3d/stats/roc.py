"""ROC curves: from exact p-values, from two samples as in the paper, and the Gaussian fit between them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, ndtri_exp

from wm3d.arrays import FloatArray, IntArray
from wm3d.errors import Wm3dError
from wm3d.stats.intervals import DEFAULT_CONFIDENCE, clopper_pearson, quoted
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
        log10 of the false-alarm probability; NaN where an empirical one may not be quoted.
    pd : (m,) ndarray of float
        Share of the H1 trials detected; NaN without trials.
    low, high : (m,) ndarray of float
        Clopper–Pearson band of Pd, point by point; (0, 1) without trials.
    threshold : (m,) ndarray of float
        Score from which a trial counts as detected: z, or −log10 p on a constant-false-alarm curve.
    trials : int
        H1 trials.
    """

    log10_pf: FloatArray
    pd: FloatArray
    low: FloatArray
    high: FloatArray
    threshold: FloatArray
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
    return _curve(-np.asarray(log10_p, dtype=np.float64), -wanted, wanted, confidence)


def swept_roc(h1: ArrayLike, h0: ArrayLike, confidence: float = DEFAULT_CONFIDENCE) -> RocCurve:
    """Return the ROC as the paper made it: one threshold swept over the scores of both classes.

    Parameters
    ----------
    h1 : (n,) array_like of float
        Scores (statistic or z) of marked trials.
    h0 : (n0,) array_like of float
        Scores of trials without this mark.
    confidence : float
        Coverage of the band of Pd.

    Returns
    -------
    RocCurve
        One point for each distinct score, from +inf (nothing detected) down. Pf is the share of H0 scores
        that reach the threshold, and NaN where `h0` holds fewer than 10/Pf trials.
    """
    thresholds = _sweep(h1, h0)
    pf = quoted(exceedances(h0, thresholds), np.size(h0))
    return _curve(h1, thresholds, np.log10(pf), confidence)


def _sweep(h1: ArrayLike, h0: ArrayLike) -> FloatArray:
    """Return every distinct score, largest first, after +inf."""
    scores = np.concatenate([np.ravel(np.asarray(h1, float)), np.ravel(np.asarray(h0, float)), [np.inf]])
    return np.unique(scores)[::-1]


def _curve(scores: ArrayLike, thresholds: FloatArray, log10_pf: FloatArray, confidence: float) -> RocCurve:
    trials = int(np.size(scores))
    hits = exceedances(scores, thresholds)
    band = clopper_pearson(hits, trials, confidence)
    pd = hits / trials if trials else np.full(hits.shape, np.nan)
    return RocCurve(log10_pf, pd, band.low, band.high, thresholds, trials)


def d_prime(z: ArrayLike, h0: ArrayLike | None = None) -> float:
    """Return the detectability index d': how many null standard deviations H1 lies above H0.

    Parameters
    ----------
    z : (n,) array_like of float
        H1 scores. NaN is returned without any.
    h0 : (n0,) array_like of float, optional
        Scores under H0. Without them the null is the exact one of z, mean 0 and variance 1, and d' is
        the mean of z.

    Returns
    -------
    float
        (mean of H1 − mean of H0) / standard deviation of H0. The variance of H1 plays no part.
    """
    signal = np.asarray(z, dtype=np.float64)
    if signal.size == 0:
        return float("nan")
    if h0 is None:
        return float(signal.mean())
    null = np.asarray(h0, dtype=np.float64)
    spread = float(null.std(ddof=1)) if null.size > 1 else 0.0
    return float((signal.mean() - null.mean()) / spread) if spread > 0 else float("nan")


def gaussian_pd(d: float, log10_pf: ArrayLike) -> FloatArray:
    """Return Pd = Q(Q⁻¹(Pf) − d'), the ROC of two unit-variance Gaussians d' apart.

    Parameters
    ----------
    d : float
        d', from `d_prime`.
    log10_pf : array_like of float
        log10 of the false-alarm probabilities, at most 0; the quantile is taken in logs, so 10^−1000 works.

    Returns
    -------
    ndarray of float
        Of the shape of `log10_pf`.
    """
    threshold = -ndtri_exp(np.asarray(log10_pf, dtype=np.float64) * LN10)
    pd: FloatArray = ndtr(d - threshold)
    return pd


def auc(log10_p: ArrayLike) -> float:
    """Return the area under the ROC of exact p-values: H0 p-values are uniform, so it is the mean of 1 − p.

    Parameters
    ----------
    log10_p : (n,) array_like of float
        log10 of the p-value of each H1 trial. NaN is returned without any.
    """
    logs = np.asarray(log10_p, dtype=np.float64)
    return float(-np.expm1(logs * LN10).mean()) if logs.size else float("nan")


def auc_two_sample(h1: ArrayLike, h0: ArrayLike) -> float:
    """Return the probability that an H1 score exceeds an H0 score, ties counting half (Mann–Whitney).

    Parameters
    ----------
    h1, h0 : array_like of float
        Scores. NaN is returned where a class is empty.
    """
    n1, n0 = np.size(h1), np.size(h0)
    if n1 == 0 or n0 == 0:
        return float("nan")
    above = exceedances(h1, h0).sum()  # pairs with h1 >= h0
    below = exceedances(h0, h1).sum()  # pairs with h0 >= h1
    return float(0.5 + 0.5 * (above - below) / (n1 * n0))


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


def eer_two_sample(h1: ArrayLike, h0: ArrayLike) -> float:
    """Return the least, over all thresholds, of the larger of the two error rates.

    Parameters
    ----------
    h1, h0 : array_like of float
        Scores. NaN is returned where a class is empty.
    """
    n1, n0 = np.size(h1), np.size(h0)
    if n1 == 0 or n0 == 0:
        return float("nan")
    thresholds = _sweep(h1, h0)
    missed = 1 - exceedances(h1, thresholds) / n1
    return float(np.maximum(missed, exceedances(h0, thresholds) / n0).min())
