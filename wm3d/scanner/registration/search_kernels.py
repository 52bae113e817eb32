"""Numba kernels of the search: probes of a surface in many poses.

A pose takes a probe p to size · turn p + shift. What is near there is looked up from the cells of a cube
about the origin, numbered along z, then y, then x; for a place outside the cube, from its nearest cell.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from wm3d.arrays import FloatArray, IntArray
from wm3d.scanner.registration.kernels import Vector

GRID, HALF_WIDTH = 50, 2.5
"""Cells along a side of the cube in which landmarks are looked up, and half its width, in sizes."""

CELL = 2 * HALF_WIDTH / GRID

RUN = 4
"""Shifts along an axis that are looked up in one go, as a processor does best."""

OFF, NEARNESS, TILT = 0.25, 0.3, 0.1
"""Distance from a landmark's tangent plane that counts in full, and what the distance from the landmark and
1 − the cosine of the normals count beside. A smooth surface lies near to landmarks in wrong places too, but
not in their planes."""

FAR = 0.5
"""Distance from a landmark from which a probe counts as lost, and is not drawn to it."""

DAMPING, MOST_CHANGE = 0.003, 0.5
"""Weight of a change against that of the landmarks, for a flat patch fixes not all; and how much a turn (in
radians), a shift or the size may change in a round."""


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
    runs: IntArray,
    rank: IntArray,
    distance: NDArray[np.int32],
) -> tuple[FloatArray, IntArray]:
    """Least mean of the cells' `distance` from (k, 3) probes, over all shifts, for each turn and size.

    Turns (n, 3, 3), sizes (a,). A probe beside the cube is taken for one in the nearest cell before it is
    shifted. Returns the means and the rank of the shift, of equal ones the first: (n, a) each.

    Shifts stand in `runs` of `RUN` along the last axis, a step apart, so that they are added up side by side:
    `rank` (c, `RUN`) numbers them, −1 where there is none. The cube has room for all of them around it and is
    stored as `distance` (x, y, step, z), where every step-th cell along the axis stands next to the other;
    `runs` (c, 3) is where the first shift of a run takes a probe in the first cell of the cube, in x, y, z.
    """
    least, shift = np.empty((len(turns), len(sizes))), np.empty((len(turns), len(sizes)), dtype=np.int64)
    rows, step, row = distance.shape[1:]
    starts, flat = (
        ((runs[:, 0] * rows + runs[:, 1]) * step * row + runs[:, 2]).astype(np.uint64),
        distance.ravel(),
    )
    totals, still = np.empty(rank.shape, dtype=np.int32), np.zeros(3)
    for n in range(len(turns)):
        turned = _turned(probes, turns[n])
        for a in range(len(sizes)):
            totals[:] = 0
            for k in range(len(probes)):
                x, y, z = _placed(turned[k], sizes[a], still)
                layer = _layer(z)
                line = (_layer(x) * rows + _layer(y)) * step + layer % step
                _add_runs(totals, flat, starts, np.uint64(line * row + layer // step))
            total, shift[n, a] = _first_least(totals, rank)
            least[n, a] = total / len(probes)
    return least, shift


@njit(cache=True)
def _add_runs(
    totals: NDArray[np.int32], flat: NDArray[np.int32], starts: NDArray[np.uint64], cell: np.uint64
) -> None:
    """Add to each run of totals the run of cells from its start on; unsigned, so that it is vectorized."""
    for c in range(len(starts)):
        start = starts[c] + cell
        for j in range(RUN):
            totals[c, j] += flat[start + np.uint64(j)]


@njit(cache=True)
def _first_least(totals: NDArray[np.int32], rank: IntArray) -> tuple[int, int]:
    """Return the least of the totals that have a rank, and of equal ones the least rank."""
    least, first = np.iinfo(np.int32).max, -1
    for c in range(len(totals)):
        for j in range(RUN):
            if rank[c, j] >= 0 and (totals[c, j] < least or (totals[c, j] == least and rank[c, j] < first)):
                least, first = totals[c, j], rank[c, j]
    return least, first


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
            off, cosine = _compared((x, y, z), turned_normals[k], points[i], normals[i])
            total += min(abs(off), OFF) + NEARNESS * distance[cell] + TILT * (1.0 - cosine)
        means[n] = total / len(probes)
    return means


@njit(cache=True, nogil=True)
def approached(
    probes: FloatArray,
    probe_normals: FloatArray,
    turns: FloatArray,
    sizes: FloatArray,
    shifts: FloatArray,
    points: FloatArray,
    normals: FloatArray,
    nearest: IntArray,
    distance: FloatArray,
    rounds: int,
    least_size: float,
    most_size: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Bring (k, 3) probes nearer to the tangent planes at landmarks, from each of n poses, in so many rounds.

    In each round every probe looks for the landmark of its cell (as in `misfits`), and the change of turn,
    shift and size is solved for that brings them to the planes there, by weighted least squares: iterated
    closest points (Chen and Medioni, 1992). Returns the turns, sizes and shifts come to.
    """
    turns, sizes, shifts = turns.copy(), sizes.copy(), shifts.copy()
    for n in range(len(turns)):
        for _ in range(rounds):
            turned, turned_normals = _turned(probes, turns[n]), _turned(probe_normals, turns[n])
            change = _change(sizes[n] * turned, turned_normals, shifts[n], points, normals, nearest, distance)
            turns[n] = _rotation(change[:3]) @ turns[n]
            shifts[n] += change[3:6]
            sizes[n] = min(max(sizes[n] * (1.0 + change[6]), least_size), most_size)
    return turns, sizes, shifts


