"""Weights and thresholds of a Rademacher sum, checked and brought to unit variance."""

import numpy as np
from numpy.typing import ArrayLike

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError

_TIE = 1e-12  # share of the largest sum


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


def checked_thresholds(z: ArrayLike) -> FloatArray:
    """Return the thresholds as float64, or raise `Wm3dError` if one is NaN."""
    thresholds = np.asarray(z, dtype=np.float64)
    if np.isnan(thresholds).any():
        raise Wm3dError("A threshold z is NaN; give a number, or inf or -inf.")
    return thresholds


def tie_slack(a: FloatArray) -> float:
    """Return the distance within which sums of the weights are ties: rounding must not split an atom."""
    return _TIE * float(a.sum())
