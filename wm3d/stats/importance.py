"""Importance sampling of the false-alarm probability: keys drawn from the exponentially tilted law."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.stats.intervals import DEFAULT_CONFIDENCE
from wm3d.stats.saddlepoint import LN10, saddlepoint
from wm3d.stats.weights import checked_thresholds, tie_slack, unit_weights

DEFAULT_RELATIVE_ERROR = 0.02
"""Relative standard error that a run aims at, unless the caller names another."""

_KEYS_AT_ONCE = 32  # 1.6 MB of float64 at n = 6300 stays in cache


@dataclass(frozen=True)
class ImportanceEstimate:
    """An estimate of one false-alarm probability.

    Parameters
    ----------
    z : float
        Threshold in units of √(Σ b²).
    log10_pf : float
        log10 of the unbiased estimate of Pf.
    relative_error : float
        Standard error of the estimate as a share of it, from the sample; NaN with fewer than two keys.
    trials : int
        Number of tilted keys.
    """

    z: float
    log10_pf: float
    relative_error: float
    trials: int

    def log10_interval(self, confidence: float = DEFAULT_CONFIDENCE) -> tuple[float, float]:
        """Return the ends of the interval of log10 Pf, from the normal law of the estimate."""
        half = float(ndtri((1 + confidence) / 2)) * self.relative_error
        low = self.log10_pf + math.log10(1 - half) if half < 1 else -math.inf
        return low, self.log10_pf + math.log10(1 + half)


def importance_sampling(
    b: ArrayLike,
    z: float,
    relative_error: float = DEFAULT_RELATIVE_ERROR,
    seed: int = 0,
    trials: int | None = None,
) -> ImportanceEstimate:
    r"""Estimate P(Σ b_k w_k ≥ z √(Σ b²)) from independent signs tilted towards the threshold.

    Parameters
    ----------
    b : (n,) array_like of float
        Weights, not all zero.
    z : float
        Threshold, below Σ|b| / √(Σ b²). Ties count as exceedances.
    relative_error : float
        Standard error to aim at, as a share of Pf. The result tells the one reached.
    seed : int
        Non-negative.
    trials : int, optional
        Number of keys; by default as many as `relative_error` takes.

    Returns
    -------
    ImportanceEstimate

    Raises
    ------
    Wm3dError
        If all weights are zero, z is NaN or not below Σ|b| / √(Σ b²), or the trials or the error are not
        positive.

    Notes
    -----
    With K(θ) = Σ ln cosh(θ a_k), a = |b|/√(Σ b²), signs of probability (1 + tanh θ a_k)/2 and K'(θ) = z, the
    mean of 1{S ≥ z} exp(K(θ) − θS) is Pf (Siegmund, Ann. Stat. 4, 1976). For a nearly normal sum one key
    has the relative variance z √(π/2), so z √(π/2) / error² keys are enough. Pf itself never appears:
    exp(K − θz) is kept as a logarithm, and the terms exp(−θ(S − z)) are at most 1.
    """
    a = unit_weights(b)
    threshold = float(checked_thresholds(z))
    if not threshold < a.sum():
        raise Wm3dError(f"Threshold z = {threshold} is not below Σ|b| / √(Σ b²) = {a.sum():g}.")
    if not relative_error > 0:
        raise Wm3dError(f"relative_error is {relative_error}; it must be positive, for example 0.02.")
    if trials is None:
        trials = math.ceil(max(1.0, threshold * math.sqrt(math.pi / 2)) / relative_error**2)
    if trials < 1:
        raise Wm3dError(f"trials is {trials}; at least one key must be drawn.")
    point = saddlepoint(a, np.array([max(threshold, 0.0)]))
    theta = float(point.theta[0])
    terms = _terms(a, threshold, theta, trials, seed)
    mean = float(terms.mean())
    exponent = float(point.cumulant[0]) - theta * threshold
    log10_pf = (exponent + math.log(mean)) / LN10 if mean > 0 else -math.inf
    spread = float(terms.std(ddof=1)) / math.sqrt(trials) if trials > 1 else math.nan
    return ImportanceEstimate(threshold, log10_pf, spread / mean if mean > 0 else math.nan, trials)


def _terms(a: FloatArray, z: float, theta: float, trials: int, seed: int) -> FloatArray:
    """Draw the tilted sums and return 1{S ≥ z} exp(−θ(S − z)) of each."""
    up = 0.5 * (1 + np.tanh(theta * a))
    generator = np.random.default_rng(np.random.SeedSequence(seed))
    terms = np.empty(trials)
    for first in range(0, trials, _KEYS_AT_ONCE):
        part = terms[first : first + _KEYS_AT_ONCE]
        is_up = generator.random((part.size, a.size)) < up
        excess = 2 * (is_up.astype(np.float64) @ a) - a.sum() - z
        part[:] = np.where(excess >= -tie_slack(a), np.exp(-theta * np.maximum(excess, 0.0)), 0.0)
    return terms
