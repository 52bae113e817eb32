"""Numba kernels of the search for a pose: how far probes of a surface lie off landmarks in many poses.

A pose takes a probe p to size · turn p + shift. What is near is looked up from the cells of a cube about the
origin, numbered along z, then y, then x; for a place outside the cube, from its nearest cell.
"""

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray

GRID, HALF_WIDTH = 50, 2.5
"""Cells along a side of the cube in which landmarks are looked up, and half its width, in sizes."""

CELL = 2 * HALF_WIDTH / GRID

OFF, NEARNESS = 0.25, 0.3
"""Distance from a landmark's tangent plane that counts in full, and what the distance from it counts beside.
A smooth surface lies near to landmarks in wrong places too, but not in their planes."""

Vector = tuple[float, float, float]


@njit(cache=True)
def cells(places: FloatArray) -> IntArray:
    """Numbers of the cells in which (n, 3) places lie, or nearly: (n,)."""
    numbers = np.empty(len(places), dtype=np.int64)
    for n in range(len(places)):
        numbers[n] = _cell((places[n, 0], places[n, 1], places[n, 2]))
    return numbers


@njit(cache=True)
def nearest_tried(
    probes: FloatArray, turns: FloatArray, sizes: FloatArray, shifts: FloatArray, distance: FloatArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Least mean of the cells' `distance` from (k, 3) probes, over all sizes and shifts, for each turn.

    Turns (n, 3, 3), sizes (a,), shifts (b, 3). Returns the means and the places of size and shift: (n,) each.
    """
    least = np.full(len(turns), np.inf)
    size, shift = np.zeros(len(turns), dtype=np.int64), np.zeros(len(turns), dtype=np.int64)
    for n in range(len(turns)):
        turned = _turned(probes, turns[n])
        for a in range(len(sizes)):
            for b in range(len(shifts)):
                total = 0.0
                for k in range(len(probes)):
                    total += distance[_cell(_placed(turned[k], sizes[a], shifts[b]))]
                if total / len(probes) < least[n]:
                    least[n], size[n], shift[n] = total / len(probes), a, b
    return least, size, shift


@njit(cache=True)
def misfits(
    probes: FloatArray,
    turns: FloatArray,
    sizes: FloatArray,
    shifts: FloatArray,
    points: FloatArray,
    normals: FloatArray,
    nearest: IntArray,
    distance: FloatArray,
) -> FloatArray:
    """How far (k, 3) probes lie off the planes of landmarks in each of n poses, on average: (n,).

    Landmarks are `points` and `normals`; each cell holds the `nearest` of them and its `distance`.
    """
    means = np.empty(len(turns))
    for n in range(len(turns)):
        turned = _turned(probes, turns[n])
        total = 0.0
        for k in range(len(probes)):
            x, y, z = _placed(turned[k], sizes[n], shifts[n])
            cell = _cell((x, y, z))
            p, normal = points[nearest[cell]], normals[nearest[cell]]
            off = abs((x - p[0]) * normal[0] + (y - p[1]) * normal[1] + (z - p[2]) * normal[2])
            total += min(off, OFF) + NEARNESS * distance[cell]
        means[n] = total / len(probes)
    return means


@njit(cache=True)
def _turned(points: FloatArray, turn: FloatArray) -> FloatArray:
    turned = np.empty_like(points)
    for k in range(len(points)):
        x, y, z = points[k]
        for i in range(3):
            turned[k, i] = turn[i, 0] * x + turn[i, 1] * y + turn[i, 2] * z
    return turned


@njit(cache=True)
def _placed(point: FloatArray, size: float, shift: FloatArray) -> Vector:
    return size * point[0] + shift[0], size * point[1] + shift[1], size * point[2] + shift[2]


@njit(cache=True)
def _cell(place: Vector) -> int:
    x, y, z = place
    cell: int = (_layer(x) * GRID + _layer(y)) * GRID + _layer(z)
    return cell


@njit(cache=True)
def _layer(coordinate: float) -> int:
    return int(min(max((coordinate + HALF_WIDTH) / CELL, 0.0), GRID - 1.0))
