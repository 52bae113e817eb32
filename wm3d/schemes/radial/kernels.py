"""Numba kernels of the radial schemes: faces cut into equal triangles, their centroids as sample points."""

import math

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray


@njit(cache=True, error_model="numpy")
def cuts(vertices: FloatArray, faces: IntArray, spacing: float, most: int) -> IntArray:
    """Return how many parts of each edge of a face keep them all within `spacing`, at most `most`: (m,)."""
    parts = np.empty(len(faces), dtype=np.int64)
    for f in range(len(faces)):
        longest = 0.0
        for j in range(3):
            a, b = faces[f, j], faces[f, (j + 1) % 3]
            square = 0.0
            for axis in range(3):
                square += (vertices[a, axis] - vertices[b, axis]) ** 2
            longest = max(longest, square)
        parts[f] = min(max(1, math.ceil(math.sqrt(longest) / spacing)), most)
    return parts


@njit(cache=True, error_model="numpy")
def samples(
    vertices: FloatArray, faces: IntArray, parts: IntArray, center: FloatArray
) -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
    """Return the parts of all faces, each taken at its centroid.

    A face whose edges are cut into s parts gives s² equal triangles, k = Σ s² in all.

    Returns
    -------
    radii, areas : (k,) ndarray
        Distance from the centre, and area.
    face : (k,) ndarray
    shares : (k, 3) ndarray
        Weights of the corners of the face at the point.
    """
    total = 0
    for f in range(len(faces)):
        total += parts[f] ** 2
    radii, areas = np.empty(total), np.empty(total)
    face, shares = np.empty(total, dtype=np.int64), np.empty((total, 3))
    e, d = np.empty(3), np.empty(3)
    at = 0
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        for axis in range(3):
            e[axis] = vertices[b, axis] - vertices[a, axis]
            d[axis] = vertices[c, axis] - vertices[a, axis]
        n0, n1, n2 = e[1] * d[2] - e[2] * d[1], e[2] * d[0] - e[0] * d[2], e[0] * d[1] - e[1] * d[0]
        area, s = 0.5 * math.sqrt(n0 * n0 + n1 * n1 + n2 * n2), parts[f]
        for i in range(s):
            for j in range(s - i):
                for flipped in range(2 if i + j < s - 1 else 1):
                    u, v = (i + (1 + flipped) / 3) / s, (j + (1 + flipped) / 3) / s
                    square = 0.0
                    for axis in range(3):
                        square += (vertices[a, axis] + u * e[axis] + v * d[axis] - center[axis]) ** 2
                    radii[at], areas[at], face[at] = math.sqrt(square), area / s**2, f
                    shares[at, 0], shares[at, 1], shares[at, 2] = 1 - u - v, u, v
                    at += 1
    return radii, areas, face, shares
