"""Numba kernels of registration: the points of a surface near a place, and probes of it in many poses.

A pose takes a probe p to size · turn p + shift. What is near there is looked up from the cells of a cube
about the origin, numbered along z, then y, then x; for a place outside the cube, from its nearest cell.
"""

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray
from wm3d.metrics.surface.tree.kernels import box_distance

GRID, HALF_WIDTH = 50, 2.5
"""Cells along a side of the cube in which landmarks are looked up, and half its width, in sizes."""

CELL = 2 * HALF_WIDTH / GRID

OFF, NEARNESS = 0.25, 0.3
"""Distance from a landmark's tangent plane that counts in full, and what the distance from it counts beside.
A smooth surface lies near to landmarks in wrong places too, but not in their planes."""

Vector = tuple[float, float, float]


@njit(cache=True, nogil=True)
def means_near(
    places: FloatArray, points: FloatArray, normals: FloatArray, boxes: FloatArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """Mean of the `count` points nearest to each of (k, 3) places, and that of their normals: (k, 3) each.

    `points` and `normals` (m, 3), m ≥ `count`, stand in the order of a tree, whose `boxes` are those of
    `wm3d.metrics.surface.boxes`.
    """
    mean, mean_normal = np.zeros((len(places), 3)), np.zeros((len(places), 3))
    stack, bound = np.empty(len(boxes), np.int64), np.empty(len(boxes))
    index, square = np.zeros(count, np.int64), np.empty(count)
    for n in range(len(places)):
        _search((places[n, 0], places[n, 1], places[n, 2]), points, boxes, stack, bound, square, index)
        for k in range(count):
            for i in range(3):
                mean[n, i] += points[index[k], i]
                mean_normal[n, i] += normals[index[k], i]
    return mean / count, mean_normal / count


@njit(cache=True)
def _search(
    p: Vector,
    points: FloatArray,
    boxes: FloatArray,
    stack: IntArray,
    bound: FloatArray,
    square: FloatArray,
    index: IntArray,
) -> None:
    """Find the points nearest to `p`: their squared distances, the least first, and their places."""
    leaves = len(boxes) >> 1
    square[:] = np.inf
    stack[0], bound[0] = 0, 0.0
    height = 1
    while height > 0:
        height -= 1
        if bound[height] >= square[-1]:
            continue
        node = stack[height]
        if node >= leaves:
            k = node - leaves
            for t in range(len(points) * k // (leaves + 1), len(points) * (k + 1) // (leaves + 1)):
                _keep(p, points, t, square, index)
            continue
        near, far = 2 * node + 1, 2 * node + 2
        to_near, to_far = box_distance(p, boxes, near), box_distance(p, boxes, far)
        if to_far < to_near:
            near, far, to_near, to_far = far, near, to_far, to_near
        stack[height], bound[height] = far, to_far
        stack[height + 1], bound[height + 1] = near, to_near
        height += 2


@njit(cache=True)
def _keep(p: Vector, points: FloatArray, t: int, square: FloatArray, index: IntArray) -> None:
    """Insert point `t` among those kept, by its squared distance, if it is nearer than the last of them."""
    x, y, z = p[0] - points[t, 0], p[1] - points[t, 1], p[2] - points[t, 2]
    distance = x * x + y * y + z * z
    if distance >= square[-1]:
        return
    k = len(square) - 1
    while k > 0 and square[k - 1] > distance:
        square[k], index[k] = square[k - 1], index[k - 1]
        k -= 1
    square[k], index[k] = distance, t


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
            i = nearest[cell]
            off = (x - points[i, 0]) * normals[i, 0] + (y - points[i, 1]) * normals[i, 1]
            off = abs(off + (z - points[i, 2]) * normals[i, 2])
            total += min(off, OFF) + NEARNESS * distance[cell]
        means[n] = total / len(probes)
    return means


@njit(cache=True)
def _turned(points: FloatArray, turn: FloatArray) -> FloatArray:
    turned = np.empty_like(points)
    for k in range(len(points)):
        for i in range(3):
            turned[k, i] = turn[i, 0] * points[k, 0] + turn[i, 1] * points[k, 1] + turn[i, 2] * points[k, 2]
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
