"""The Lugannani–Rice saddlepoint approximation to the tail of a Rademacher sum, in logarithms."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erfcx

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.stats.weights import checked_thresholds, tie_slack, unit_weights

LN10 = math.log(10.0)

_BLOCK = 1 << 18  # elements of a temporary (thresholds x weights); 2 MB stays in cache


class Saddlepoint(NamedTuple):
    """Where K'(θ) = z, for K(θ) = Σ ln cosh(θ a_k) and Σ a_k² = 1; each field has the shape of z."""

    theta: FloatArray
    cumulant: FloatArray
    """K(θ)."""
    curvature: FloatArray
    """K''(θ)."""


class Cumulants(NamedTuple):
    """K(θ) = Σ ln cosh(θ a_k) at one θ, with its first two derivatives."""

    value: float
    slope: float
    curvature: float


def cumulants(a: FloatArray, theta: float) -> Cumulants:
    """Return K(θ), K'(θ) and K''(θ) for (n,) positive weights and one θ ≥ 0."""
    slope, curvature = _derivatives(a, np.array([theta]))
    return Cumulants(float(_ln_cosh(theta * a).sum()), float(slope[0]), float(curvature[0]))


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
    theta, most = z, 0.01 / tie_slack(a)  # beyond it, θz − K would tell ties apart
    for _ in range(200):
        slope, curvature = _derivatives(a, theta)
        # a step backwards is rounding; 4θ bounds the step where the curvature underflows
        step = np.clip((z - slope) / np.maximum(curvature, np.finfo(float).tiny), 0.0, 4 * theta)
        step = np.minimum(step, most - theta)
        theta = theta + step
        if np.all(step <= 1e-5 * theta):
            break  # and the error, by quadratic convergence, is below 1e-10 θ
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
    if x.max(initial=0.0) < 3:  # twice as fast, but 1 − tanh² loses its digits beyond
        t: FloatArray = np.tanh(x)
        return -0.5 * np.log1p(-t * t)
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
    thresholds = checked_thresholds(z)
    if not (np.abs(thresholds) < a.sum()).all():
        raise Wm3dError("The saddlepoint exists only for thresholds with |z| √(Σ b²) < Σ|b|.")
    out = saddlepoint_tail(a, np.atleast_1d(thresholds).ravel()).reshape(thresholds.shape)
    return float(out[()]) if np.ndim(z) == 0 else out


def saddlepoint_tail(a: FloatArray, z: FloatArray) -> FloatArray:
    """Log10 of the approximation for unit weights and (m,) thresholds within ±Σ a."""
    point = saddlepoint(a, np.abs(z))
    exponent = np.maximum(point.theta * np.abs(z) - point.cumulant, 0.0)  # r²/2
    r, u = np.sqrt(2 * exponent), point.theta * np.sqrt(point.curvature)
    # K'''(0) = 0 by symmetry, so 1/u − 1/r → −K''''(0) θ/8 = Σ a⁴ θ/4
    limit = point.theta * np.sum((a * a) ** 2) / 4
    regular = (point.theta > 1e-4) & (u > 0) & (r > 0)
    correction = np.divide(1.0, u, out=limit, where=regular)
    correction = np.subtract(correction, np.divide(1.0, r, out=np.zeros_like(r), where=regular))
    mills = math.sqrt(math.pi / 2) * erfcx(r / math.sqrt(2))
    log_upper = np.minimum(-exponent - 0.5 * math.log(2 * math.pi) + np.log(mills + correction), 0.0)
    log_lower = np.log1p(-np.minimum(np.exp(log_upper), 0.5))
    log_tail: FloatArray = np.where(z >= 0, log_upper, log_lower)
    return log_tail / LN10
