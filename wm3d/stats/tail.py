"""The tail of a Rademacher sum: exact where keys can be counted, else the Lugannani–Rice saddlepoint."""

import math
from typing import NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq
from scipy.special import erfcx, gammaln, logsumexp

from wm3d.errors import Wm3dError

FloatArray = NDArray[np.float64]

LN10 = math.log(10.0)
LOG10_2 = math.log10(2.0)
_COUNTED_SIGNS = 24  # their 2^24 sums are counted as two sorted halves of 2^12
_TIE = 1e-12  # sums closer than this share of the largest sum are ties: rounding must not split an atom
_BLOCK = 1 << 18  # elements of a temporary (thresholds x weights); 2 MB stays in cache


class Saddlepoint(NamedTuple):
    """Where K'(θ) = z, for K(θ) = Σ ln cosh(θ a_k) and Σ a_k² = 1; each field has the shape of z."""

    theta: FloatArray
    cumulant: FloatArray
    """K(θ)."""
    curvature: FloatArray
    """K''(θ)."""


def checked_weights(b: ArrayLike) -> FloatArray:
    """Return the weights as (n,) float64, or raise `Wm3dError` if they are not finite numbers in one row."""
    weights = np.asarray(b, dtype=np.float64)
    if weights.ndim != 1:
        raise Wm3dError(f"The weights b must be one row of numbers, got shape {weights.shape}.")
    if not np.isfinite(weights).all():
        bad = int(np.flatnonzero(~np.isfinite(weights))[0])
        raise Wm3dError(f"Weight b[{bad}] is {weights[bad]}; every weight must be finite.")
    return weights


def norm(b: FloatArray) -> float:
    """Return √(Σ b²) without overflow or underflow of the squares."""
    largest = float(np.abs(b).max(initial=0.0))
    return largest * float(np.linalg.norm(b / largest)) if largest > 0 else 0.0


