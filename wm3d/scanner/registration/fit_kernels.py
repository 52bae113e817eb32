"""Numba kernels of a fit: the rounds of iterated closest points, and the least squares of each."""

import numpy as np
from numba import njit

from wm3d.arrays import BoolArray, FloatArray
from wm3d.scanner.registration.kernels import compared, means_near, preimages
from wm3d.scanner.registration.warp import FARTHEST, INVERSIONS, LINEAR_TERMS, MOST_BEND, MOST_STRETCH

SETTLED = 3e-4
"""Change of the coefficients below which a fit ends; about a hundredth of a cell (of 100 blocks)."""

LAST_REACH, NARROWING = 0.1, 0.85
"""How far off a landmark the surface may lie at last, and how fast that falls."""

FACING = 0.3
"""Least cosine between the normals of surface and landmark."""

FLOOR = 0.004
"""Least spread of the distances that counts: the surface is known no better."""

TUKEY = 4.0
"""Distance over the spread from which a landmark has no weight (Tukey's biweight)."""

DAMPING, BEND_DAMPING = 1e-6, 1e-3
"""Weight of a change, linear and of second degree, against that of the landmarks: a plane fixes not all."""


@njit(cache=True, nogil=True)
def fitted(
    start: FloatArray,
    terms: int,
    reach: float,
    rounds: int,
    points: FloatArray,
    normals: FloatArray,
    boxes: FloatArray,
    neighbours: int,
    goals: FloatArray,
    goal_normals: FloatArray,
) -> tuple[FloatArray, bool]:
    """Improve the first `terms` coefficients of a warp (10, 3) in so many rounds, or fewer if they settle.

    `points`, `normals` and `boxes` are those of the surface (see `means_near`), `goals` and `goal_normals`
    (k, 3) landmarks. Returns the coefficients, and whether the fit held; `start` where it did not.
    """
    coefficients = start.copy()
    for _ in range(rounds):
        back = np.linalg.inv(coefficients[1:LINEAR_TERMS])
        inversions = INVERSIONS if coefficients[LINEAR_TERMS:].any() else 0
        places = preimages(goals, coefficients, back, inversions, FARTHEST)
        near, near_normals = means_near(places, points, normals, boxes, neighbours)
        off, far, cosine = compared(near, near_normals, goals, goal_normals, coefficients, back)
        reached = (cosine > FACING) & (far < reach)
        if reached.sum() < 3 * terms:
            return start, False
        change = _change(near, off, reached, goal_normals, terms)
        coefficients[:terms] += change
        reach = max(LAST_REACH, NARROWING * reach)
        if not sound(coefficients):
            return start, False
        if np.abs(change).max() < SETTLED:
            break
    return coefficients, True


@njit(cache=True)
def sound(coefficients: FloatArray) -> bool:
    """Tell whether the linear part of a warp has an inverse and dominates, as far as a model reaches."""
    stretch = np.linalg.svd(coefficients[1:LINEAR_TERMS])[1]
    bend = np.abs(coefficients[LINEAR_TERMS:]).max()
    return bool(stretch[0] < MOST_STRETCH and stretch[-1] > 1 / MOST_STRETCH and bend < MOST_BEND)


@njit(cache=True)
def _change(
    points: FloatArray, off: FloatArray, reached: BoolArray, normals: FloatArray, terms: int
) -> FloatArray:
    """Solve for the change (terms, 3) that takes the distances `off` from the landmarks' planes away."""
    spread = max(1.4826 * np.median(np.abs(off[reached])), FLOOR)
    size = 3 * terms
    normal, right, slopes = np.zeros((size, size)), np.zeros(size), np.empty(size)
    total = 0.0
    for n in range(len(points)):
        weight = 1.0 - (off[n] / (TUKEY * spread)) ** 2
        if not reached[n] or weight <= 0.0:
            continue
        weight *= weight
        total += weight
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        monomials = (1.0, x, y, z, x * x, y * y, z * z, x * y, y * z, z * x)
        for t in range(terms):
            for axis in range(3):
                slopes[3 * t + axis] = monomials[t] * normals[n, axis]
        for i in range(size):
            right[i] -= weight * off[n] * slopes[i]
            for j in range(i + 1):
                normal[i, j] += weight * slopes[i] * slopes[j]
    for i in range(size):
        for j in range(i):
            normal[j, i] = normal[i, j]
        normal[i, i] += total * (DAMPING if i < 3 * LINEAR_TERMS else BEND_DAMPING)
    change = np.empty((terms, 3))
    change[:] = np.linalg.solve(normal, right).reshape(terms, 3)
    return change
