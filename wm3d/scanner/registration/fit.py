"""Fitting a warp: iterated closest points, from a surface to the tangent planes at landmarks."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from wm3d.arrays import BoolArray, FloatArray
from wm3d.scanner.registration import fit_kernels, kernels
from wm3d.scanner.registration.fit_kernels import FACING, LAST_REACH
from wm3d.scanner.registration.landmarks import Landmarks
from wm3d.scanner.registration.surface import NEIGHBOURS, Surface
from wm3d.scanner.registration.warp import LINEAR_TERMS, QUADRATIC_TERMS, Warp

ROUNDS = 40
"""Most rounds of a fit."""

REACH = 0.3
"""How far off a landmark the surface may lie at first."""

NEAR = 0.02
"""Distance at which a landmark is no longer met: half a cell of 100 blocks, in the unit of the frame."""


class Fit(NamedTuple):
    """A warp, its `share_met`, and whether it is a pose that was right as it came."""

    warp: Warp
    share: float
    exact: bool = False


class _Match(NamedTuple):
    """How far the surface lies from the planes at the landmarks, and which of these it reaches: (k,) each."""

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
    terms = QUADRATIC_TERMS if quadratic else LINEAR_TERMS
    coefficients, held = fit_kernels.fitted(
        start.coefficients,
        terms,
        reach,
        rounds,
        *surface.tree,
        NEIGHBOURS,
        landmarks.points,
        landmarks.normals,
    )
    if not held:
        return Fit(start, 0.0)
    warp = Warp(coefficients)
    return Fit(warp, share_met(surface, landmarks, warp))


def share_met(surface: Surface, landmarks: Landmarks, warp: Warp, near: float = NEAR) -> float:
    """Return the share of the landmarks that a warped surface meets, from 0 to 1.

    Each counts 1 − (d/near)² for the distance d of the surface, so that a surface that lies right counts more
    than one of another shape that was bent until it came near.
    """
    match = _match(surface, landmarks, warp)
    return float(np.mean(match.reached * np.clip(1 - (match.distance / near) ** 2, 0, None)))


def nearest(surface: Surface, landmarks: Landmarks, poses: Sequence[Warp]) -> Warp:
    """Return the pose under which a surface lies nearest to the landmarks, where each may be the right one.

    A symmetric solid can be laid in all of them. What it carries is not symmetric, and the landmarks lie on
    what it carries: by root mean square, distances being counted up to `NEAR`.
    """
    if len(poses) == 1:
        return poses[0]

    def apart(pose: Warp) -> float:
        match = _match(surface, landmarks, pose)
        return float(np.mean(np.where(match.reached, np.minimum(np.abs(match.distance), NEAR), NEAR) ** 2))

    return min(poses, key=apart)


def _match(surface: Surface, landmarks: Landmarks, warp: Warp) -> _Match:
    points, normals = surface.near(warp.inverse(landmarks.points))
    off, far, cosine = kernels.compared(
        points, normals, landmarks.points, landmarks.normals, warp.coefficients, warp.back
    )
    return _Match(off, (cosine > FACING) & (far < LAST_REACH))