def unit_weights(b: ArrayLike) -> FloatArray:
    """Return |b_k| / √(Σ b²) of the nonzero weights: the signs of b do not matter under uniform keys."""
    unit: FloatArray = np.abs(checked_weights(b))
    largest = unit.max(initial=0.0)
    if largest > 0:
        unit = unit / largest
        unit /= np.linalg.norm(unit)
    return unit if unit.all() else unit[unit > 0]


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
    Three routes, by what the weights allow:

    * all nonzero |b_k| equal: the binomial distribution, exactly;
    * at most 24 signs can still be free (24 nonzero weights, or z so near Σ|b| that only the 24 smallest
      weights may point down): the keys are counted, exactly;
    * otherwise :func:`saddlepoint_log10`, whose relative error is of order 1/n. It treats the sum as
      continuous: where many weights share few values, P(sum = z) is not small beside the tail, and the
      result lies between P(sum > z) and P(sum ≥ z), short of the latter by about half that atom.

    Ties count as exceedances; sums within 10⁻¹² of Σ|b| of each other are ties.
    """
    a = unit_weights(b)
    thresholds = _checked_thresholds(z)
    out = np.zeros(thresholds.shape)
    if a.size:
        reach = float(a.sum())
        slack = _TIE * reach
        out[thresholds > reach + slack] = -np.inf
        inside = (thresholds > -reach) & (thresholds <= reach + slack)
        out[inside] = _tail_inside(a, np.minimum(thresholds[inside], reach), slack)
    return float(out[()]) if np.ndim(z) == 0 else out


def _checked_thresholds(z: ArrayLike) -> FloatArray:
    thresholds = np.asarray(z, dtype=np.float64)
    if np.isnan(thresholds).any():
        raise Wm3dError("A threshold z is NaN; give a number, or inf or -inf.")
    return thresholds


def _tail_inside(a: FloatArray, z: FloatArray, slack: float) -> FloatArray:
    if np.ptp(a) <= _TIE * a[0]:
        return _equal_weights(a.size, z)
    gap = a.sum() - z + slack
    if a.size <= _COUNTED_SIGNS:
        free, countable = a, np.ones(z.shape, dtype=bool)
    else:
        smallest = np.partition(a, _COUNTED_SIGNS)[: _COUNTED_SIGNS + 1]
        free, countable = smallest[:-1], gap < 2 * smallest[-1]
    out = np.empty_like(z)
    if countable.any():
        out[countable] = np.log10(_subsets_within(free, gap[countable] / 2)) - a.size * LOG10_2
    if not countable.all():
        out[~countable] = np.maximum(_saddlepoint_tail(a, z[~countable]), -a.size * LOG10_2)
    return out


def _equal_weights(n: int, z: FloatArray) -> FloatArray:
    """Log10 P(at most m of n signs are down), the binomial tail, summed in logs."""
    down = np.floor((n - z * math.sqrt(n)) / 2 + _TIE * n).astype(np.int64)
    i = np.arange(n + 1)
    log_mass = gammaln(n + 1) - gammaln(i + 1) - gammaln(n - i + 1) - n * math.log(2)
    tails = [min(0.0, float(logsumexp(log_mass[: m + 1]))) for m in np.clip(down, 0, n)]
    return np.array(tails) / LN10


def _subsets_within(weights: FloatArray, budget: FloatArray) -> FloatArray:
    """Count the subsets of the weights whose sum is within each budget, by meeting in the middle."""
    left, right = np.zeros(1), np.zeros(1)
    for k, weight in enumerate(weights):
        if k % 2:
            left = np.concatenate([left, left + weight])
        else:
            right = np.concatenate([right, right + weight])
    right.sort()
    counts = [np.searchsorted(right, limit - left, side="right").sum() for limit in budget]
    return np.array(counts, dtype=np.float64)


def saddlepoint(a: FloatArray, z: FloatArray) -> Saddlepoint:
    """Solve K'(θ) = z for unit weights and 0 ≤ z < Σ a.

    Parameters
    ----------
    a : (n,) ndarray of float
        Positive weights with Σ a² = 1, from :func:`unit_weights`.
    z : (m,) ndarray of float
        Thresholds.

    Notes
    -----
    K' is concave and K'(θ) ≤ θ, so Newton's method from θ = z rises monotonically to the root.
    """
    rows = max(1, _BLOCK // a.size)
    parts = [_saddlepoint_block(a, z[i : i + rows]) for i in range(0, max(z.size, 1), rows)]
    return Saddlepoint(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _saddlepoint_block(a: FloatArray, z: FloatArray) -> Saddlepoint:
    theta = z
    for _ in range(200):
        slope, curvature = _derivatives(a, theta)
        # a step backwards is rounding; 4θ bounds the step where the curvature underflows
        step = np.clip((z - slope) / np.maximum(curvature, np.finfo(float).tiny), 0.0, 4 * theta)
        theta = theta + step
        if np.all(step <= 1e-7 * theta):
            break  # and the error, by quadratic convergence, is below 1e-13 θ
    cumulant = _ln_cosh(np.multiply.outer(theta, a)).sum(axis=-1)
    return Saddlepoint(theta, cumulant, _derivatives(a, theta)[1])


def _derivatives(a: FloatArray, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """K' = Σ a tanh(θa) and K'' = Σ a² sech²(θa)."""
    x = np.multiply.outer(theta, a)
    t: FloatArray = np.tanh(x)
    slope, square = t @ a, a * a
    curvature = 1 - np.square(t, out=t) @ square
    if (curvature < 1e-3).any():  # the difference loses its digits where most signs are already up
        e = np.exp(-2 * x)
        curvature = (4 * e / (1 + e) ** 2) @ square
    return slope, curvature


def _ln_cosh(x: FloatArray) -> FloatArray:
    """Ln cosh x for x ≥ 0 with full relative accuracy at both ends."""
    near: FloatArray = np.minimum(x, 20.0)  # beyond 20, ln cosh grows by exactly x in double precision
    return (x - near) + np.log1p(0.5 * np.expm1(-near) ** 2 * np.exp(near))


