"""Numba kernels of the scanner: frame changes, extents and the exact ray casting.

Sums run in vertex order on one thread, so a result never depends on the machine's cores. The plain numpy
twin of the ray casting is `wm3d.scanner.reference`.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from wm3d.arrays import FloatArray, IntArray

ANGLE_ERROR = 1e-4
"""Bound in radians on the error of `_angle`; columns this close to a segment's end are tested exactly."""


@njit(cache=True, error_model="numpy")
def to_frame(vertices: FloatArray, center: FloatArray, axes: FloatArray) -> FloatArray:
    """Return s_k·(v−m) for every vertex v and axis k: (n, 3)."""
    out = np.empty_like(vertices)
    for i in range(len(vertices)):
        x = vertices[i, 0] - center[0]
        y = vertices[i, 1] - center[1]
        z = vertices[i, 2] - center[2]
        for k in range(3):
            out[i, k] = axes[k, 0] * x + axes[k, 1] * y + axes[k, 2] * z
    return out


@njit(cache=True, error_model="numpy")
def spread_by_side(vertices: FloatArray, center: FloatArray, axes: FloatArray) -> FloatArray:
    """Return the mean of ‖v−m‖² over s_k·(v−m) > 0 and over < 0, for k = 1, 2 (eq. 3, squared): (2, 2)."""
    total = np.zeros((2, 2))
    count = np.zeros((2, 2))
    for i in range(len(vertices)):
        x = vertices[i, 0] - center[0]
        y = vertices[i, 1] - center[1]
        z = vertices[i, 2] - center[2]
        square = x * x + y * y + z * z
        for k in range(2):
            along = axes[k, 0] * x + axes[k, 1] * y + axes[k, 2] * z
            if along != 0.0:
                side = 0 if along > 0.0 else 1
                total[k, side] += square
                count[k, side] += 1.0
    return total / np.maximum(count, 1.0)


@njit(cache=True, error_model="numpy")
def extent(vertices: FloatArray, center: FloatArray, axes: FloatArray) -> tuple[float, float, float]:
    """Return hmin, hmax and r of the tight cylinder (eqs. 1 and 2)."""
    low, high, square = math.inf, -math.inf, 0.0
    for i in range(len(vertices)):
        x = vertices[i, 0] - center[0]
        y = vertices[i, 1] - center[1]
        z = vertices[i, 2] - center[2]
        along = axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z
        across = axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z
        depth = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
        low = min(low, along)
        high = max(high, along)
        square = max(square, across * across + depth * depth)
    return low, high, math.sqrt(square)


@njit(cache=True, error_model="numpy")
def cast(
    posed: FloatArray, faces: IntArray, planes: FloatArray, columns: int, radius: float, outward: int
) -> FloatArray:
    """Return the range l(u, v) of the first face that each ray meets from the front (eqs. 5–7).

    Each face is cut with the row planes it spans; each cut is a segment in the plane, which the ray of column
    v meets if the segment's ends lie on the two closed sides of the ray's line. Rays through an edge or a
    vertex hit every face that touches there, so a closed surface has no gaps.

    Parameters
    ----------
    posed : (n, 3) ndarray
        Vertices in the cylinder's frame, in mesh units.
    faces : (m, 3) ndarray
    planes : (N_u,) ndarray
        Equidistant, rising heights of the rows along s1, in mesh units.
    columns : int
        N_v.
    radius : float
        r, in mesh units.
    outward : int
        +1 where faces are wound counter-clockwise seen from outside, −1 for an inward-wound mesh.

    Returns
    -------
    (N_u, N_v) ndarray
        l in mesh units; NaN where the ray meets no face.
    """
    cosine, sine = directions(columns)
    level = _levels(posed, planes)
    first = np.full((len(planes), columns), -math.inf)  # signed distance of the hit from the axis, r − l
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        low, high = min(level[a], level[b], level[c]), max(level[a], level[b], level[c])
        start, stop = (low + 1) >> 1, high >> 1
        if start > stop:
            continue  # no plane between the lowest and the highest corner
        a0, a1, a2 = posed[a, 0], posed[a, 1], posed[a, 2]
        b0, b1, b2 = posed[b, 0], posed[b, 1], posed[b, 2]
        c0, c1, c2 = posed[c, 0], posed[c, 1], posed[c, 2]
        # (b−a)×(c−a) across the axis, with the sign that the left-handed s1, s2, s3 ask for
        n1 = outward * ((b0 - a0) * (c2 - a2) - (b2 - a2) * (c0 - a0))
        n2 = outward * ((b1 - a1) * (c0 - a0) - (b0 - a0) * (c1 - a1))
        for u in range(start, stop + 1):
            p1, p2, q1, q2 = _slice(a0, a1, a2, b0, b1, b2, c0, c1, c2, planes[u], low == 2 * u)
            _hit(first, u, p1, p2, q1, q2, n1, n2, cosine, sine)
    return np.where(first == -math.inf, math.nan, radius - first)


@njit(cache=True, error_model="numpy")
def _levels(posed: FloatArray, planes: FloatArray) -> NDArray[np.int32]:
    """Place every vertex among the planes, exactly: 2u on plane u, 2u − 1 between planes u − 1 and u."""
    rows = len(planes)
    scale = (rows - 1) / (planes[-1] - planes[0]) if rows > 1 else 0.0
    level = np.empty(len(posed), np.int32)
    for i in range(len(posed)):
        height = posed[i, 0]
        u = min(max(int((height - planes[0]) * scale), 0), rows)  # a guess, off by one at most
        while u < rows and planes[u] < height:
            u += 1
        while u > 0 and planes[u - 1] >= height:
            u -= 1
        level[i] = 2 * u if u < rows and planes[u] == height else 2 * u - 1
    return level


