"""The tail of a Rademacher sum: counted, by inversion or by the saddlepoint, as its weights allow."""

import math
from typing import overload

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import gammaln, logsumexp

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.stats.inversion import DEEPEST, FEW_SIGNS, inversion_log10
from wm3d.stats.saddlepoint import LN10, saddlepoint, saddlepoint_tail
from wm3d.stats.weights import checked_thresholds, checked_weights, tie_slack, unit_weights

LOG10_2 = math.log10(2.0)
_COUNTED_SIGNS = 24  # their 2^24 sums are counted as two sorted halves of 2^12
_ROUNDING = 1e-12  # of log10 P, where an atom meets the wanted Pf


@overload
def log10_tail(b: ArrayLike, z: float) -> float: ...
@overload
def log10_tail(b: ArrayLike, z: FloatArray) -> FloatArray: ...
def log10_tail(b: ArrayLike, z: float | FloatArray) -> float | FloatArray:
    r"""Return log10 P(Σ b_k w_k ≥ z √(Σ b²)) for independent w_k, each ±1 with probability ½.

    Parameters
    ----------
    b : (n,) array_like of float
        Weights; zeros are allowed and have no effect.
    z : float or ndarray of float
        Thresholds in units of the standard deviation √(Σ b²); -inf and inf are allowed.

    Returns
    -------
    float or ndarray of float
        Shape of `z`. 0 for all-zero `b`; -inf beyond Σ|b|.

    Raises
    ------
    Wm3dError
        If a weight is not finite or a threshold is NaN.

    Notes
    -----
    Four routes, by what the weights allow:

    * all nonzero |b_k| equal: the binomial distribution, exactly;
    * at most 24 signs can still be free (24 nonzero weights, or z so near Σ|b| that only the 24 smallest
      weights may point down): the keys are counted, exactly;
    * down to 1e-30, and for up to 327 signs wherever: the characteristic function is inverted
      (:mod:`wm3d.stats.inversion`). The result lies between the tail at z and that at z − 0.0024 / max(z, 1):
      never below the truth, and 0.1 % above it where no atoms show;
    * beyond: :func:`saddlepoint_log10`, whose relative error is of order 1/n. It treats the sum as
      continuous: where many weights share few values, it falls short, the farther out the more (400 weights
      of 1 and 2: 0.67 of the truth at 1e-32, 0.53 at 1e-61).

    Ties count as exceedances; sums within 10⁻¹² of Σ|b| of each other are ties.
    """
    a = _told_apart(unit_weights(b))
    thresholds = checked_thresholds(z)
    out = _tail(a, thresholds.ravel()).reshape(thresholds.shape)
    return float(out[()]) if np.ndim(z) == 0 else out


def _told_apart(a: FloatArray) -> FloatArray:
    """Drop the smallest weights, all of which together move a sum only within its ties."""
    slack = tie_slack(a)
    if a.size == 0 or a.min() > slack:
        return a
    ordered = np.sort(a)
    kept: FloatArray = ordered[np.cumsum(ordered) > slack / 4]
    return kept


def _tail(a: FloatArray, z: FloatArray) -> FloatArray:
    """Log10 of the tail of unit weights at (m,) thresholds."""
    out = np.zeros(z.shape)
    if a.size == 0:
        return out
    reach, slack = float(a.sum()), tie_slack(a)
    out[z > reach + slack] = -np.inf
    inside = (z > -reach) & (z <= reach + slack)
    z = np.minimum(z[inside], reach)
    if np.ptp(a) <= slack / a.size:
        out[inside] = _equal_weights(a, z)
        return out
    gap = reach - z + slack
    smallest = np.partition(a, _COUNTED_SIGNS) if a.size > _COUNTED_SIGNS else np.append(a, np.inf)
    few = gap < 2 * smallest[min(a.size, _COUNTED_SIGNS)]
    tails = np.empty(z.shape)
    if few.any():
        tails[few] = _counted(a.size, smallest[: min(a.size, _COUNTED_SIGNS)], gap[few])
    if not few.all():
        tails[~few] = np.maximum(_many(a, z[~few]), -a.size * LOG10_2)
    out[inside] = tails
    return out


