"""Numba kernels of the volume image and of its slope: faces in parts, each dealt to the four cells around it.

Each sums in face order on one thread, so a result never depends on the machine's cores. The plain numpy twin
of `deposit` is `wm3d.scanner.volume.volume_image_reference`; its slope is the oracle of `differentiate`.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from wm3d.arrays import FloatArray, IntArray
from wm3d.scanner.kernels import cosine_weight

MOST_PARTS = 512
"""Most parts along a side of a face."""

SLIVER = 0.2
"""Distance from the axis, over that at which cells are square, below which faces are cut no finer: cells are
slivers there, with little in them."""


@njit(cache=True, error_model="numpy", nogil=True)
def deposit(
    posed: FloatArray,
    faces: IntArray,
    rows: int,
    columns: int,
    hmin: float,
    height: float,
    samples: float,
    most: int,
) -> tuple[FloatArray, FloatArray, int]:
    """Return ∮ φ (ρ/2) e_ρ·n dA and ∮ φ dA of each cell, (N_u, N_v), n by the winding and the right hand.

    And how many points that takes: of those beyond `most` none is dealt, they are only counted.
    """
    flux, area, points = np.zeros((rows, columns)), np.zeros((rows, columns)), 0
    angles = _angles(posed)
    per_height, per_angle = rows / height, columns / (2.0 * math.pi)
    for f in range(len(faces)):
        a, b, c = np.uintp(faces[f, 0]), np.uintp(faces[f, 1]), np.uintp(faces[f, 2])
        edges = _edges(posed, a, b, c)
        n0, n1, n2 = edges[6:]
        doubled = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        if doubled == 0.0:
            continue
        parts = _parts(posed, a, b, c, per_height, per_angle, samples)
        points += 3 * parts * parts
        if points > most:
            continue
        share = 1.0 / (3 * parts * parts)
        for i in range(parts):
            for k in range(2 * (parts - i) - 1):
                for q in range(3):
                    s, t = _point(parts, i, k, q)
                    x, y, u, v = _seen(posed, angles, a, edges, s, t, hmin, per_height, per_angle)
                    through = 0.25 * share * (x * n1 + y * n2)
                    _deal(flux, area, u, v, through, 0.5 * share * doubled)
    return flux, area, points


@njit(cache=True, error_model="numpy", nogil=True)
def differentiate(
    posed: FloatArray,
    faces: IntArray,
    directions: FloatArray,
    rows: int,
    columns: int,
    hmin: float,
    height: float,
    samples: float,
) -> tuple[NDArray[np.int32], NDArray[np.int32], FloatArray]:
    """Return ∮ φ β (d·n) dA for the cells φ and vertices β (a tent) that meet: cells, vertices, values.

    By the points and weights of `deposit`; a cell and a vertex come up once for each face that they share.
    """
    angles = _angles(posed)
    per_height, per_angle = rows / height, columns / (2.0 * math.pi)
    touched = _Touched(
        np.full(rows * columns, -1),
        np.zeros(rows * columns, np.int64),
        np.zeros(rows * columns, np.int32),
        np.zeros((rows * columns, 3)),
    )
    room = 20 * len(faces)  # enough where faces are smaller than cells
    cells, vertices, values = np.zeros(room, np.int32), np.zeros(room, np.int32), np.zeros(room)
    filled = 0
    for f in range(len(faces)):
        a, b, c = np.uintp(faces[f, 0]), np.uintp(faces[f, 1]), np.uintp(faces[f, 2])
        edges = _edges(posed, a, b, c)
        n0, n1, n2 = edges[6:]
        if n0 == 0.0 and n1 == 0.0 and n2 == 0.0:
            continue
        parts = _parts(posed, a, b, c, per_height, per_angle, samples)
        half = 0.5 / (3 * parts * parts)
        of_a = half * (directions[a, 0] * n0 + directions[a, 1] * n1 + directions[a, 2] * n2)
        of_b = half * (directions[b, 0] * n0 + directions[b, 1] * n1 + directions[b, 2] * n2)
        of_c = half * (directions[c, 0] * n0 + directions[c, 1] * n1 + directions[c, 2] * n2)
        count = 0
        for i in range(parts):
            for k in range(2 * (parts - i) - 1):
                for q in range(3):
                    s, t = _point(parts, i, k, q)
                    _, _, u, v = _seen(posed, angles, a, edges, s, t, hmin, per_height, per_angle)
                    shares = ((1.0 - s - t) * of_a, s * of_b, t * of_c)
                    count = _touch(touched, count, f, rows, columns, u, v, shares)
        while filled + 3 * count > len(values):
            cells = np.concatenate((cells, np.zeros_like(cells)))
            vertices = np.concatenate((vertices, np.zeros_like(vertices)))
            values = np.concatenate((values, np.zeros_like(values)))
        for here in range(count):
            for k in range(3):
                cells[filled], vertices[filled] = touched.cell[here], faces[f, k]
                values[filled] = touched.sums[here, k]
                filled += 1
    return cells[:filled], vertices[:filled], values[:filled]


@njit(cache=True, error_model="numpy", nogil=True)
def gathered(
    cells: NDArray[np.int32],
    vertices: NDArray[np.int32],
    values: FloatArray,
    first: int,
    stop: int,
    width: int,
) -> tuple[FloatArray, NDArray[np.int32], IntArray]:
    """Sort what `differentiate` returns by vertex, and add up what one does to a cell.

    Of the vertices from `first` to `stop`: CSR, (stop − first, width).
    """
    n = stop - first
    ends = np.zeros(n + 1, np.int64)
    for vertex in vertices:
        if first <= vertex < stop:
            ends[vertex - first + 1] += 1
    ends = np.cumsum(ends)
    cursor, order = ends[:-1].copy(), np.empty(ends[-1], np.int64)
    for i in range(len(vertices)):
        if first <= vertices[i] < stop:
            order[cursor[vertices[i] - first]] = i
            cursor[vertices[i] - first] += 1

    data, indices, starts = np.empty(ends[-1]), np.empty(ends[-1], np.int32), np.zeros(n + 1, np.int64)
    seen, place = np.full(width, -1), np.zeros(width, np.int64)
    filled = 0
    for vertex in range(n):
        for i in order[ends[vertex] : ends[vertex + 1]]:
            cell = cells[i]
            if seen[cell] != vertex:
                seen[cell], place[cell] = vertex, filled
                indices[filled], data[filled] = cell, 0.0
                filled += 1
            data[place[cell]] += values[i]
        starts[vertex + 1] = filled
    return data[:filled].copy(), indices[:filled].copy(), starts


class _Touched(NamedTuple):
    """The cells that a face touches, in their order of appearance, and what its corners do to each.

    Of every cell of the grid: the last face that touched it, and where it stands in that face's order.
    """

    face: NDArray[np.int64]
    place: NDArray[np.int64]
    cell: NDArray[np.int32]
    sums: FloatArray


@njit(cache=True, error_model="numpy")
def _touch(
    touched: _Touched,
    count: int,
    f: int,
    rows: int,
    columns: int,
    u: float,
    v: float,
    shares: tuple[float, float, float],
) -> int:
    """Deal the shares of a point's corners out as `_deal` does; return how many cells the face touches."""
    u0, v0 = math.floor(u), math.floor(v)
    fu, fv = cosine_weight(u - u0), cosine_weight(v - v0)
    left, right = _wrapped(v0, columns), _wrapped(v0 + 1, columns)
    for row, of_row in ((u0, fu), (u0 + 1, 1.0 - fu)):
        if not 0 <= row < rows:
            continue
        for column, of_column in ((left, fv), (right, 1.0 - fv)):
            cell = np.uintp(row) * np.uintp(columns) + column
            if touched.face[cell] != f:
                touched.face[cell], touched.place[cell], touched.cell[count] = f, count, cell
                touched.sums[count, :] = 0.0
                count += 1
            here, weight = touched.place[cell], of_row * of_column
            for k in range(3):
                touched.sums[here, k] += weight * shares[k]
    return count


