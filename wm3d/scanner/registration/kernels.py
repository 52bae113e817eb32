"""Numba kernels of registration: the points of a surface near a place, and probes of it in many poses.

A pose takes a probe p to size · turn p + shift. What is near there is looked up from the cells of a cube
about the origin, numbered along z, then y, then x; for a place outside the cube, from its nearest cell.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from wm3d.arrays import FloatArray, IntArray
from wm3d.metrics.surface.tree.kernels import box_distance

GRID, HALF_WIDTH = 50, 2.5
"""Cells along a side of the cube in which landmarks are looked up, and half its width, in sizes."""

CELL = 2 * HALF_WIDTH / GRID

TOGETHER = 16
"""Probes that are looked up in one go, as a processor does best."""

OFF, NEARNESS, TILT = 0.25, 0.3, 0.1
"""Distance from a landmark's tangent plane that counts in full, and what the distance from the landmark and
1 − the cosine of the normals count beside. A smooth surface lies near to landmarks in wrong places too, but
not in their planes."""

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


@njit(cache=True, nogil=True)
def preimages(
    images: FloatArray, coefficients: FloatArray, back: FloatArray, rounds: int, farthest: float
) -> FloatArray:
    """Find the points (k, 3) that a warp takes to `images`, by so many rounds of a fixed-point iteration.

    `coefficients` (10, 3) are those of `Warp`, `back` (3, 3) is the inverse of their linear rows; no
    coordinate gets beyond `farthest`.
    """
    points = np.empty((len(images), 3))
    for n in range(len(images)):
        image = (
            images[n, 0] - coefficients[0, 0],
            images[n, 1] - coefficients[0, 1],
            images[n, 2] - coefficients[0, 2],
        )
        point = _times(image, back)
        for _ in range(rounds):
            x, y, z = _bent(point, coefficients)
            x, y, z = _times((image[0] - x, image[1] - y, image[2] - z), back)
            point = (
                min(max(x, -farthest), farthest),
                min(max(y, -farthest), farthest),
                min(max(z, -farthest), farthest),
            )
        points[n, 0], points[n, 1], points[n, 2] = point
    return points


@njit(cache=True, nogil=True)
def compared(
    points: FloatArray,
    normals: FloatArray,
    goals: FloatArray,
    goal_normals: FloatArray,
    coefficients: FloatArray,
    back: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Compare warped points of a surface with points of another: (k,) each.

    Returns their distances from the tangent planes there, their distances, and the cosines of the normals; 0
    where a surface has no normal. The normals go with the linear part of the warp; see `preimages`.
    """
    off, far, cosine = np.empty(len(points)), np.empty(len(points)), np.zeros(len(points))
    for n in range(len(points)):
        p = (points[n, 0], points[n, 1], points[n, 2])
        x, y, z = _bent(p, coefficients)
        u, v, w = _times(p, coefficients[1:4])
        x += coefficients[0, 0] + u - goals[n, 0]
        y += coefficients[0, 1] + v - goals[n, 1]
        z += coefficients[0, 2] + w - goals[n, 2]
        far[n] = math.sqrt(x * x + y * y + z * z)
        off[n] = x * goal_normals[n, 0] + y * goal_normals[n, 1] + z * goal_normals[n, 2]
        x, y, z = _times((normals[n, 0], normals[n, 1], normals[n, 2]), back.T)
        length = math.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            x, y, z = x * goal_normals[n, 0], y * goal_normals[n, 1], z * goal_normals[n, 2]
            cosine[n] = (x + y + z) / length
    return off, far, cosine


@njit(cache=True)
def _times(row: Vector, matrix: FloatArray) -> Vector:
    x, y, z = row
    return (
        x * matrix[0, 0] + y * matrix[1, 0] + z * matrix[2, 0],
        x * matrix[0, 1] + y * matrix[1, 1] + z * matrix[2, 1],
        x * matrix[0, 2] + y * matrix[1, 2] + z * matrix[2, 2],
    )


@njit(cache=True)
def _bent(point: Vector, coefficients: FloatArray) -> Vector:
    """Return what the quadratic terms of a warp add to a point."""
    x, y, z = point
    c = coefficients[4:]
    xx, yy, zz, xy, yz, zx = x * x, y * y, z * z, x * y, y * z, z * x
    return (
        xx * c[0, 0] + yy * c[1, 0] + zz * c[2, 0] + xy * c[3, 0] + yz * c[4, 0] + zx * c[5, 0],
        xx * c[0, 1] + yy * c[1, 1] + zz * c[2, 1] + xy * c[3, 1] + yz * c[4, 1] + zx * c[5, 1],
        xx * c[0, 2] + yy * c[1, 2] + zz * c[2, 2] + xy * c[3, 2] + yz * c[4, 2] + zx * c[5, 2],
    )