def _many(a: FloatArray, z: FloatArray) -> FloatArray:
    point = saddlepoint(a, np.minimum(np.abs(z), a.sum() - tie_slack(a)))
    exponent = point.theta * np.abs(z) - point.cumulant  # P ≤ e^-exponent (Chernoff)
    near = (exponent <= DEEPEST) | (a.size <= FEW_SIGNS)
    tails = np.empty(z.shape)
    tails[near] = inversion_log10(a, z[near], point.theta[near])
    tails[~near] = saddlepoint_tail(a, z[~near])
    return tails


def _equal_weights(a: FloatArray, z: FloatArray) -> FloatArray:
    """Log10 P(at most m of n signs are down), the binomial tail, summed in logs."""
    n = a.size
    down = np.floor((a.sum() - z + tie_slack(a)) / (2 * a.mean())).astype(np.int64)
    i = np.arange(n + 1)
    log_mass = gammaln(n + 1) - gammaln(i + 1) - gammaln(n - i + 1) - n * math.log(2)
    tails = [min(0.0, float(logsumexp(log_mass[: m + 1]))) for m in np.clip(down, 0, n)]
    return np.array(tails) / LN10


def _counted(n: int, free: FloatArray, gap: FloatArray) -> FloatArray:
    """Log10 share of the 2^n keys whose down signs are among the free weights and cost at most the gap.

    A sign that is down costs twice its weight. The subsets are counted by meeting in the middle.
    """
    left, right = np.zeros(1), np.zeros(1)
    for k, weight in enumerate(free):
        if k % 2:
            left = np.concatenate([left, left + weight])
        else:
            right = np.concatenate([right, right + weight])
    right.sort()
    counts = [np.searchsorted(right, budget - left, side="right").sum() for budget in gap / 2]
    return np.log10(np.array(counts, dtype=np.float64)) - n * LOG10_2


def hoeffding_log10(b: ArrayLike, z: float | FloatArray) -> float | FloatArray:
    """Return log10 of Hoeffding's bound exp(−z²/2) ≥ P(Σ b_k w_k ≥ z √(Σ b²)); 1 for z ≤ 0 or all-zero b.

    Parameters
    ----------
    b : (n,) array_like of float
        Weights; in units of √(Σ b²) the bound is the same for all of them.
    z : float or ndarray of float
        Thresholds (Hoeffding, J. Am. Stat. Assoc. 58, 1963, theorem 2).
    """
    thresholds = checked_thresholds(z)
    bound = 0.0 - np.maximum(thresholds, 0.0) ** 2 / (2 * LN10) * bool(np.any(checked_weights(b)))
    return float(bound[()]) if np.ndim(z) == 0 else bound


def z_at(b: ArrayLike, log10_pf: float) -> float:
    """Return the threshold z whose false-alarm probability is 10**log10_pf: the inverse of `log10_tail`.

    Parameters
    ----------
    b : (n,) array_like of float
        Weights.
    log10_pf : float
        Decimal logarithm of the wanted probability, below 0.

    Returns
    -------
    float
        The least z with log10_tail(b, z) ≤ log10_pf, each within 10⁻¹² (of Σ|b|, and of 1), or inf if even
        a single key, with its probability 2^−n over n weights that move a sum, is likelier than that.

    Raises
    ------
    Wm3dError
        If log10_pf is not below 0.
    """
    if not log10_pf < 0:
        raise Wm3dError(
            f"log10_pf is {log10_pf}; a false-alarm probability below 1 has a negative logarithm."
        )
    a = _told_apart(unit_weights(b))
    if log10_pf < -a.size * LOG10_2 - _ROUNDING:
        return math.inf
    reach = float(a.sum())

    def excess(z: float) -> float:
        return max(log10_tail(a, z), -1e300) - log10_pf - _ROUNDING

    step = tie_slack(a)
    z = reach if excess(reach) >= 0 else float(brentq(excess, -2 * reach, reach, xtol=step))
    while excess(z) > 0:  # the tail of a discrete sum jumps: go to the side that keeps Pf
        z, step = z + step, 2 * step
    return z
