"""Kernels of registration, against the same in numpy."""

import itertools

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
    CELL,
    GRID,
    HALF_WIDTH,
    NEARNESS,
    OFF,
    TILT,
    cells,
    compared,
    means_near,
    misfits,
    nearest_tried,
)
from wm3d.scanner.registration.warp import Warp, terms

RNG = np.random.default_rng(1)
PROBES = RNG.normal(0, 1.2, (40, 3))  # some lie beside the cube
TURNS = np.stack([rotation(seed) for seed in range(30)])
DISTANCE = RNG.uniform(0, 0.5, GRID**3)


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


def numbered(places: np.ndarray) -> np.ndarray:
    layers = np.floor((places + HALF_WIDTH) / CELL).astype(int).clip(0, GRID - 1)
    return np.ravel_multi_index(np.moveaxis(layers, -1, 0), (GRID,) * 3)


def test_places_are_numbered_by_their_cells_and_beside_the_cube_by_the_nearest():
    assert (np.abs(PROBES) > HALF_WIDTH).any()
    np.testing.assert_array_equal(cells(PROBES), numbered(PROBES))


@pytest.mark.parametrize("power", [0.0, 1.0])
def test_best_of_the_sizes_and_shifts_tried_is_that_of_all_looked_up_at_once(power: float):
    sizes, shifts = np.array([1.0, 0.8]), RNG.integers(-6, 7, (5, 3))
    more = np.array([6, 7, 9])  # cells on both sides of each axis
    distance = RNG.integers(0, 500_000, GRID + 2 * more).astype(np.int32)
    pairs = list(itertools.product(range(2), range(5)))
    turned = PROBES @ TURNS.swapaxes(1, 2)
    layers = [np.floor((size * turned + HALF_WIDTH) / CELL).astype(int).clip(0, GRID - 1) for size in sizes]
    means = np.stack(
        [
            distance[tuple(np.moveaxis(layers[a] + more + shifts[b], -1, 0))].mean(axis=1) / sizes[a] ** power
            for a, b in pairs
        ],
        axis=1,
    )
    least, size, shift = nearest_tried(PROBES, TURNS, sizes, shifts, distance, power)
    np.testing.assert_allclose(least, means.min(axis=1), rtol=1e-12)
    assert list(zip(size, shift, strict=True)) == [pairs[best] for best in means.argmin(axis=1)]


def test_misfit_counts_the_nearest_landmark_by_its_plane_its_distance_and_its_normal():
    points, normals = RNG.normal(size=(2, 9, 3))
    probe_normals = RNG.normal(size=PROBES.shape)
    nearest = RNG.integers(0, 9, GRID**3)
    sizes, shifts = RNG.uniform(0.5, 1.1, 30), RNG.normal(0, 0.3, (30, 3))
    places = sizes[:, None, None] * (PROBES @ TURNS.swapaxes(1, 2)) + shifts[:, None]
    assert (np.abs(places) > HALF_WIDTH).any()
    landmark = nearest[numbered(places)]
    off = np.abs(np.einsum("nki,nki->nk", places - points[landmark], normals[landmark]))
    assert (off < OFF).any()
    cosine = np.einsum("nki,nki->nk", probe_normals @ TURNS.swapaxes(1, 2), normals[landmark])
    parts = np.minimum(off, OFF) + NEARNESS * DISTANCE[numbered(places)] + TILT * (1 - cosine)
    expected = parts.mean(axis=1)
    found = misfits(PROBES, probe_normals, TURNS, sizes, shifts, points, normals, nearest, DISTANCE)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


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
