"""Numba kernels that carry a change of the range image over to the vertices (eqs. 9–12)."""

import math

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray
from wm3d.scanner.kernels import cosine_weight


@njit(cache=True, error_model="numpy")
def radial_normals(posed: FloatArray, faces: IntArray, outward: int) -> FloatArray:
    """Return each vertex's area-weighted outward normal, its components along s2 and s3 only: (n, 2)."""
    normals = np.zeros((len(posed), 2))
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        d0, d1, d2 = posed[b, 0] - posed[a, 0], posed[b, 1] - posed[a, 1], posed[b, 2] - posed[a, 2]
        e0, e1, e2 = posed[c, 0] - posed[a, 0], posed[c, 1] - posed[a, 1], posed[c, 2] - posed[a, 2]
        # the sign that the left-handed s1, s2, s3 ask for
        n1 = outward * (d0 * e2 - d2 * e0)
        n2 = outward * (d1 * e0 - d0 * e1)
        for vertex in (a, b, c):
            normals[vertex, 0] += n1
            normals[vertex, 1] += n2
    return normals


@njit(cache=True, error_model="numpy")
def radial_moves(
    posed: FloatArray, normals: FloatArray, change: FloatArray, hmin: float, height: float
) -> FloatArray:
    """Return how far each vertex moves along s2 and s3 so that the ranges change by Δl (eq. 12).

    Parameters
    ----------
    posed : (n, 3) ndarray
        Vertices in the cylinder's frame, in mesh units.
    normals : (n, 2) ndarray
        From `radial_normals`.
    change : (N_u, N_v) ndarray
        Δl (eq. 8), in mesh units.
    hmin, height : float
        Lower end and height h of the cylinder, in mesh units.

    Returns
    -------
    (n, 2) ndarray
        v' − v along s2 and s3, in mesh units.
    """
    rows, columns = change.shape
    moves = np.empty((len(posed), 2))
    for i in range(len(posed)):
        across, depth = posed[i, 1], posed[i, 2]
        facing = 1.0 if normals[i, 0] * across + normals[i, 1] * depth >= 0.0 else -1.0
        u = (posed[i, 0] - hmin) / height * rows - 0.5
        v = math.atan2(facing * across, facing * depth) / (2.0 * math.pi) * columns
        total = _interpolated(change, u, v)
        distance = math.hypot(across, depth)
        if distance > 0.0:
            moves[i, 0] = -total * facing * across / distance
            moves[i, 1] = -total * facing * depth / distance
        else:  # on the axis: the angle is taken as 0, along s3
            moves[i, 0], moves[i, 1] = 0.0, -total
    return moves


@njit(cache=True, error_model="numpy")
def image_at(posed: FloatArray, image: FloatArray, hmin: float, height: float) -> FloatArray:
    """Return an image (N_u, N_v) at the height and angle of each of (n, 3) vertices: (n,)."""
    rows, columns = image.shape
    values = np.empty(len(posed))
    for i in range(len(posed)):
        u = (posed[i, 0] - hmin) / height * rows - 0.5
        v = math.atan2(posed[i, 1], posed[i, 2]) / (2.0 * math.pi) * columns
        values[i] = _interpolated(image, u, v)
    return values


@njit(cache=True, error_model="numpy")
def _interpolated(image: FloatArray, u: float, v: float) -> float:
    """Weigh the cells around (u, v) by eqs. 10 and 11; zero beyond the first and last row.

    f(x) + f(x−1) = 1: of the 3×3 terms of eq. 12 only the four around (u, v) are not zero.
    """
    rows, columns = image.shape
    u0, v0 = math.floor(u), math.floor(v)
    fu, fv = cosine_weight(u - u0), cosine_weight(v - v0)
    left, right = v0 % columns, (v0 + 1) % columns
    total = 0.0
    if 0 <= u0 < rows:
        total += fu * (fv * image[u0, left] + (1.0 - fv) * image[u0, right])
    if 0 <= u0 + 1 < rows:
        total += (1.0 - fu) * (fv * image[u0 + 1, left] + (1.0 - fv) * image[u0 + 1, right])
    return total
