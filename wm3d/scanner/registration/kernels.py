"""Numba kernels of registration: the points of a surface near a place, warps, and what they lay where."""

import math

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray
from wm3d.metrics.surface.tree.kernels import box_distance

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
