"""Laying a surface over landmarks: from the poses it may have, or from every side where they fail."""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import distance_transform_edt

from wm3d.arrays import FloatArray, IntArray
from wm3d.scanner.registration.fit import FLOOR, Fit, fitted, share_met
from wm3d.scanner.registration.landmarks import Landmarks
from wm3d.scanner.registration.surface import Surface
from wm3d.scanner.registration.warp import Warp
from wm3d.scanner.turns import TURNS, apart, turns

EXACT = FLOOR / 2
"""Distance at which half of the landmarks must be met for a pose to be left as it is."""

FEWEST = 60
"""Fewest landmarks that say more than a pose; few have a normal where a model is all edges."""

SURE = 0.8
"""Share of the landmarks met from which no other start is tried."""

STARTS, APART = 16, 20.0
"""How many turned starts are tried, the best first, and the least angle between two, in degrees."""

FAR_REACH = 1.0
"""`REACH` from a turned start."""

SKETCH, SKETCH_ROUNDS = 3, 15
"""Turned starts are tried on one landmark in so many, for so many rounds; the best is then fitted in full."""

PROBES, FAR = 100, 0.5
"""Landmarks by which turns are compared, and the distance from which one counts as lost, in sizes of the
surface."""

GRID, HALF_WIDTH = 64, 4.0
"""Cells along a side of the cube in which their distances are looked up, and half its width."""


def registered(surface: Surface, landmarks: Landmarks, poses: Sequence[Warp]) -> Fit:
    """Return the warp that lays a surface over landmarks, and what share of them it meets.

    Only the shape decides, never a key: the p-value of a detector that reads the warped mesh stays exact.

    Parameters
    ----------
    surface : Surface
    landmarks : Landmarks
    poses : sequence of Warp
        Linear maps that may lay the surface over the landmarks already, the likeliest first. A pose that does
        so to a fraction of a cell is returned as it is.
    """
    if len(landmarks.points) < FEWEST:
        return Fit(poses[0], 0.0)
    fits = []
    for pose in poses:
        if share_met(surface, landmarks, pose, EXACT) > 0.5:
            return Fit(pose, share_met(surface, landmarks, pose))
        fits.append(_bent(surface, landmarks, pose))
        if fits[-1].share >= SURE:
            return fits[-1]
    fits.append(_bent(surface, landmarks, _searched(surface, landmarks)))
    return _best(fits)


def _bent(surface: Surface, landmarks: Landmarks, start: Warp) -> Fit:
    """Fit a linear map first and then, from there, a quadratic one."""
    linear = fitted(surface, landmarks, start, quadratic=False)
    return _best([linear, fitted(surface, landmarks, linear.warp, quadratic=True)])


def _best(fits: list[Fit]) -> Fit:
    return max(fits, key=lambda fit: fit.share)


def _searched(surface: Surface, landmarks: Landmarks) -> Warp:
    """Return the best of the fits from turned starts."""
    sketch = landmarks.every(SKETCH)
    fits = [
        fitted(surface, sketch, start, quadratic=False, reach=FAR_REACH, rounds=SKETCH_ROUNDS)
        for start in _turned_starts(surface, landmarks)
    ]
    return _best(fits).warp


def _turned_starts(surface: Surface, landmarks: Landmarks) -> list[Warp]:
    """Return the turns of a surface, at middle and size of the landmarks, that come nearest to them."""
    goal = landmarks.points.mean(axis=0)
    size = float(np.sqrt(((landmarks.points - goal) ** 2).sum(axis=1).mean()))
    probes = landmarks.every(max(1, len(landmarks.points) // PROBES)).points - goal
    candidates = turns(TURNS) * [1.0, 1.0, -1.0]  # the frame is left-handed
    distance = _distances(surface.points, probes / size @ candidates)  # turned back
    misfit = np.minimum(distance, FAR).mean(axis=1)
    chosen = apart(candidates[np.argsort(misfit, kind="stable")], APART, STARTS)
    return [Warp.linear(size * turn, goal) for turn in chosen]


def _distances(points: FloatArray, places: FloatArray) -> FloatArray:
    """Return how far (..., 3) places are from the nearest of (n, 3) points, to about a step of a grid."""
    empty = np.ones((GRID,) * 3, dtype=bool)
    empty[_cell(points)] = False
    distance: FloatArray = distance_transform_edt(empty)[_cell(places)] * (2 * HALF_WIDTH / GRID)
    return distance


def _cell(places: FloatArray) -> tuple[IntArray, ...]:
    index = ((places / HALF_WIDTH + 1) * (GRID / 2)).astype(np.int64).clip(0, GRID - 1)
    return tuple(np.moveaxis(index, -1, 0))
