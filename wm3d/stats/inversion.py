"""The tail of a Rademacher sum by inverting its characteristic function: never below the truth."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from wm3d.arrays import ComplexArray, FloatArray
from wm3d.stats.characteristic import characteristic
from wm3d.stats.saddlepoint import LN10, cumulants
from wm3d.stats.weights import tie_slack

EXCESS = 0.002
"""What the result may be above the truth, as a share of it, where the sum has no clusters of its own."""

DEEPEST, FEW_SIGNS = 30 * LN10, 327
"""Exponent θz − K(θ) up to which the points are worth their time, and how many signs take few anywhere. For
all these θ √K''(θ) is at most 12."""

_GROWTH = 1.2  # from one tilt to the next; within it e^(θ²K''/2·0.2²) is lost to cancellation, 18 at most
_LEAST_TILT = 1.0
_FROZEN = 20.0  # θ a_k from which a sign is up for sure: its other value has a share below 1e-17
_BETA = 26.0  # of Kaiser's window; beyond u ε = β its transform is below 3e-10
_MARGIN = 23.0  # e^-23 = 1e-10 is what the neighbouring periods may add
_DEVIATIONS = 14.0  # half of it is where e^(-x²/2) is below 1e-10


class Contour(NamedTuple):
    """The integrand of one tilt θ, at the points where it is not negligible.

    Attributes
    ----------
    tilt : float
        θ, the real part of the line of integration.
    cumulant : float
        K(θ) = Σ ln cosh θ a_k.
    width : float
        ε: the sum is smoothed over ± this.
    frozen : float
        What the signs that are up for sure add to the sum; the integrand is that of the others.
    u : (n,) ndarray of float
        Imaginary parts, from 0 on.
    values : (n,) ndarray of complex
        At each of them, times step / π.
    """

    tilt: float
    cumulant: float
    width: float
    frozen: float
    u: FloatArray
    values: ComplexArray


def inversion_log10(a: FloatArray, z: FloatArray, theta: FloatArray) -> FloatArray:
    r"""Return a bound from above of log10 P(Σ ± a_k ≥ z) that is hardly above it.

    Parameters
    ----------
    a : (n,) ndarray of float
        Unit weights.
    z : (m,) ndarray of float
        Thresholds within ±Σ a.
    theta : (m,) ndarray of float
        Where K'(θ) = \|z\|.

    Notes
    -----
    For any θ > 0, with φ the characteristic function of the sum S under the law tilted by e^(θS),

        P(S ≥ z) = e^(K − θz) / π · Re ∫_0^∞ φ(u) e^(−iuz) / (θ + iu) du

    (the Bromwich integral). A sum of signs has atoms, so the integrand need not fade; that of S + U does, for
    U independent of S with the law of Kaiser's window on ±ε, whose transform all but ends at β / ε. S ≥ z
    implies S + U ≥ z − ε, which in turn implies S ≥ z − 2ε. So the tail of S + U from z − ε on is never below
    that of S, above it by at most 2θε of itself where sums lie evenly, and equal to it where none lies
    within 2ε below z. The trapezoidal sum adds what neighbouring periods hold, 1e-10 of the result.

    Below 0 it is one less the tail of S + U from ε beyond −z, which is no more than that of S beyond −z.
    """
    out = np.empty(z.shape)
    weights = np.sort(a)[::-1].tobytes()
    slack = tie_slack(a)
    steps = np.maximum(np.log(np.maximum(theta, _LEAST_TILT) / _LEAST_TILT) / math.log(_GROWTH), 0.0)
    for step in np.unique(steps.astype(np.int64)):
        contour = _contour(weights, int(step))
        here = steps.astype(np.int64) == step
        up = z[here] >= 0
        log_tail = _tail(contour, np.abs(z[here]) - np.where(up, 1, -1) * (contour.width + slack))
        below = np.log1p(-np.minimum(np.exp(log_tail), 0.5))
        out[here] = np.minimum(np.where(up, log_tail, below), 0.0) / LN10
    return out


def _tail(contour: Contour, t: FloatArray) -> FloatArray:
    """Natural logarithm of P(S + U ≥ t)."""
    free = t - contour.frozen
    sums = np.array([(contour.values * np.exp(-1j * x * contour.u)).sum().real for x in free])
    tails: FloatArray = np.log(np.maximum(sums, np.finfo(float).tiny)) + contour.cumulant - contour.tilt * t
    return tails


@lru_cache(maxsize=8)  # many keys are scored on one mesh
def _contour(weights: bytes, step: int) -> Contour:
    a = np.frombuffer(weights)
    theta = _LEAST_TILT * _GROWTH**step
    free = a[theta * a < _FROZEN]
    width = EXCESS / (2 * theta)
    du = 2 * math.pi / _period(a, theta)
    last = math.ceil(_BETA / width / du)
    phi = characteristic(_mixed(free), np.tanh(theta * _mixed(free)), du, last + 1)
    left = np.flatnonzero(phi)
    s = (theta + 1j * left * du).astype(np.complex128)
    values: ComplexArray = phi[left] * _kaiser(s * width) / s * (du / math.pi)
    values[0] /= 2
    frozen = float(a[: a.size - free.size].sum())
    return Contour(theta, cumulants(a, theta).value, width, frozen, s.imag, values)


def _period(a: FloatArray, theta: float) -> float:
    """Return how far apart the copies of the tail must lie that a sum in place of the integral adds up."""
    most = cumulants(a, _GROWTH * theta)  # of the thresholds that are asked with this tilt
    exponent = _GROWTH * theta * most.slope - most.value  # −ln P there, and a little less
    deviation = math.sqrt(cumulants(a, theta).curvature)
    return max(_DEVIATIONS * deviation, (exponent + _MARGIN) / theta)


def _mixed(a: FloatArray) -> FloatArray:
    """Put weights of all sizes first: together they tell soonest where nothing is left."""
    stride = max(1, a.size // 64)
    return np.concatenate([a[start::stride] for start in range(stride)])


def _kaiser(x: ComplexArray) -> ComplexArray:
    """Moment generating function of Kaiser's window of parameter β on ±1 (Proc. IEEE ISCAS, 1974)."""
    root: ComplexArray = np.sqrt(_BETA**2 + x * x)
    out: ComplexArray = np.sinh(root) / root * (_BETA / math.sinh(_BETA))
    return out
