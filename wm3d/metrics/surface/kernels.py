"""Numba kernels of the surface metrics: cells of triangles, their moments and bounds.

One thread each. Points and triangles are in units of the size of the mesh. Numpy twins stand in the tests.
"""

import math

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray
from wm3d.metrics.surface.tree.kernels import Vector, nearest_on_triangle

STACK = 128
"""Triangles that wait while one is bisected: 2^-64 of an edge is below the rounding of its ends."""

NEEDLE = math.log2(3)
"""Power of its length with which the cells of a triangle without area grow: three times as many at double."""


@njit(cache=True, error_model="numpy", nogil=True)
def cells(corners: FloatArray, spacing: float) -> tuple[FloatArray, IntArray]:
    """Bisect triangles (m, 3, 3) at the longest edge until no edge is longer than `spacing`.

    Returns the cells (k, 3, 3) and the triangle (k,) of each, in the order of the triangles. Bisection keeps
    needles cheap: a regular grid in a triangle of no area would have as many cells as in one of full height.
    """
    found, parent = np.empty((2 * len(corners), 9)), np.empty(2 * len(corners), np.int64)
    stack = np.empty((STACK, 9))  # bisection to depth d leaves at most d + 1 triangles on it
    count = 0
    for f in range(len(corners)):
        for k in range(9):
            stack[0, k] = corners[f, k // 3, k % 3]
        height = 1
        while height > 0:
            top = stack[height - 1]
            a, b, c = _longest_edge_first(top)
            if height < STACK and _square(top, a, b) > spacing * spacing:
                _bisect(top, stack[height], a, b, c)
                height += 1
                continue
            if count == len(found):
                found, parent = _doubled(found, parent)
            for k in range(9):
                found[count, k] = top[k]
            parent[count] = f
            count += 1
            height -= 1
    return found[:count].copy().reshape((count, 3, 3)), parent[:count].copy()


@njit(cache=True, error_model="numpy", nogil=True)
def cells_cut(corners: FloatArray, spacing: float) -> float:
    """About how many `cells` those triangles (m, 3, 3) make that have an edge longer than `spacing`.

    By the area, of which no cell has more than an equilateral one, and by the longest edge if they are slim.
    """
    count = 0.0
    for f in range(len(corners)):
        longest = 0.0
        for k in range(3):
            x, y, z = _offset(corners[f, k], corners[f, k - 1])
            longest = max(longest, np.sqrt(x * x + y * y + z * z))
        if longest > spacing:
            ux, uy, uz = _offset(corners[f, 1], corners[f, 0])
            wx, wy, wz = _offset(corners[f, 2], corners[f, 0])
            x, y, z = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
            area = np.sqrt(x * x + y * y + z * z) / 2.0
            count += max((longest / spacing) ** NEEDLE, area / (np.sqrt(3.0) / 4.0 * spacing * spacing))
    return count


@njit(cache=True)
def _longest_edge_first(t: FloatArray) -> tuple[int, int, int]:
    """Where in a triangle (9,) the corners a, b, c start whose edge a b is the longest."""
    ab, bc, ca = _square(t, 0, 3), _square(t, 3, 6), _square(t, 6, 0)
    if ab >= bc and ab >= ca:
        return 0, 3, 6
    return (3, 6, 0) if bc >= ca else (6, 0, 3)


@njit(cache=True)
def _square(t: FloatArray, a: int, b: int) -> float:
    """Squared distance of the points that start at a and b."""
    x, y, z = t[a] - t[b], t[a + 1] - t[b + 1], t[a + 2] - t[b + 2]
    square: float = x * x + y * y + z * z
    return square


@njit(cache=True)
def _bisect(first: FloatArray, second: FloatArray, a: int, b: int, c: int) -> None:
    """Replace a triangle (9,) by its half at corner a, and write the half at corner b to `second`."""
    for k in range(3):
        middle = 0.5 * (first[a + k] + first[b + k])
        second[a + k], second[b + k], second[c + k] = middle, first[b + k], first[c + k]
        first[b + k] = middle


@njit(cache=True)
def _doubled(found: FloatArray, parent: IntArray) -> tuple[FloatArray, IntArray]:
    n = len(found)
    more, parents = np.empty((2 * n, 9)), np.empty(2 * n, np.int64)
    for i in range(n):
        for k in range(9):
            more[i, k] = found[i, k]
        parents[i] = parent[i]
    return more, parents


@njit(cache=True, error_model="numpy", nogil=True)
def moments(cells: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Centroids (k, 3) of triangles (k, 3, 3), twice their areas (k,), and how far they reach from there.

    The reach is given as the greatest distance of a point (k,) and as the mean squared distance (k,), which
    is a twelfth of the summed squared distances of the corners.
    """
    n = len(cells)
    centroids, areas, reach, spread = np.empty((n, 3)), np.empty(n), np.zeros(n), np.zeros(n)
    for i in range(n):
        ux, uy, uz = _offset(cells[i, 1], cells[i, 0])
        wx, wy, wz = _offset(cells[i, 2], cells[i, 0])
        x, y, z = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
        areas[i] = np.sqrt(x * x + y * y + z * z)
        for k in range(3):
            centroids[i, k] = (cells[i, 0, k] + cells[i, 1, k] + cells[i, 2, k]) / 3.0
        for j in range(3):
            x, y, z = _offset(cells[i, j], centroids[i])
            square = x * x + y * y + z * z
            reach[i] = max(reach[i], square)
            spread[i] += square / 12.0
        reach[i] = np.sqrt(reach[i])
    return centroids, areas, reach, spread


@njit(cache=True, error_model="numpy", nogil=True)
def farthest_corner(cells: FloatArray, corners: FloatArray, triangle: IntArray) -> FloatArray:
    """Greatest squared distance (k,) of the corners of cells (k, 3, 3) from one triangle each.

    The distance from a convex set is convex, so no point of the cell is farther from that triangle.
    """
    farthest = np.zeros(len(cells))
    for i in range(len(cells)):
        for j in range(3):
            p = (cells[i, j, 0], cells[i, j, 1], cells[i, j, 2])
            farthest[i] = max(farthest[i], nearest_on_triangle(p, corners, triangle[i])[0])
    return farthest


@njit(cache=True)
def _offset(p: FloatArray, origin: FloatArray) -> Vector:
    return p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]


@njit(cache=True, error_model="numpy", nogil=True)
def angles(u: FloatArray, v: FloatArray, i: IntArray, j: IntArray) -> FloatArray:
    """Angles (k,) in radians between the vectors u[i] and v[j]; exactly 0 between equal vectors."""
    out = np.empty(len(i))
    for n in range(len(i)):
        ux, uy, uz = u[i[n], 0], u[i[n], 1], u[i[n], 2]
        vx, vy, vz = v[j[n], 0], v[j[n], 1], v[j[n], 2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        out[n] = np.arctan2(np.sqrt(x * x + y * y + z * z), ux * vx + uy * vy + uz * vz)
    return out
