"""Numba kernels of the attacks: Gaussian noise, faces left by clustering, the signed distance on a grid.

The grid's distance is exact near the faces, its winding number everywhere. Its coordinates are in cells: the
nodes of the grid are the whole numbers.
"""

import math

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray

_FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
"""Odd, with bits all over; splitmix64's and xxHash's."""


@njit(cache=True)
def with_noise(vertices: FloatArray, sigma: float, rng: np.random.Generator) -> FloatArray:
    """Return (n, 3) vertices plus independent Gaussian noise of standard deviation `sigma`.

    The same bits as ``vertices + sigma * rng.standard_normal(vertices.shape)``, drawn in less than half the
    time: compiled in, the generator's sign needs no branch.
    """
    noisy = np.empty_like(vertices)
    for i in range(vertices.shape[0]):
        for k in range(3):
            noisy[i, k] = vertices[i, k] + sigma * rng.standard_normal()
    return noisy


@njit(cache=True)
def count_faces(vertices: FloatArray, faces: IntArray, size: float) -> int:
    """Return how many different faces are left once the vertices in each cubic cell of edge `size` are one.

    A hash of its three cells stands for a face; two faces share one with one chance in 10⁷ for a million
    faces.
    """
    codes = cell_codes(vertices, size)
    bits = 4
    while (1 << bits) < 2 * faces.shape[0]:
        bits += 1
    table = np.zeros(1 << bits, np.uint64)  # open addressing; 0 is free
    last = (1 << bits) - 1
    count = 0
    for f in range(faces.shape[0]):
        a, b, c = codes[faces[f, 0]], codes[faces[f, 1]], codes[faces[f, 2]]
        if a == b or b == c or c == a:
            continue
        low, high = min(a, b, c), max(a, b, c)
        mixed = np.uint64(low) * _FACTORS[0] + np.uint64(a ^ b ^ c ^ low ^ high) * _FACTORS[1]
        mixed = (mixed + np.uint64(high) * _FACTORS[2]) | np.uint64(1)
        place = np.int64(mixed >> np.uint64(64 - bits))
        while table[place] != 0 and table[place] != mixed:
            place = (place + 1) & last
        if table[place] == 0:
            table[place] = mixed
            count += 1
    return count


@njit(cache=True)
def cell_codes(vertices: FloatArray, size: float) -> IntArray:
    """Return the number of the cubic cell, of edge `size`, that each vertex (n, 3) lies in."""
    low, extent = np.empty(3), np.empty(3, np.int64)
    for k in range(3):
        low[k] = vertices[:, k].min()
        extent[k] = np.int64(math.floor((vertices[:, k].max() - low[k]) / size)) + 1
    codes = np.empty(vertices.shape[0], np.int64)
    for i in range(vertices.shape[0]):
        x = np.int64(math.floor((vertices[i, 0] - low[0]) / size))
        y = np.int64(math.floor((vertices[i, 1] - low[1]) / size))
        z = np.int64(math.floor((vertices[i, 2] - low[2]) / size))
        codes[i] = (x * extent[1] + y) * extent[2] + z
    return codes


@njit(cache=True)
def squared_distance(vertices: FloatArray, faces: IntArray, shape: tuple[int, int, int]) -> FloatArray:
    """Squared distance from every node to the nearest face, exact up to 1 and nowhere more than that."""
    result = np.ones(shape)
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    p = np.empty(3)
    for f in range(faces.shape[0]):
        a, b, c = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
        for k in range(3):
            low[k] = max(0, math.ceil(min(a[k], b[k], c[k]) - 1))
            high[k] = min(shape[k] - 1, math.floor(max(a[k], b[k], c[k]) + 1))
        for x in range(low[0], high[0] + 1):
            for y in range(low[1], high[1] + 1):
                for z in range(low[2], high[2] + 1):
                    p[0], p[1], p[2] = x, y, z
                    result[x, y, z] = min(result[x, y, z], _to_triangle(p, a, b, c))
    return result


@njit(cache=True)
def exits(vertices: FloatArray, faces: IntArray, shape: tuple[int, int, int]) -> IntArray:
    """Signed crossings of the lines along x: +1 where one leaves the solid, -1 where it enters, summed.

    A crossing counts at the last node before it, so the sum over a node and all behind it is its winding
    number. A line through an edge meets exactly one of its two faces: both compute the same bits.
    """
    result = np.zeros(shape, np.int64)
    at = np.empty((2, 2))  # y and x where an edge crosses the plane of a row, going up and going down
    for f in range(faces.shape[0]):
        z = vertices[faces[f], 2]
        for row in range(max(0, math.ceil(z.min())), min(shape[2] - 1, math.floor(z.max())) + 1):
            found = 0
            for k in range(3):
                start, end = faces[f, k], faces[f, (k + 1) % 3]
                upwards = vertices[start, 2] <= row < vertices[end, 2]
                if upwards or vertices[end, 2] <= row < vertices[start, 2]:
                    a, b = (vertices[start], vertices[end]) if upwards else (vertices[end], vertices[start])
                    share = (row - a[2]) / (b[2] - a[2])
                    side = 0 if upwards else 1
                    at[side, 0] = a[1] + share * (b[1] - a[1])
                    at[side, 1] = a[0] + share * (b[0] - a[0])
                    found += 1
            if found != 2:
                continue
            sign = 1 if at[0, 0] > at[1, 0] else -1
            left, right = (1, 0) if sign > 0 else (0, 1)
            slope = at[right, 1] - at[left, 1]
            width = at[right, 0] - at[left, 0]
            for y in range(max(0, math.ceil(at[left, 0])), min(shape[1], math.ceil(at[right, 0]))):
                x = at[left, 1] + (y - at[left, 0]) / width * slope
                last = min(shape[0], math.ceil(x)) - 1
                if last >= 0:
                    result[last, y, row] += sign
    return result


@njit(cache=True)
def _to_triangle(p: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    """Squared distance from a point to a triangle, which may be a segment or a point."""
    nearest: float = min(_to_segment(p, a, b), _to_segment(p, b, c), _to_segment(p, c, a))
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    wx, wy, wz = p[0] - a[0], p[1] - a[1], p[2] - a[2]
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    square = nx * nx + ny * ny + nz * nz
    if square == 0:
        return nearest
    # barycentric coordinates of the foot of the perpendicular, times `square`
    of_c = nx * (uy * wz - uz * wy) + ny * (uz * wx - ux * wz) + nz * (ux * wy - uy * wx)
    of_b = nx * (wy * vz - wz * vy) + ny * (wz * vx - wx * vz) + nz * (wx * vy - wy * vx)
    if of_b < 0 or of_c < 0 or of_b + of_c > square:
        return nearest
    height = nx * wx + ny * wy + nz * wz
    inside: float = height * height / square
    return min(nearest, inside)


@njit(cache=True)
def _to_segment(p: FloatArray, a: FloatArray, b: FloatArray) -> float:
    """Squared distance from a point to a segment, which may be a point."""
    dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    wx, wy, wz = p[0] - a[0], p[1] - a[1], p[2] - a[2]
    square = dx * dx + dy * dy + dz * dz
    share = min(1.0, max(0.0, (wx * dx + wy * dy + wz * dz) / square)) if square > 0 else 0.0
    ex, ey, ez = wx - share * dx, wy - share * dy, wz - share * dz
    squared: float = ex * ex + ey * ey + ez * ez
    return squared