@njit(cache=True, error_model="numpy")
def directions(columns: int) -> tuple[FloatArray, FloatArray]:
    """Return the components of e_v(v) = cos(2πv/N_v) s3 + sin(2πv/N_v) s2 (eq. 4), exact at the quarters."""
    cosine, sine = np.empty(columns), np.empty(columns)
    for v in range(columns):
        cosine[v] = math.cos(2.0 * math.pi * v / columns)
        sine[v] = math.sin(2.0 * math.pi * v / columns)
        if 4 * v == columns or 4 * v == 3 * columns:
            cosine[v] = 0.0
        if 2 * v == columns:
            sine[v] = 0.0
    return cosine, sine


@njit(cache=True, inline="always", error_model="numpy")
def _slice(
    a0: float, a1: float, a2: float, b0: float, b1: float, b2: float, c0: float, c1: float, c2: float,
    plane: float, touches: bool,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Cut a triangle with a plane across the axis: the two ends of the segment, as (s2, s3) pairs.

    A vertex in the plane counts as above it, unless it is the lowest of the triangle (`touches`), so that a
    triangle that only touches the plane still gives its point or edge.
    """
    above_a, above_b, above_c = a0 >= plane, b0 >= plane, c0 >= plane
    if touches:
        above_a, above_b, above_c = a0 > plane, b0 > plane, c0 > plane
        if not (above_a or above_b or above_c):  # the whole triangle lies in the plane: edge-on to every ray
            return a1, a2, a1, a2
    if above_a == above_b:  # c is alone on its side
        p1, p2 = _edge(c0, c1, c2, a0, a1, a2, plane)
        q1, q2 = _edge(c0, c1, c2, b0, b1, b2, plane)
    elif above_a == above_c:
        p1, p2 = _edge(b0, b1, b2, a0, a1, a2, plane)
        q1, q2 = _edge(b0, b1, b2, c0, c1, c2, plane)
    else:
        p1, p2 = _edge(a0, a1, a2, b0, b1, b2, plane)
        q1, q2 = _edge(a0, a1, a2, c0, c1, c2, plane)
    return p1, p2, q1, q2


@njit(cache=True, inline="always", error_model="numpy")
def _edge(
    a0: float, a1: float, a2: float, b0: float, b1: float, b2: float, plane: float
) -> tuple[float, float]:
    """Point where an edge meets the plane; the same floats for both faces of the edge, exact at its ends."""
    if a0 > b0:
        a0, a1, a2, b0, b1, b2 = b0, b1, b2, a0, a1, a2
    t = (plane - a0) / (b0 - a0)
    s = 1.0 - t
    return s * a1 + t * b1, s * a2 + t * b2


@njit(cache=True, inline="always", error_model="numpy")
def _hit(
    first: FloatArray, u: int, p1: float, p2: float, q1: float, q2: float, n1: float, n2: float,
    cosine: FloatArray, sine: FloatArray,
) -> None:  # fmt: skip
    """Keep the hit nearest to the ray's start, for each column that meets the segment from the front."""
    columns = len(cosine)
    scale = columns / (2.0 * math.pi)
    margin = ANGLE_ERROR * scale
    start, stop = _angle(p1, p2) * scale, _angle(q1, q2) * scale
    if start > stop:
        start, stop = stop, start
    if stop - start > 0.5 * columns:  # the short way round
        start, stop = stop, start + columns
    # n·x is the same for every x of the segment. Where it is positive, only a ray that comes straight at the
    # segment sees its front (t > 0); where it is negative, only one that has crossed the axis (t < 0).
    side = n1 * p1 + n2 * p2
    if stop - start > 0.5 * columns - 2.0 * margin or side == 0.0:
        start, stop = 0.0, columns - 1.0  # the segment passes by the axis: ask every column
    elif side < 0.0:
        start += 0.5 * columns
        stop += 0.5 * columns
    for column in range(math.ceil(start - margin), math.floor(stop + margin) + 1):
        v = column
        if v < 0:
            v += columns
        while v >= columns:
            v -= columns
        e2, e1 = cosine[v], sine[v]
        if n1 * e1 + n2 * e2 <= 0.0:
            continue
        before = p2 * e1 - p1 * e2
        after = q2 * e1 - q1 * e2
        if (before > 0.0 and after > 0.0) or (before < 0.0 and after < 0.0):
            continue
        at_p, at_q = p1 * e1 + p2 * e2, q1 * e1 + q2 * e2
        if before == after:  # both on the ray's line
            t = max(at_p, at_q)
        else:
            share = before / (before - after)
            t = (1.0 - share) * at_p + share * at_q
        first[u, v] = max(first[u, v], t)


@njit(cache=True, inline="always", error_model="numpy")
def _angle(sine: float, cosine: float) -> float:
    """Angle of a point in radians in [0, 2π), to within `ANGLE_ERROR` (Abramowitz & Stegun 4.4.49: 1e-5)."""
    x, y = abs(cosine), abs(sine)
    small, large = min(x, y), max(x, y)
    if large == 0.0:
        return 0.0
    q = small / large
    s = q * q
    angle = q * (0.9998660 + s * (-0.3302995 + s * (0.1801410 + s * (-0.0851330 + s * 0.0208351))))
    if y > x:
        angle = 0.5 * math.pi - angle
    if cosine < 0.0:
        angle = math.pi - angle
    return angle if sine >= 0.0 else 2.0 * math.pi - angle
