"""Kernels of registration, against the same in numpy."""

import numpy as np
import pytest
from shapes import rotation

from wm3d.metrics.surface import boxes, tree_order
from wm3d.scanner.registration import fit_kernels
from wm3d.scanner.registration.fit_kernels import (
    BEND_DAMPING,
    DAMPING,
    FACING,
    FLOOR,
    LAST_REACH,
    NARROWING,
    TUKEY,
)
from wm3d.scanner.registration.kernels import (
    compared,
    means_near,
)
from wm3d.scanner.registration.warp import Warp, terms

RNG = np.random.default_rng(1)


@pytest.mark.parametrize("many", [4, 5, 8, 9, 1000])
def test_surface_next_to_a_place_is_the_mean_of_the_nearest_points_and_of_their_normals(many: int):
    points, normals = RNG.normal(size=(2, many, 3))
    points[1], normals[1] = points[0], normals[0]  # one twice
    order = tree_order(points)
    points, normals = points[order], normals[order]
    places = np.vstack([RNG.normal(size=(200, 3)), 50 * RNG.normal(size=(5, 3)), points[:2]])
    apart = ((places[:, None] - points) ** 2).sum(axis=2)
    nearest = np.argsort(apart, axis=1)[:, :4]
    mean, normal = means_near(places, points, normals, boxes(points[:, None]), 4)
    np.testing.assert_allclose(mean, points[nearest].mean(axis=1), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(normal, normals[nearest].mean(axis=1), rtol=1e-12, atol=1e-12)


def bent_warp() -> Warp:
    return Warp(
        np.vstack([RNG.normal(size=(1, 3)), rotation(4) * [1.0, 1.2, -0.8], RNG.normal(0, 0.02, (6, 3))])
    )


def test_warped_points_and_normals_are_compared_with_those_of_another_surface():
    warp = bent_warp()
    points, normals, goals, goal_normals = RNG.normal(size=(4, 30, 3))
    normals[0] = 0  # the faces around it cancel
    off, far, cosine = compared(points, normals, goals, goal_normals, warp.coefficients, warp.back)
    apart = warp(points) - goals
    np.testing.assert_allclose(far, np.linalg.norm(apart, axis=1), rtol=1e-12)
    np.testing.assert_allclose(off, (apart * goal_normals).sum(axis=1), rtol=1e-9)
    np.testing.assert_allclose(cosine, (warp.normals(normals) * goal_normals).sum(axis=1), rtol=1e-9)
    assert cosine[0] == 0


def rounds_of_a_fit(start, count, reach, rounds, surface, goals, goal_normals):
    """Do what `fit_kernels.fitted` does, but never settle, in numpy."""
    warp = Warp(start)
    for _ in range(rounds):
        points, normals = means_near(warp.inverse(goals), *surface, 4)
        off, far, cosine = compared(points, normals, goals, goal_normals, warp.coefficients, warp.back)
        reached = (cosine > FACING) & (far < reach)
        spread = max(1.4826 * np.median(np.abs(off[reached])), FLOOR)
        weight = np.clip(1 - (off / (TUKEY * spread)) ** 2, 0, None) ** 2 * reached
        slopes = (terms(points)[:, :count, None] * goal_normals[:, None]).reshape(len(goals), -1)
        damping = np.repeat(np.r_[np.full(4, DAMPING), np.full(6, BEND_DAMPING)][:count], 3)
        normal = slopes.T @ (weight[:, None] * slopes) + np.diag(damping) * weight.sum()
        change = np.zeros((10, 3))
        change[:count] = np.linalg.solve(normal, -slopes.T @ (weight * off)).reshape(count, 3)
        warp = Warp(warp.coefficients + change)
        reach = max(LAST_REACH, NARROWING * reach)
    return warp.coefficients


@pytest.mark.parametrize("count", [4, 10])
def test_fit_solves_the_weighted_least_squares_of_each_round(count: int):
    rng = np.random.default_rng(3)
    points = rng.normal(size=(3000, 3))
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    points = normals * (1 + 0.3 * np.sin(3 * points[:, :1])) * [1.0, 0.8, 0.6]
    order = tree_order(points)
    surface = points[order], normals[order], boxes(points[order][:, None])
    start = Warp.linear(rotation(0), np.array([0.03, -0.02, 0.01])).coefficients
    goals, goal_normals = points[::10] @ rotation(0).T * 1.02, normals[::10] @ rotation(0).T
    for rounds in (1, 2, 5):
        found, held = fit_kernels.fitted(start, count, 0.3, rounds, *surface, 4, goals, goal_normals)
        plain = rounds_of_a_fit(start, count, 0.3, rounds, surface, goals, goal_normals)
        assert held
        np.testing.assert_allclose(found, plain, rtol=0, atol=1e-9)
    assert np.abs(found - start).max() > 0.01


@pytest.mark.parametrize("spoiled", ["pressed flat", "out of reach"])
def test_fit_that_does_not_hold_returns_its_start(spoiled: str):
    points = RNG.normal(size=(500, 3))
    order = tree_order(points)
    surface = points[order], points[order], boxes(points[order][:, None])
    start = Warp.linear(np.diag([1.0, 1.0, 0.05]), np.zeros(3)).coefficients
    goals = points[:50] * [1.0, 1.0, 0.05] if spoiled == "pressed flat" else points[:50] + 100
    found, held = fit_kernels.fitted(start, 4, 0.3, 5, *surface, 4, goals, goals)
    assert not held
    np.testing.assert_array_equal(found, start)
