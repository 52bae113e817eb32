"""Numba kernels of nearest points: a balanced tree of boxes over triangles, and the search in it.

One thread each. Points and triangles are in units of the size of the mesh. Numpy twins stand in the tests.
"""

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray

Vector = tuple[float, float, float]

FLAT = 1e-14
"""Least squared sine of the angle at a corner for which a triangle's plane is told from rounding."""

NEEDLE = 1e-7
"""Height over length below which a triangle is bounded along its length alone; rounding hides its plane."""


@njit(cache=True, nogil=True)
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


@njit(cache=True, error_model="numpy", nogil=True)
def nearest(
    points: FloatArray, corners: FloatArray, frames: FloatArray, boxes: FloatArray
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Find the nearest point of a surface to each of (k, 3) points.

    `corners` (m, 3, 3) are the triangles, `frames` theirs, and `boxes` their tree, as
    `wm3d.metrics.surface.nearest.boxes` has it. Returns squared distances (k,), triangles (k,), and
    barycentric weights (k, 3) of the nearest points. A search starts from the triangle found for the point
    before, so neighbours should follow each other. A triangle is measured only if its frame does not tell
    already that it is no nearer than the nearest so far.
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
                    if t == last or rectangle_distance(p, frames, t) >= best:
                        continue
                    d, x, y, z = nearest_on_triangle(p, corners, t)
                    if d < best:
                        best, last, u, v, w = d, t, x, y, z
                continue
            near, far = 2 * node + 1, 2 * node + 2
            to_near, to_far = box_distance(p, boxes, near), box_distance(p, boxes, far)
            if to_far < to_near:
                near, far, to_near, to_far = far, near, to_far, to_near
            if to_far < best:
                stack[height], bound[height] = far, to_far
                height += 1
            if to_near < best:
                stack[height], bound[height] = near, to_near
                height += 1
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


@njit(cache=True, error_model="numpy", nogil=True)
def frames(corners: FloatArray) -> FloatArray:
    """Return the rectangles (m, 14) on the longest edges of triangles (m, 3, 3) that hold them.

    A corner, the unit vectors along the edge, across it and normal to it, then length and height. The vectors
    across and along the normal are 0 and the height infinite where `NEEDLE` says so.
    """
    found = np.zeros((len(corners), 14))
    for t in range(len(corners)):
        first, longest = 0, -1.0
        for k in range(3):
            x, y, z = _edge(corners, t, k, (k + 1) % 3)
            if x * x + y * y + z * z > longest:
                first, longest = k, x * x + y * y + z * z
        length = np.sqrt(longest)
        found[t, :3], found[t, 12], found[t, 13] = corners[t, first], length, np.inf
        if length == 0.0:
            continue
        x, y, z = _edge(corners, t, first, (first + 1) % 3)
        ux, uy, uz = x / length, y / length, z / length
        x, y, z = _edge(corners, t, first, (first + 2) % 3)
        along = x * ux + y * uy + z * uz
        x, y, z = x - along * ux, y - along * uy, z - along * uz
        height = np.sqrt(x * x + y * y + z * z)
        found[t, 3], found[t, 4], found[t, 5] = ux, uy, uz
        if height <= NEEDLE * length:
            continue
        x, y, z = x / height, y / height, z / height
        found[t, 6], found[t, 7], found[t, 8], found[t, 13] = x, y, z, height
        found[t, 9], found[t, 10], found[t, 11] = uy * z - uz * y, uz * x - ux * z, ux * y - uy * x
    return found


@njit(cache=True)
def _edge(corners: FloatArray, t: int, start: int, end: int) -> Vector:
    a, b = corners[t, start], corners[t, end]
    return b[0] - a[0], b[1] - a[1], b[2] - a[2]


@njit(cache=True, error_model="numpy")
def rectangle_distance(p: Vector, frames: FloatArray, index: int) -> float:
    """Squared distance of a point from one of the rectangles: no point of its triangle is nearer."""
    i = np.uintp(index)
    x, y, z = p[0] - frames[i, 0], p[1] - frames[i, 1], p[2] - frames[i, 2]
    u = x * frames[i, 3] + y * frames[i, 4] + z * frames[i, 5]
    v = x * frames[i, 6] + y * frames[i, 7] + z * frames[i, 8]
    w = x * frames[i, 9] + y * frames[i, 10] + z * frames[i, 11]
    u = max(-u, 0.0, u - frames[i, 12])
    v = max(-v, 0.0, v - frames[i, 13])
    square: float = u * u + v * v + w * w
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