@njit(cache=True)
def cells(places: FloatArray) -> IntArray:
    """Numbers of the cells in which (n, 3) places lie, or nearly: (n,)."""
    numbers = np.empty(len(places), dtype=np.int64)
    for n in range(len(places)):
        numbers[n] = _cell((places[n, 0], places[n, 1], places[n, 2]))
    return numbers


@njit(cache=True, nogil=True)
def nearest_tried(
    probes: FloatArray,
    turns: FloatArray,
    sizes: FloatArray,
    shifts: IntArray,
    distance: NDArray[np.int32],
    power: float,
) -> tuple[FloatArray, IntArray, IntArray]:
    """Least mean of the cells' `distance` from (k, 3) probes, over all sizes and shifts, for each turn.

    Turns (n, 3, 3), sizes (a,), shifts (b, 3) in cells; `distance` is the cube in whole numbers, with as many
    more cells on both sides of an axis as shifts go. A probe beside the cube is taken for one in the nearest
    cell before it is shifted. Means are divided by a power of the size. Returns them and the places of size
    and shift: (n,) each.
    """
    least = np.full(len(turns), np.inf)
    size, shift = np.zeros(len(turns), dtype=np.int64), np.zeros(len(turns), dtype=np.int64)
    rows, row = distance.shape[1:]
    more = (np.array(distance.shape) - GRID) // 2 + shifts
    steps, flat = (more[:, 0] * rows + more[:, 1]) * row + more[:, 2], distance.ravel()
    cell, still = np.empty(len(probes), dtype=np.int32), np.zeros(3)
    for n in range(len(turns)):
        turned = _turned(probes, turns[n])
        for a in range(len(sizes)):
            for k in range(len(probes)):
                x, y, z = _placed(turned[k], sizes[a], still)
                cell[k] = (_layer(x) * rows + _layer(y)) * row + _layer(z)
            share = 1 / len(probes) / sizes[a] ** power
            for b in range(len(steps)):
                total = _sum_below(flat, cell, np.int32(steps[b]), least[n] / share)
                if share * total < least[n]:
                    least[n], size[n], shift[n] = share * total, a, b
    return least, size, shift


@njit(cache=True)
def _sum_below(flat: NDArray[np.int32], cell: NDArray[np.int32], step: int, limit: float) -> int:
    """Sum of the cells a step on, or a part of it that is not below the limit."""
    total, first = 0, 0
    while first < len(cell) and total < limit:
        last = min(first + TOGETHER, len(cell))
        part = np.int32(0)
        for k in range(first, last):
            part += flat[cell[k] + step]
        total, first = total + int(part), last
    return total


@njit(cache=True, nogil=True)
def misfits(
    probes: FloatArray,
    probe_normals: FloatArray,
    turns: FloatArray,
    sizes: FloatArray,
    shifts: FloatArray,
    points: FloatArray,
    normals: FloatArray,
    nearest: IntArray,
    distance: FloatArray,
) -> FloatArray:
    """How far (k, 3) probes lie off landmarks in each of n poses, on average: (n,). See `OFF`.

    Landmarks are `points` and `normals`; each cell holds the `nearest` of them and its `distance`.
    """
    means = np.empty(len(turns))
    for n in range(len(turns)):
        turned, turned_normals = _turned(probes, turns[n]), _turned(probe_normals, turns[n])
        total = 0.0
        for k in range(len(probes)):
            x, y, z = _placed(turned[k], sizes[n], shifts[n])
            cell = _cell((x, y, z))
            i = nearest[cell]
            off = (x - points[i, 0]) * normals[i, 0] + (y - points[i, 1]) * normals[i, 1]
            off = abs(off + (z - points[i, 2]) * normals[i, 2])
            cosine = turned_normals[k, 0] * normals[i, 0] + turned_normals[k, 1] * normals[i, 1]
            cosine += turned_normals[k, 2] * normals[i, 2]
            total += min(off, OFF) + NEARNESS * distance[cell] + TILT * (1.0 - cosine)
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