@njit(cache=True, error_model="numpy")
def _edges(posed: FloatArray, a: np.uintp, b: np.uintp, c: np.uintp) -> tuple[float, ...]:
    """Return b − a, c − a and their cross product, in the right hand: nine numbers."""
    d0, d1, d2 = posed[b, 0] - posed[a, 0], posed[b, 1] - posed[a, 1], posed[b, 2] - posed[a, 2]
    e0, e1, e2 = posed[c, 0] - posed[a, 0], posed[c, 1] - posed[a, 1], posed[c, 2] - posed[a, 2]
    return d0, d1, d2, e0, e1, e2, d1 * e2 - d2 * e1, d2 * e0 - d0 * e2, d0 * e1 - d1 * e0


@njit(cache=True, error_model="numpy")
def _seen(
    posed: FloatArray,
    angles: FloatArray,
    a: np.uintp,
    edges: tuple[float, ...],
    s: float,
    t: float,
    hmin: float,
    per_height: float,
    per_angle: float,
) -> tuple[float, float, float, float]:
    """Return a point of a face along s2 and s3, and the row and column of the image at which it is seen."""
    d0, d1, d2, e0, e1, e2 = edges[:6]
    across, depth = posed[a, 1], posed[a, 2]
    x, y = across + s * d1 + t * e1, depth + s * d2 + t * e2
    u = (posed[a, 0] + s * d0 + t * e0 - hmin) * per_height - 0.5
    v = (angles[a] + _angle_from(across, depth, x, y)) * per_angle
    return x, y, u, v


