"""Numba kernels of the perceptual metrics: sums over the part of a surface within a ball about each vertex.

That part is what hangs together with the vertex inside the ball, found by walking along the edges; other
sheets of the surface that pass nearby stay out. The numpy twins are in the test.
"""

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray


@njit(cache=True, error_model="numpy")
def curvature_tensors(
    vertices: FloatArray, first: IntArray, neighbours: IntArray, angles: FloatArray, radius: float
) -> FloatArray:
    """Sum β(e) ‖e ∩ B‖ ē ēᵀ over the edges in the ball B about each vertex, over πr²: (n, 3, 3).

    The neighbours of vertex i are neighbours[first[i]:first[i+1]], and `angles` are the signed angles β
    between the normals of the two faces at each of these edges.
    """
    n = len(vertices)
    tensors = np.zeros((n, 3, 3))
    seen, queue = np.full(n, -1), np.empty(n, np.int64)
    for i in range(n):
        seen[i], queue[0], size, done = i, i, 1, 0
        xx = xy = xz = yy = yz = zz = 0.0
        while done < size:
            p = queue[done]
            done += 1
            for e in range(first[p], first[p + 1]):
                q = neighbours[e]
                part = 1.0 if seen[q] == i else _part_inside(vertices, i, p, q, radius)
                if part == 1.0:
                    if seen[q] != i:
                        seen[q], queue[size] = i, q
                        size += 1
                    part = 0.5  # the edge is met again from its other end
                x, y, z = (
                    vertices[q, 0] - vertices[p, 0],
                    vertices[q, 1] - vertices[p, 1],
                    vertices[q, 2] - vertices[p, 2],
                )
                length = np.sqrt(x * x + y * y + z * z)
                weight = angles[e] * part / length if length > 0.0 else 0.0
                xx += weight * x * x
                xy += weight * x * y
                xz += weight * x * z
                yy += weight * y * y
                yz += weight * y * z
                zz += weight * z * z
        t, area = tensors[i], np.pi * radius * radius
        t[0, 0], t[1, 1], t[2, 2] = xx / area, yy / area, zz / area
        t[0, 1] = t[1, 0] = xy / area
        t[0, 2] = t[2, 0] = xz / area
        t[1, 2] = t[2, 1] = yz / area
    return tensors


@njit(cache=True, error_model="numpy")
def window_statistics(
    vertices: FloatArray, first: IntArray, neighbours: IntArray, values: FloatArray, radius: float
) -> FloatArray:
    """Gaussian means and (co)variances of two functions in a window about each vertex.

    The window is the ball of the given radius, the standard deviation of the Gaussian half of it. Its points
    are the vertices in it and the points where edges leave it; `values` (n, 2) are interpolated there.

    Returns
    -------
    (n, 5) ndarray
        Means of x and y, variances of x and y, covariance.
    """
    n = len(vertices)
    out = np.empty((n, 5))
    seen, queue = np.full(n, -1), np.empty(n, np.int64)
    falloff = -2.0 / (radius * radius)  # −1 / (2 (r/2)²)
    edge = np.exp(falloff * radius * radius)
    for i in range(n):
        seen[i], queue[0], size, done = i, i, 1, 0
        # sums of differences from the centre, which keep the variances exact
        x0, y0 = values[i, 0], values[i, 1]
        w = sx = sy = sxx = syy = sxy = 0.0
        while done < size:
            p = queue[done]
            done += 1
            x, y = values[p, 0] - x0, values[p, 1] - y0
            g = np.exp(falloff * _square_distance(vertices, i, p))
            w, sx, sy = w + g, sx + g * x, sy + g * y
            sxx, syy, sxy = sxx + g * x * x, syy + g * y * y, sxy + g * x * y
            for e in range(first[p], first[p + 1]):
                q = neighbours[e]
                if seen[q] == i:
                    continue
                part = _part_inside(vertices, i, p, q, radius)
                if part < 1.0:
                    x = (1.0 - part) * values[p, 0] + part * values[q, 0] - x0
                    y = (1.0 - part) * values[p, 1] + part * values[q, 1] - y0
                    w, sx, sy = w + edge, sx + edge * x, sy + edge * y
                    sxx, syy, sxy = sxx + edge * x * x, syy + edge * y * y, sxy + edge * x * y
                else:
                    seen[q], queue[size] = i, q
                    size += 1
        sx, sy = sx / w, sy / w
        out[i, 0], out[i, 1] = x0 + sx, y0 + sy
        out[i, 2], out[i, 3] = max(sxx / w - sx * sx, 0.0), max(syy / w - sy * sy, 0.0)
        out[i, 4] = sxy / w - sx * sy
    return out


@njit(cache=True)
def _square_distance(vertices: FloatArray, i: int, j: int) -> float:
    x, y, z = (
        vertices[j, 0] - vertices[i, 0],
        vertices[j, 1] - vertices[i, 1],
        vertices[j, 2] - vertices[i, 2],
    )
    square: float = x * x + y * y + z * z
    return square


@njit(cache=True, error_model="numpy")
def _part_inside(vertices: FloatArray, center: int, p: int, q: int, radius: float) -> float:
    """How much of the edge from p, inside the ball, to q lies inside: 1 if q does, else less.

    Where the edge leaves, ‖p − c + t (q − p)‖² = r²: t² a + 2 t b + c = 0.
    """
    if _square_distance(vertices, center, q) <= radius * radius:
        return 1.0
    a, b = 0.0, 0.0
    for k in range(3):
        step = vertices[q, k] - vertices[p, k]
        a += step * step
        b += step * (vertices[p, k] - vertices[center, k])
    c = min(_square_distance(vertices, center, p) - radius * radius, 0.0)
    part: float = min((-b + np.sqrt(b * b - a * c)) / a, 1.0 - 1e-15)
    return part
