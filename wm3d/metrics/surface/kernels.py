"""Numba kernels of the surface metrics: cells of triangles, and nearest points in a tree of boxes.

One thread. Points and triangles are in units of the size of the mesh. Numpy twins stand in the tests.
"""

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray

Vector = tuple[float, float, float]

STACK = 128
"""Triangles that wait while one is bisected: 2^-64 of an edge is below the rounding of its ends."""

FLAT = 1e-14
"""Least squared sine of the angle at a corner for which a triangle's plane is told from rounding."""


@njit(cache=True, error_model="numpy")
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


@njit(cache=True)
def tree_order(points: FloatArray, depth: int) -> IntArray:
    """Order points, given as (3, m), by `depth` splits of each part at the median of its longest axis.

    Part k of level l goes from ⌊m k / 2^l⌋ to ⌊m (k+1) / 2^l⌋ of the order (m,).
    """
    m = points.shape[1]
    order = np.arange(m)
    for level in range(depth):
        for k in range(1 << level):
            low, high = m * k >> level, m * (k + 1) >> level
            axis = _longest_axis(points, order, low, high)
            _split(points[axis], order, low, high, m * (2 * k + 1) >> (level + 1))
    return order


@njit(cache=True)
def _longest_axis(points: FloatArray, order: IntArray, low: int, high: int) -> int:
    axis, longest = 0, -1.0
    for k in range(3):
        least = greatest = points[k, order[low]]
        for t in range(low, high):
            least, greatest = min(least, points[k, order[t]]), max(greatest, points[k, order[t]])
        if greatest - least > longest:
            axis, longest = k, greatest - least
    return axis


@njit(cache=True)
def _split(values: FloatArray, order: IntArray, low: int, high: int, middle: int) -> None:
    """Rearrange order[low:high] so that no value before `middle` is above one behind it (Hoare)."""
    while high - low > 1:
        pivot = values[order[(low + high) >> 1]]
        i, j = low, high - 1
        while i <= j:
            while values[order[i]] < pivot:
                i += 1
            while values[order[j]] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j + 1
        elif middle >= i:
            low = i
        else:
            return


