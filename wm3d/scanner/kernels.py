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
def spread_by_side(vertices: FloatArray, center: FloatArray, axes: FloatArray, slack: float) -> FloatArray:
    """Return the mean of ‖v−m‖² over s_k·(v−m) > 0 and over < 0, for k = 1, 2 (eq. 3, squared): (2, 2).

    Vertices within `slack` of the plane between the sides count in neither: rounding would deal them out.
    """
    total = np.zeros((2, 2))
    count = np.zeros((2, 2))
    for i in range(len(vertices)):
        x = vertices[i, 0] - center[0]
        y = vertices[i, 1] - center[1]
        z = vertices[i, 2] - center[2]
        square = x * x + y * y + z * z
        for k in range(2):
            along = axes[k, 0] * x + axes[k, 1] * y + axes[k, 2] * z
            if abs(along) > slack:
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
    level, angle = _levels(posed, planes), _angles(posed, columns)
    first = np.full((len(planes), columns), -math.inf)  # signed distance of the hit from the axis, r − l
    for f in range(len(faces)):
        a, b, c = np.uintp(faces[f, 0]), np.uintp(faces[f, 1]), np.uintp(faces[f, 2])
        low, high = min(level[a], level[b], level[c]), max(level[a], level[b], level[c])
        bottom, top = (low + 1) >> 1, high >> 1
        if bottom > top or low == high:
            continue  # between two planes, or in one and so edge-on to its rays
        near, beyond = _windows(angle[a], angle[b], angle[c], columns)
        if near[0] > near[1] and beyond[0] > beyond[1]:
            continue  # between two columns
        normal = _normal(posed, a, b, c, outward)
        for u in range(bottom, top + 1):
            # a vertex in the plane counts as above it, unless it is the lowest of the face: so a face that
            # only touches the plane still gives its point or edge
            above = 2 * u + (low == 2 * u)
            i, j, k = _lone_first(a, b, c, level[a] >= above, level[b] >= above, level[c] >= above)
            p, q = _cut(posed, i, j, planes[u]), _cut(posed, i, k, planes[u])
            _hit(first[u], near, p, q, normal, cosine, sine)
            _hit(first[u], beyond, p, q, normal, cosine, sine)
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
def _angles(posed: FloatArray, columns: int) -> FloatArray:
    """Place every vertex among the columns: its angle from s3 to s2, in columns, from −N_v/2 to N_v/2.

    To within `ANGLE_ERROR`, by Abramowitz & Stegun 4.4.49; infinite on the axis.
    """
    scale = columns / (2.0 * math.pi)
    flat = posed.ravel()  # LLVM vectorizes this loop over one dimension only
    angle = np.empty(len(posed))
    for i in range(len(posed)):
        across, depth = flat[3 * i + 1], flat[3 * i + 2]
        x, y = abs(depth), abs(across)
        large = max(x, y)
        q = min(x, y) / large
        s = q * q
        turn = q * (0.9998660 + s * (-0.3302995 + s * (0.1801410 + s * (-0.0851330 + s * 0.0208351))))
        turn = 0.5 * math.pi - turn if y > x else turn
        turn = math.pi - turn if depth < 0.0 else turn
        turn = math.inf if large == 0.0 else turn
        angle[i] = math.copysign(turn, across) * scale
    return angle


@njit(cache=True, error_model="numpy")
def _windows(a: float, b: float, c: float, columns: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """First and last column whose rays may meet a face before the axis, and those beyond it.

    Parameters
    ----------
    a, b, c : float
        Angles of its corners, from `_angles`.
    """
    half, margin = 0.5 * columns, ANGLE_ERROR * columns / (2.0 * math.pi)
    left, right = min(a, b, c) - margin, max(a, b, c) + margin
    if not right - left < half:  # is it that the face passes behind, where the angle jumps?
        a = a if a >= 0.0 else a + columns
        b = b if b >= 0.0 else b + columns
        c = c if c >= 0.0 else c + columns
        left, right = min(a, b, c) - margin, max(a, b, c) + margin
    if not right - left < half:  # the face meets the axis, or nearly
        return (0, columns - 1), (0, -1)
    return (math.ceil(left), math.floor(right)), (math.ceil(left + half), math.floor(right + half))


@njit(cache=True, error_model="numpy")
def _normal(posed: FloatArray, a: np.uintp, b: np.uintp, c: np.uintp, outward: int) -> tuple[float, float]:
    """(b−a)×(c−a) across the axis, with the sign that the left-handed s1, s2, s3 ask for."""
    d0, d1, d2 = posed[b, 0] - posed[a, 0], posed[b, 1] - posed[a, 1], posed[b, 2] - posed[a, 2]
    e0, e1, e2 = posed[c, 0] - posed[a, 0], posed[c, 1] - posed[a, 1], posed[c, 2] - posed[a, 2]
    return outward * (d0 * e2 - d2 * e0), outward * (d1 * e0 - d0 * e1)


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


@njit(cache=True, error_model="numpy")
def _lone_first(
    a: np.uintp, b: np.uintp, c: np.uintp, a_above: bool, b_above: bool, c_above: bool
) -> tuple[np.uintp, np.uintp, np.uintp]:
    """Put the corner that is alone on its side of the plane first."""
    if a_above == b_above:
        return c, a, b
    if a_above == c_above:
        return b, a, c
    return a, b, c


@njit(cache=True, error_model="numpy")
def _cut(posed: FloatArray, i: np.uintp, j: np.uintp, plane: float) -> tuple[float, float]:
    """Point (s2, s3) where an edge meets the plane: the same floats from either end, exact at the ends."""
    length = posed[j, 0] - posed[i, 0]
    at_i, at_j = (posed[j, 0] - plane) / length, (plane - posed[i, 0]) / length
    return at_i * posed[i, 1] + at_j * posed[j, 1], at_i * posed[i, 2] + at_j * posed[j, 2]


@njit(cache=True, error_model="numpy")
def _hit(
    first: FloatArray, window: tuple[int, int], p: tuple[float, float], q: tuple[float, float],
    normal: tuple[float, float], cosine: FloatArray, sine: FloatArray,
) -> None:  # fmt: skip
    """Keep the hit nearest to the ray's start, for each column that meets the segment pq from the front."""
    columns = len(cosine)
    for column in range(window[0], window[1] + 1):
        v = column
        if v < 0:
            v += columns
        elif v >= columns:
            v -= columns
        e2, e1 = cosine[v], sine[v]
        before, after = p[1] * e1 - p[0] * e2, q[1] * e1 - q[0] * e2
        crosses = ((before <= 0.0) & (after >= 0.0)) | ((before >= 0.0) & (after <= 0.0))
        if crosses & (normal[0] * e1 + normal[1] * e2 > 0.0):  # & and |: a guess that fails costs more
            at_p, at_q = p[0] * e1 + p[1] * e2, q[0] * e1 + q[1] * e2
            if before == after:  # both on the ray's line
                t = max(at_p, at_q)
            else:
                share = before / (before - after)
                t = (1.0 - share) * at_p + share * at_q
            first[v] = max(first[v], t)
