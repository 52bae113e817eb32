"""Rotations that lie evenly, and the choice of some that lie apart."""

from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from wm3d.arrays import FloatArray, IntArray

TURNS = 2000
"""Rotations among which fits look for their starts; one of them is within 19° of any."""


@cache
def turns(count: int) -> FloatArray:
    """Return rotations that lie evenly, a super-Fibonacci spiral (Alexa, CVPR 2022): (count, 3, 3)."""
    s = np.arange(count) + 0.5
    inner, outer = np.sqrt(s / count), np.sqrt(1 - s / count)
    alpha, beta = 2 * np.pi * s / np.sqrt(2), 2 * np.pi * s / 1.533751168755204288118041
    quaternions: list[FloatArray] = [
        inner * np.sin(alpha),
        inner * np.cos(alpha),
        outer * np.sin(beta),
        outer * np.cos(beta),
    ]
    return Rotation.from_quat(np.column_stack(quaternions)).as_matrix()


def apart(ordered: FloatArray, degrees: float, most: int) -> IntArray:
    """Return the places of the first among (k, 3, 3) turns that differ from each other by that angle."""
    chosen: list[int] = []
    flat = ordered.reshape(len(ordered), 9)
    least = 1 + 2 * np.cos(np.radians(degrees))  # tr(RᵀS) = 1 + 2 cos of the angle between R and S
    free = np.ones(len(flat), dtype=bool)
    while len(chosen) < most and free.any():
        chosen.append(int(free.argmax()))
        free &= flat @ flat[chosen[-1]] < least
    return np.array(chosen)