@njit(cache=True, error_model="numpy")
def nearest(
    points: FloatArray, corners: FloatArray, boxes: FloatArray
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Find the nearest point of a surface to each of (k, 3) points.

    `corners` (m, 3, 3) are the triangles and `boxes` their tree, as `wm3d.metrics.surface.nearest.boxes` has
    it. Returns squared distances (k,), triangles (k,), and barycentric weights (k, 3) of the nearest points.
    A search starts from the triangle found for the point before, so neighbours should follow each other.
    """
    m = len(corners)
    leaves = len(boxes) >> 1
    depth = 0
    while (1 << depth) - 1 < leaves:
        depth += 1
    square, triangle = np.empty(len(points)), np.empty(len(points), np.int64)
    weights = np.empty((len(points), 3))
    stack, bound = np.empty(depth + 2, np.int64), np.empty(depth + 2)
    last = 0
    for i in range(len(points)):
        p = (points[i, 0], points[i, 1], points[i, 2])
        best, u, v, w = nearest_on_triangle(p, corners, last)
        stack[0], bound[0] = 0, box_distance(p, boxes, 0)
        height = 1
        while height > 0:
            height -= 1
            if bound[height] >= best:
                continue
            node = stack[height]
            if node >= leaves:
                k = node - leaves
                for t in range(m * k >> depth, m * (k + 1) >> depth):
                    d, x, y, z = nearest_on_triangle(p, corners, t)
                    if d < best:
                        best, last, u, v, w = d, t, x, y, z
                continue
            near, far = 2 * node + 1, 2 * node + 2
            to_near, to_far = box_distance(p, boxes, near), box_distance(p, boxes, far)
            if to_far < to_near:
                near, far, to_near, to_far = far, near, to_far, to_near
            stack[height], bound[height] = far, to_far
            stack[height + 1], bound[height + 1] = near, to_near
            height += 2
        square[i], triangle[i] = best, last
        weights[i, 0], weights[i, 1], weights[i, 2] = u, v, w
    return square, triangle, weights


@njit(cache=True)
def box_distance(p: Vector, boxes: FloatArray, index: int) -> float:
    """Squared distance of a point from one of the boxes (·, 6)."""
    i = np.uintp(index)  # unsigned: no test for negative indices
    x = max(boxes[i, 0] - p[0], 0.0, p[0] - boxes[i, 3])
    y = max(boxes[i, 1] - p[1], 0.0, p[1] - boxes[i, 4])
    z = max(boxes[i, 2] - p[2], 0.0, p[2] - boxes[i, 5])
    square: float = x * x + y * y + z * z
    return square


@njit(cache=True, error_model="numpy")
def nearest_on_triangle(p: Vector, corners: FloatArray, index: int) -> tuple[float, float, float, float]:
    """Squared distance of a point from one of the triangles (m, 3, 3), and the weights of the nearest point.

    The foot of the perpendicular if it lies inside, else the nearest of the edges on whose outer side it
    lies; of all three edges where the triangle has no area to tell the sides.
    """
    t = np.uintp(index)
    ax, ay, az = corners[t, 0, 0] - p[0], corners[t, 0, 1] - p[1], corners[t, 0, 2] - p[2]
    bx, by, bz = corners[t, 1, 0] - p[0], corners[t, 1, 1] - p[1], corners[t, 1, 2] - p[2]
    cx, cy, cz = corners[t, 2, 0] - p[0], corners[t, 2, 1] - p[1], corners[t, 2, 2] - p[2]
    ux, uy, uz = bx - ax, by - ay, bz - az
    wx, wy, wz = cx - ax, cy - ay, cz - az
    uu, uw, ww = ux * ux + uy * uy + uz * uz, ux * wx + uy * wy + uz * wz, wx * wx + wy * wy + wz * wz
    au, aw = ax * ux + ay * uy + az * uz, ax * wx + ay * wy + az * wz
    area = uu * ww - uw * uw
    v, w = uw * aw - ww * au, uw * au - uu * aw
    flat = area <= FLAT * uu * ww
    if not flat and v >= 0.0 and w >= 0.0 and v + w <= area:
        v, w = v / area, w / area
        x, y, z = ax + v * ux + w * wx, ay + v * uy + w * wy, az + v * uz + w * wz
        return x * x + y * y + z * z, 1.0 - v - w, v, w
    best, weights = np.inf, (1.0, 0.0, 0.0)
    if flat or w < 0.0:
        best, s = _nearest_on_edge((ax, ay, az), (bx, by, bz))
        weights = (1.0 - s, s, 0.0)
    if flat or v < 0.0:
        d, s = _nearest_on_edge((ax, ay, az), (cx, cy, cz))
        if d < best:
            best, weights = d, (1.0 - s, 0.0, s)
    if flat or v + w > area:
        d, s = _nearest_on_edge((bx, by, bz), (cx, cy, cz))
        if d < best:
            best, weights = d, (0.0, 1.0 - s, s)
    return best, weights[0], weights[1], weights[2]


@njit(cache=True, error_model="numpy")
def _nearest_on_edge(a: Vector, b: Vector) -> tuple[float, float]:
    """Squared distance of the origin from the edge a b, and where along it the nearest point lies."""
    x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    length = x * x + y * y + z * z
    t = -(a[0] * x + a[1] * y + a[2] * z)
    t = 0.0 if t <= 0.0 else 1.0 if t >= length else t / length
    x, y, z = a[0] + t * x, a[1] + t * y, a[2] + t * z
    return x * x + y * y + z * z, t


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def angles(u: FloatArray, v: FloatArray, i: IntArray, j: IntArray) -> FloatArray:
    """Angles (k,) in radians between the vectors u[i] and v[j]; exactly 0 between equal vectors."""
    out = np.empty(len(i))
    for n in range(len(i)):
        ux, uy, uz = u[i[n], 0], u[i[n], 1], u[i[n], 2]
        vx, vy, vz = v[j[n], 0], v[j[n], 1], v[j[n], 2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        out[n] = np.arctan2(np.sqrt(x * x + y * y + z * z), ux * vx + uy * vy + uz * vz)
    return out
