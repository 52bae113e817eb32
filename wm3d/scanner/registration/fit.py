"""Fitting a warp: iterated closest points, from a surface to the tangent planes at landmarks."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from wm3d.arrays import BoolArray, FloatArray
from wm3d.scanner.registration import kernels
from wm3d.scanner.registration.landmarks import Landmarks
from wm3d.scanner.registration.surface import Surface
from wm3d.scanner.registration.warp import LINEAR_TERMS, QUADRATIC_TERMS, Warp, terms

ROUNDS = 40
"""Most rounds of a fit."""

SETTLED = 3e-4
"""Change of the coefficients below which a fit ends; about a hundredth of a cell (of 100 blocks)."""

REACH, LAST_REACH, NARROWING = 0.3, 0.1, 0.85
"""How far off a landmark the surface may lie: at first, at last, and how fast that falls."""

FACING = 0.3
"""Least cosine between the normals of surface and landmark."""

FLOOR = 0.004
"""Least spread of the distances that counts: the surface is known no better."""

TUKEY = 4.0
"""Distance over the spread from which a landmark has no weight (Tukey's biweight)."""

NEAR = 0.02
"""Distance at which a landmark is no longer met: half a cell of 100 blocks, in the unit of the frame."""

DAMPING = np.r_[np.full(LINEAR_TERMS, 1e-6), np.full(QUADRATIC_TERMS - LINEAR_TERMS, 1e-3)]
"""Weight of each term of the change against that of the landmarks: a plane does not fix all of them."""


class Fit(NamedTuple):
    """A warp, and its `share_met`."""

    warp: Warp
    share: float


class _Match(NamedTuple):
    """The surface at the landmarks that it reaches: points before the warp, distances n·(y − p)."""

    points: FloatArray
    distance: FloatArray
    reached: BoolArray


def fitted(
    surface: Surface,
    landmarks: Landmarks,
    start: Warp,
    *,
    quadratic: bool,
    reach: float = REACH,
    rounds: int = ROUNDS,
) -> Fit:
    """Improve a warp of a surface until it lies at the landmarks, as many as can be.

    Each round looks for the surface nearest to each landmark and solves for the warp that brings it to the
    tangent planes there, by least squares with Tukey's weights: what was cut off or added does not count.
    """
    count = QUADRATIC_TERMS if quadratic else LINEAR_TERMS
    warp = start
    for _ in range(rounds):
        match = _match(surface, landmarks, warp, reach)
        if match.reached.sum() < 3 * count:
            return Fit(start, 0.0)
        change = _change(match, landmarks, count)
        warp = Warp(warp.coefficients + change)
        reach = max(LAST_REACH, NARROWING * reach)
        if not warp.is_sound():
            return Fit(start, 0.0)
        if np.abs(change).max() < SETTLED:
            break
    return Fit(warp, share_met(surface, landmarks, warp))


def share_met(surface: Surface, landmarks: Landmarks, warp: Warp, near: float = NEAR) -> float:
    """Return the share of the landmarks that a warped surface meets, from 0 to 1.

    Each counts 1 − (d/near)² for the distance d of the surface, so that a surface that lies right counts more
    than one of another shape that was bent until it came near.
    """
    match = _match(surface, landmarks, warp, LAST_REACH)
    return float(np.mean(match.reached * np.clip(1 - (match.distance / near) ** 2, 0, None)))


def nearest(surface: Surface, landmarks: Landmarks, poses: Sequence[Warp]) -> Warp:
    """Return the pose under which a surface lies nearest to the landmarks, where each may be the right one.

    A symmetric solid can be laid in all of them. What it carries is not symmetric, and the landmarks lie on
    what it carries: by root mean square, distances being counted up to `NEAR`.
    """
    if len(poses) == 1:
        return poses[0]

    def apart(pose: Warp) -> float:
        match = _match(surface, landmarks, pose, LAST_REACH)
        return float(np.mean(np.where(match.reached, np.minimum(np.abs(match.distance), NEAR), NEAR) ** 2))

    return min(poses, key=apart)


def _match(surface: Surface, landmarks: Landmarks, warp: Warp, reach: float) -> _Match:
    points, normals = surface.near(warp.inverse(landmarks.points))
    off, far, cosine = kernels.compared(
        points, normals, landmarks.points, landmarks.normals, warp.coefficients, warp.back
    )
    return _Match(points, off, (cosine > FACING) & (far < reach))


def _change(match: _Match, landmarks: Landmarks, count: int) -> FloatArray:
    """Solve for the change of the first `count` terms that takes the distances away: (10, 3)."""
    spread = max(1.4826 * float(np.median(np.abs(match.distance[match.reached]))), FLOOR)
    weight = np.clip(1 - (match.distance / (TUKEY * spread)) ** 2, 0, None) ** 2 * match.reached
    slopes = terms(match.points)[:, :count, None] * landmarks.normals[:, None, :]
    slopes = slopes.reshape(len(weight), -1)
    normal = slopes.T @ (weight[:, None] * slopes)
    normal += np.diag(np.repeat(DAMPING[:count], 3)) * weight.sum()
    change = np.zeros((QUADRATIC_TERMS, 3))
    change[:count] = np.linalg.solve(normal, -slopes.T @ (weight * match.distance)).reshape(count, 3)
    return change
