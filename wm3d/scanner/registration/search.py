"""Starts for a fit where nothing is known of the pose: turns, shifts and sizes of a part of the model."""

import numpy as np
from scipy.ndimage import distance_transform_edt

from wm3d.arrays import FloatArray, IntArray
from wm3d.scanner.registration.landmarks import Landmarks
from wm3d.scanner.registration.surface import POINTS, Surface
from wm3d.scanner.registration.warp import Warp
from wm3d.scanner.turns import TURNS, apart, turns

STARTS, APART = 16, 20.0
"""How many starts are returned, the best first, and the least angle between two, in degrees."""

SIZES = (1.0, 0.85, 0.7)
"""Sizes of the surface tried, in that of the landmarks: a part of a model is smaller than the whole."""

SHIFTS = np.vstack([np.zeros((1, 3)), *(step * sign * np.eye(3) for step in (0.3, 0.6) for sign in (-1, 1))])
"""Places of its middle tried, relative to that of the landmarks, in their size."""

PROBES, FAR = 64, 0.5
"""Points of the surface by which starts are compared, and the distance from which one counts as lost."""

GRID, HALF_WIDTH = 50, 2.5
"""Cells along a side of the cube in which distances are looked up, and half its width, in sizes."""


def turned_starts(surface: Surface, landmarks: Landmarks) -> list[Warp]:
    """Return the ways to lay a surface on landmarks under which its points come nearest to them.

    Points of the surface look for landmarks and not the other way round, since of a model that lost a part
    every point still has its landmark.
    """
    goal = landmarks.points.mean(axis=0)
    size = float(np.sqrt(((landmarks.points - goal) ** 2).sum(axis=1).mean()))
    distance = _distances((landmarks.points - goal) / size)
    candidates = turns(TURNS) * [1.0, 1.0, -1.0]  # the frame is left-handed
    probes: FloatArray = surface.points[:: POINTS // PROBES] @ candidates.swapaxes(1, 2)

    misfit = np.full(len(candidates), np.inf)
    scale, shift = np.ones(len(candidates)), np.zeros((len(candidates), 3))
    for tried_scale in SIZES:
        for tried_shift in SHIFTS:
            tried = distance[_cells(tried_scale * probes + tried_shift)].mean(axis=1)
            better = tried < misfit
            misfit[better], scale[better], shift[better] = tried[better], tried_scale, tried_shift

    order = np.argsort(misfit, kind="stable")
    chosen = apart(candidates[order], APART, STARTS)
    return [Warp.linear(size * scale[k] * candidates[k], goal + size * shift[k]) for k in order[chosen]]


def _distances(points: FloatArray) -> FloatArray:
    """Return how far every cell of the cube is from the nearest of (n, 3) points, `FAR` at most: (GRID³,)."""
    empty = np.ones(GRID**3, dtype=bool)
    empty[_cells(points)] = False
    distance = distance_transform_edt(empty.reshape((GRID,) * 3)) * (2 * HALF_WIDTH / GRID)
    return np.minimum(distance, FAR).ravel()


def _cells(places: FloatArray) -> IntArray:
    """Return the number of the cell in which each of (..., 3) places lies, or nearly."""
    index = ((places + HALF_WIDTH) * (GRID / (2 * HALF_WIDTH))).astype(np.int64).clip(0, GRID - 1)
    cells: IntArray = index @ np.array([GRID * GRID, GRID, 1])
    return cells