@njit(cache=True)
def _change(
    arms: FloatArray,
    arm_normals: FloatArray,
    shift: FloatArray,
    points: FloatArray,
    normals: FloatArray,
    nearest: IntArray,
    distance: FloatArray,
) -> FloatArray:
    """Rotation vector, shift and growth about `shift` that lay probes at shift + arms on planes: (7,)."""
    left, right, slope, weights = np.zeros((7, 7)), np.zeros(7), np.empty(7), 0.0
    for k in range(len(arms)):
        x, y, z = arms[k, 0], arms[k, 1], arms[k, 2]
        place = x + shift[0], y + shift[1], z + shift[2]
        cell = _cell(place)
        i = nearest[cell]
        off, cosine = _compared(place, arm_normals[k], points[i], normals[i])
        if distance[cell] >= FAR or cosine <= 0.0:
            continue
        weight = cosine * (1.0 - (distance[cell] / FAR) ** 2) ** 2
        a, b, c = normals[i, 0], normals[i, 1], normals[i, 2]
        slope[0], slope[1], slope[2] = y * c - z * b, z * a - x * c, x * b - y * a
        slope[3], slope[4], slope[5], slope[6] = a, b, c, x * a + y * b + z * c
        weights += weight
        for m in range(7):
            pull = weight * slope[m]
            right[m] -= pull * off
            for n in range(m + 1):
                left[m, n] += pull * slope[n]
    for m in range(7):
        left[:m, m] = left[m, :m]
        left[m, m] += DAMPING * weights + 1e-9  # it may be that none is reached
    right[:] = np.linalg.solve(left, right)
    change: FloatArray = right.clip(-MOST_CHANGE, MOST_CHANGE)
    return change


@njit(cache=True)
def _compared(
    place: Vector, turned_normal: FloatArray, point: FloatArray, normal: FloatArray
) -> tuple[float, float]:
    """How far a probe lies above the tangent plane at a landmark, and the cosine between their normals."""
    off: float = (place[0] - point[0]) * normal[0] + (place[1] - point[1]) * normal[1]
    off += (place[2] - point[2]) * normal[2]
    cosine: float = turned_normal[0] * normal[0] + turned_normal[1] * normal[1]
    cosine += turned_normal[2] * normal[2]
    return off, cosine


@njit(cache=True)
def _rotation(vector: FloatArray) -> FloatArray:
    """Matrix of a rotation vector (Rodrigues)."""
    angle = np.sqrt((vector**2).sum())
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: FloatArray = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    return rotation


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