def saddlepoint_log10(b: ArrayLike, z: float | FloatArray) -> float | FloatArray:
    r"""Return log10 of the Lugannani–Rice tail of Σ b_k w_k at z √(Σ b²), whatever the weights.

    Parameters
    ----------
    b : (n,) array_like of float
        Weights, not all zero.
    z : float or ndarray of float
        Thresholds with |z| √(Σ b²) < Σ|b|.

    Notes
    -----
    With K(θ) = Σ ln cosh(θ b_k), K'(θ) = z, r = sign(θ) √(2(θz − K)) and u = θ √K''(θ),
    P = Q(r) + φ(r) (1/u − 1/r) (Lugannani and Rice, Adv. Appl. Prob. 12, 1980, in the form of Daniels,
    Int. Stat. Rev. 55, 1987), evaluated as ln φ(r) + ln(Q(r)/φ(r) + 1/u − 1/r), which does not underflow.
    """
    a = unit_weights(b)
    thresholds = _checked_thresholds(z)
    if not (np.abs(thresholds) < a.sum()).all():
        raise Wm3dError("The saddlepoint exists only for thresholds with |z| √(Σ b²) < Σ|b|.")
    out = _saddlepoint_tail(a, np.atleast_1d(thresholds).ravel()).reshape(thresholds.shape)
    return float(out[()]) if np.ndim(z) == 0 else out


def _saddlepoint_tail(a: FloatArray, z: FloatArray) -> FloatArray:
    point = saddlepoint(a, np.abs(z))
    exponent = np.maximum(point.theta * np.abs(z) - point.cumulant, 0.0)  # r²/2
    r, u = np.sqrt(2 * exponent), point.theta * np.sqrt(point.curvature)
    # K'''(0) = 0 by symmetry, so 1/u − 1/r → −K''''(0) θ/8 = Σ a⁴ θ/4
    limit = point.theta * np.sum((a * a) ** 2) / 4
    regular = (point.theta > 1e-4) & (u > 0)
    correction = np.divide(1.0, u, out=limit, where=regular)
    correction = np.subtract(correction, np.divide(1.0, r, out=np.zeros_like(r), where=regular))
    mills = math.sqrt(math.pi / 2) * erfcx(r / math.sqrt(2))
    log_upper = np.minimum(-exponent - 0.5 * math.log(2 * math.pi) + np.log(mills + correction), 0.0)
    log_lower = np.log1p(-np.minimum(np.exp(log_upper), 0.5))
    log_tail: FloatArray = np.where(z >= 0, log_upper, log_lower)
    return log_tail / LN10


def hoeffding_log10(b: ArrayLike, z: float | FloatArray) -> float | FloatArray:
    """Return log10 of Hoeffding's bound exp(−z²/2) ≥ P(Σ b_k w_k ≥ z √(Σ b²)); 1 for z ≤ 0 or all-zero b.

    Parameters
    ----------
    b : (n,) array_like of float
        Weights; in units of √(Σ b²) the bound is the same for all of them.
    z : float or ndarray of float
        Thresholds (Hoeffding, J. Am. Stat. Assoc. 58, 1963, theorem 2).
    """
    thresholds = _checked_thresholds(z)
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
        The least z (within 10⁻¹² of Σ|b|) with log10_tail(b, z) ≤ log10_pf, or inf if even a single key,
        with its probability 2^−n over n nonzero weights, is likelier than that.

    Raises
    ------
    Wm3dError
        If log10_pf is not below 0.
    """
    if not log10_pf < 0:
        raise Wm3dError(
            f"log10_pf is {log10_pf}; a false-alarm probability below 1 has a negative logarithm."
        )
    a = unit_weights(b)
    if log10_pf < -a.size * LOG10_2:
        return math.inf
    reach = float(a.sum())

    def excess(z: float) -> float:
        return max(log10_tail(a, z), -1e300) - log10_pf

    step = _TIE * reach
    z = reach if excess(reach) >= 0 else float(brentq(excess, -2 * reach, reach, xtol=step))
    while excess(z) > 0:  # the tail of a discrete sum jumps: go to the side that keeps Pf
        z, step = z + step, 2 * step
    return z