@njit(cache=True, error_model="numpy")
def _point(parts: int, i: int, k: int, q: int) -> tuple[float, float]:
    """Barycentric place of point q of the k-th part of strip i; upright and turned parts take turns."""
    side = 1 - 2 * (k % 2)
    sixth = 1.0 / (6 * parts)
    s = sixth * (6 * (i + k % 2) + side * (4 if q == 1 else 1))
    t = sixth * (6 * (k // 2 + k % 2) + side * (4 if q == 2 else 1))
    return s, t


@njit(cache=True, error_model="numpy")
def _angles(posed: FloatArray) -> FloatArray:
    """Return the angle of each of (n, 3) vertices around the axis, from s3 towards s2, 0 on it: (n,)."""
    angles = np.zeros(len(posed))
    for i in range(len(posed)):
        if posed[i, 1] != 0.0 or posed[i, 2] != 0.0:
            angles[i] = math.atan2(posed[i, 1], posed[i, 2])
    return angles


@njit(cache=True, error_model="numpy")
def _angle_from(across: float, depth: float, x: float, y: float) -> float:
    """Angle from (across, depth) to (x, y) around the axis; nearly all are small, and a series is faster."""
    if across == 0.0 and depth == 0.0:
        return math.atan2(x, y)
    sine, cosine = x * depth - y * across, x * across + y * depth
    if not abs(sine) < 0.1 * cosine:
        return math.atan2(sine, cosine)
    t = sine / cosine
    z = -t * t
    total = 1 / 13 + z / 15
    for odd in (11, 9, 7, 5, 3, 1):
        total = 1 / odd + z * total
    return t * total


@njit(cache=True, error_model="numpy")
def _parts(
    posed: FloatArray,
    a: np.uintp,
    b: np.uintp,
    c: np.uintp,
    per_height: float,
    per_angle: float,
    samples: float,
) -> int:
    """Parts along a side, from the cells that the face spans along the axis and around it."""
    tall = max(posed[a, 0], posed[b, 0], posed[c, 0]) - min(posed[a, 0], posed[b, 0], posed[c, 0])
    wide = math.hypot(
        max(posed[a, 1], posed[b, 1], posed[c, 1]) - min(posed[a, 1], posed[b, 1], posed[c, 1]),
        max(posed[a, 2], posed[b, 2], posed[c, 2]) - min(posed[a, 2], posed[b, 2], posed[c, 2]),
    )
    near = min(
        math.hypot(posed[a, 1], posed[a, 2]),
        math.hypot(posed[b, 1], posed[b, 2]),
        math.hypot(posed[c, 1], posed[c, 2]),
    )
    least = SLIVER * per_angle / per_height
    cells = max(tall * per_height, wide / max(near, 0.25 * wide, least) * per_angle)
    parts: int = min(max(math.ceil(samples * cells), 1), MOST_PARTS)
    return parts


@njit(cache=True, error_model="numpy")
def _deal(flux: FloatArray, area: FloatArray, u: float, v: float, through: float, extent: float) -> None:
    """Deal the flux through a part and its area out to the four cells around it, by eqs. 10 and 11."""
    rows, columns = flux.shape
    u0, v0 = math.floor(u), math.floor(v)
    fu, fv = cosine_weight(u - u0), cosine_weight(v - v0)
    left = _wrapped(v0, columns)
    right = _wrapped(v0 + 1, columns)
    for row, weight in ((u0, fu), (u0 + 1, 1.0 - fu)):
        if 0 <= row < rows:
            here = np.uintp(row)
            flux[here, left] += through * weight * fv
            flux[here, right] += through * weight * (1.0 - fv)
            area[here, left] += extent * weight * fv
            area[here, right] += extent * weight * (1.0 - fv)


@njit(cache=True, error_model="numpy")
def _wrapped(v: int, columns: int) -> np.uintp:
    """Return v modulo the columns; nearly always it is off by a turn at most, and a division takes longer."""
    if v < 0:
        v += columns
    elif v >= columns:
        v -= columns
    if not 0 <= v < columns:
        v %= columns
    return np.uintp(v)
