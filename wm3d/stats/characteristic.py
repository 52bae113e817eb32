"""Compiled kernel of the characteristic function of a tilted Rademacher sum, and its plain numpy twin."""

import math

import numpy as np
from numba import njit

from wm3d.arrays import ComplexArray, FloatArray

NEGLIGIBLE = 1e-14
"""Values smaller than that are given as 0."""

_BLOCK = 128  # points whose factors are made from those of the first one: no sine for each
_TURNED = 256  # weights that are treated so; their table takes 0.5 MB
_BETWEEN = 16  # weights after which it is asked whether anything is left of a block


@njit(cache=True, nogil=True)
def characteristic(a: FloatArray, tilt: FloatArray, step: float, points: int) -> ComplexArray:
    """Return Π_k (cos u a_k + i t_k sin u a_k) at u = 0, 1, 2, ... times `step`.

    Parameters
    ----------
    a : (n,) ndarray of float
        Weights. The product is formed in their order and ends where it is negligible.
    tilt : (n,) ndarray of float
        t_k = tanh(θ a_k), the mean of each sign under the tilted law.
    step : float
        Between neighbouring u.
    points : int
        How many u.

    Returns
    -------
    (points,) ndarray of complex
        Values below `NEGLIGIBLE` in size are 0.
    """
    out = np.zeros(points, np.complex128)
    m = min(a.size, _TURNED)
    table = np.empty((m, 2, _BLOCK))
    for k in range(m):
        for j in range(_BLOCK):
            table[k, 0, j], table[k, 1, j] = math.cos(j * step * a[k]), math.sin(j * step * a[k])
    x, y = np.empty(_BLOCK), np.empty(_BLOCK)
    for first in range(0, points, _BLOCK):
        x[:], y[:] = 1.0, 0.0
        if _multiply_block(x, y, a, tilt, first * step, table):
            for j in range(min(_BLOCK, points - first)):
                out[first + j] = _multiply(x[j], y[j], a, tilt, (first + j) * step, m)
    return out


@njit(cache=True, nogil=True)
def _multiply_block(
    x: FloatArray, y: FloatArray, a: FloatArray, tilt: FloatArray, u: float, table: FloatArray
) -> bool:
    """Multiply x + iy by the factors in the table, from u on; tell whether any value is left."""
    for k in range(len(table)):
        c0, s0, t = math.cos(u * a[k]), math.sin(u * a[k]), tilt[k]
        row_c, row_s = table[k]
        for j in range(_BLOCK):
            c = c0 * row_c[j] - s0 * row_s[j]
            s = t * (s0 * row_c[j] + c0 * row_s[j])
            x[j], y[j] = x[j] * c - y[j] * s, x[j] * s + y[j] * c
        if k % _BETWEEN == _BETWEEN - 1:
            most = 0.0
            for j in range(_BLOCK):
                most = max(most, x[j] * x[j] + y[j] * y[j])
            if most < NEGLIGIBLE**2:
                return False
    return True


@njit(cache=True, nogil=True)
def _multiply(x: float, y: float, a: FloatArray, tilt: FloatArray, u: float, start: int) -> complex:
    """Return x + iy times the factors from `start` on at u, or 0 where it is negligible."""
    for k in range(start, a.size):
        if x * x + y * y < NEGLIGIBLE**2:
            break
        c, s = math.cos(u * a[k]), tilt[k] * math.sin(u * a[k])
        x, y = x * c - y * s, x * s + y * c
    return complex(x, y) if x * x + y * y >= NEGLIGIBLE**2 else 0j


def characteristic_numpy(a: FloatArray, tilt: FloatArray, step: float, points: int) -> ComplexArray:
    """Do what `characteristic` does, in plain numpy."""
    angle = np.multiply.outer(np.arange(points) * step, a)
    out: ComplexArray = (np.cos(angle) + 1j * tilt * np.sin(angle)).prod(axis=1)
    return np.where(np.abs(out) < NEGLIGIBLE, 0, out)
