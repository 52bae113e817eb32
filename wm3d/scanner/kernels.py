"""Numba kernels of the scanner: frame changes, extents and the exact ray casting.

Sums run in vertex order on one thread, so a result never depends on the machine's cores. The plain numpy
twin of the ray casting is `wm3d.scanner.reference`.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from wm3d.arrays import FloatArray, IntArray

ANGLE_ERROR = 2e-5
"""Bound in radians on the error of an angle in `_sectors`, less than half the step of the finest grid."""

ON_AXIS = 1 << 24
"""Sector of a vertex on the axis: farther than a turn from any other."""


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
def sides_and_extent(
    vertices: FloatArray, center: FloatArray, axes: FloatArray, slack: float
) -> tuple[FloatArray, float, float, float]:
    """Return what fixes the cylinder around orthonormal axes, in one pass.

    Returns
    -------
    spread : (2, 2) ndarray
        Mean of ‖v−m‖² over s_k·(v−m) > 0 and over < 0, for k = 1, 2 (eq. 3, squared). Vertices within `slack`
        of the plane between the sides count in neither: rounding would deal them out.
    hmin, hmax, r : float
        Of the tight cylinder (eqs. 1 and 2).
    """
    over1 = under1 = over2 = under2 = 0.0
    n_over1 = n_under1 = n_over2 = n_under2 = 0
    low, high, widest = math.inf, -math.inf, 0.0
    for i in range(len(vertices)):
        x = vertices[i, 0] - center[0]
        y = vertices[i, 1] - center[1]
        z = vertices[i, 2] - center[2]
        square = x * x + y * y + z * z
        along = axes[0, 0] * x + axes[0, 1] * y + axes[0, 2] * z
        across = axes[1, 0] * x + axes[1, 1] * y + axes[1, 2] * z
        depth = axes[2, 0] * x + axes[2, 1] * y + axes[2, 2] * z
        over1 += square if along > slack else 0.0  # a zero is added faster than a branch is guessed
        under1 += square if along < -slack else 0.0
        over2 += square if across > slack else 0.0
        under2 += square if across < -slack else 0.0
        n_over1 += along > slack
        n_under1 += along < -slack
        n_over2 += across > slack
        n_under2 += across < -slack
        low, high = min(low, along), max(high, along)
        widest = max(widest, across * across + depth * depth)
    total = np.array([[over1, under1], [over2, under2]])
    count = np.array([[n_over1, n_under1], [n_over2, n_under2]])
    return total / np.maximum(count, 1), low, high, math.sqrt(widest)


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
    lines = _lines(columns)
    level, sector = _levels(posed, planes), _sectors(posed, len(lines[0]))
    first = np.full((len(planes), columns + 1), -math.inf)  # signed distance of the hit from the axis, r − l
    for f in range(len(faces)):
        a, b, c = np.uintp(faces[f, 0]), np.uintp(faces[f, 1]), np.uintp(faces[f, 2])
        low, high = min(level[a], level[b], level[c]), max(level[a], level[b], level[c])
        bottom, top = (low + 1) >> 1, high >> 1
        if bottom > top or low == high:
            continue  # between two planes, or in one and so edge-on to its rays
        window = _window(sector[a], sector[b], sector[c], len(lines[0]))
        if window[0] > window[1]:
            continue  # between two lines
        normal = _normal(posed, a, b, c, outward)
        for u in range(bottom, top + 1):
            # a vertex in the plane counts as above it, unless it is the lowest of the face: so a face that
            # only touches the plane still gives its point or edge
            above = 2 * u + (low == 2 * u)
            i, j, k = _lone_first(a, b, c, level[a] >= above, level[b] >= above, level[c] >= above)
            _hit(first[u], window, _cut(posed, i, j, planes[u]), _cut(posed, i, k, planes[u]), normal, lines)
    seen = first[:, :columns]
    return np.where(seen == -math.inf, math.nan, radius - seen)


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
def _sectors(posed: FloatArray, lines: int) -> NDArray[np.int32]:
    """Place every vertex among the lines: 2k on line k or nearly, 2k − 1 between lines k − 1 and k.

    From −lines to lines, by its angle from s3 to s2 (Abramowitz & Stegun 4.4.49); `ON_AXIS` on the axis.
    """
    scale, margin = lines / (2.0 * math.pi), ANGLE_ERROR * lines / (2.0 * math.pi)
    flat = posed.ravel()  # LLVM vectorizes this loop over one dimension only
    sector = np.empty(len(posed), np.int32)
    for i in range(len(posed)):
        across, depth = flat[3 * i + 1], flat[3 * i + 2]
        x, y = abs(depth), abs(across)
        large = max(x, y)
        q = min(x, y) / large
        s = q * q
        turn = q * (0.9998660 + s * (-0.3302995 + s * (0.1801410 + s * (-0.0851330 + s * 0.0208351))))
        turn = 0.5 * math.pi - turn if y > x else turn
        turn = math.pi - turn if depth < 0.0 else turn
        angle = math.copysign(turn, across) * scale
        place = math.ceil(angle - margin) + math.floor(angle + margin)
        sector[i] = place if large > 0.0 else ON_AXIS
    return sector


@njit(cache=True, error_model="numpy")
def _window(a: int, b: int, c: int, lines: int) -> tuple[int, int]:
    """First and last line that may meet a face with corners in the sectors a, b, c, from `_sectors`."""
    left, right = min(a, b, c), max(a, b, c)
    half = lines - 2  # a turn is 2 lines sectors; a corner may lie up to one from where its number says
    if right - left >= half:  # is it that the face passes behind, where the angle jumps?
        a = a if a >= 0 else a + 2 * lines
        b = b if b >= 0 else b + 2 * lines
        c = c if c >= 0 else c + 2 * lines
        left, right = min(a, b, c), max(a, b, c)
    if right - left >= half or left == ON_AXIS:  # the face meets the axis, or nearly
        return 0, lines // 2 - 1  # each line once
    return (left + 1) >> 1, right >> 1


@njit(cache=True, error_model="numpy")
def _normal(posed: FloatArray, a: np.uintp, b: np.uintp, c: np.uintp, outward: int) -> tuple[float, float]:
    """(b−a)×(c−a) across the axis, with the sign that the left-handed s1, s2, s3 ask for."""
    d0, d1, d2 = posed[b, 0] - posed[a, 0], posed[b, 1] - posed[a, 1], posed[b, 2] - posed[a, 2]
    e0, e1, e2 = posed[c, 0] - posed[a, 0], posed[c, 1] - posed[a, 1], posed[c, 2] - posed[a, 2]
    return outward * (d0 * e2 - d2 * e0), outward * (d1 * e0 - d0 * e1)


@njit(cache=True, error_model="numpy")
def directions(columns: int) -> tuple[FloatArray, FloatArray]:
    """Return the components of e_v(v) = cos(2πv/N_v) s3 + sin(2πv/N_v) s2 (eq. 4).

    Exact at the quarters; opposite columns have opposite directions to the last bit.
    """
    cosine, sine = np.empty(columns), np.empty(columns)
    for v in range(columns):
        if columns % 2 == 0 and 2 * v >= columns:
            cosine[v], sine[v] = -cosine[v - columns // 2], -sine[v - columns // 2]
        else:
            cosine[v] = 0.0 if 4 * v == columns else math.cos(2.0 * math.pi * v / columns)
            sine[v] = math.sin(2.0 * math.pi * v / columns)
    return cosine, sine


@njit(cache=True, error_model="numpy")
def _lines(columns: int) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Return the lines through the axis on which the rays run, and the columns of the rays at either end.

    Returns
    -------
    cosine, sine : (lines,) ndarray
        Components of the lines' directions along s3 and s2, one full turn of them: N_v lines, or 2 N_v where
        N_v is odd, as no ray is then the opposite of another.
    ahead, behind : (lines,) ndarray of int
        Columns of the rays that start in the direction of a line and opposite to it; N_v for none.
    """
    step = 1 + columns % 2  # lines a column
    cosine, sine = directions(step * columns)
    ahead = np.full(step * columns, columns)
    ahead[::step] = np.arange(columns)
    return cosine, sine, ahead, np.roll(ahead, step * columns // 2)


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
    normal: tuple[float, float], lines: tuple[FloatArray, FloatArray, IntArray, IntArray],
) -> None:  # fmt: skip
    """Keep the hit nearest to its ray's start, for each line that meets the segment pq.

    Of the two rays on a line, the face shows its front to one.
    """
    cosine, sine, ahead, behind = lines
    for unwrapped in range(window[0], window[1] + 1):
        line = unwrapped
        if line < 0:
            line += len(cosine)
        elif line >= len(cosine):
            line -= len(cosine)
        e2, e1 = cosine[line], sine[line]
        before, after = p[1] * e1 - p[0] * e2, q[1] * e1 - q[0] * e2
        crosses = ((before <= 0.0) & (after >= 0.0)) | ((before >= 0.0) & (after <= 0.0))
        facing = normal[0] * e1 + normal[1] * e2
        if crosses & (facing != 0.0):  # & and |: a guess that fails costs more
            v, sign = (ahead[line], 1.0) if facing > 0.0 else (behind[line], -1.0)
            at_p, at_q = sign * (p[0] * e1 + p[1] * e2), sign * (q[0] * e1 + q[1] * e2)
            if before == after:  # both on the line
                t = max(at_p, at_q)
            else:
                share = before / (before - after)
                t = (1.0 - share) * at_p + share * at_q
            first[v] = max(first[v], t)


# compiled into kernels of other files, which numba does not compile anew when this one changes
_SINE = np.array([(-1) ** k * (math.pi ** (2 * k + 1)) / math.factorial(2 * k + 1) / 2 for k in range(11)])
"""Taylor coefficients of ½ sin πy, whose next term is below 1e-16 for |y| ≤ ½."""


@njit(cache=True, error_model="numpy")
def cosine_weight(x: float) -> float:
    """Return f(x) = (1 + cos πx)/2 for 0 ≤ x ≤ 1, by a series: equal to a few last bits, and faster."""
    y = 0.5 - x
    z = y * y
    total = _SINE[10]
    for k in range(9, -1, -1):
        total = total * z + _SINE[k]
    weight: float = 0.5 + y * total
    return weight
