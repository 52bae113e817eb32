"""Kernels of registration, against the same in numpy."""

import itertools

import numpy as np
import pytest
from shapes import rotation

from wm3d.metrics.surface import boxes, tree_order
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
from wm3d.scanner.registration.warp import Warp

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


def test_best_of_the_sizes_and_shifts_tried_is_that_of_all_looked_up_at_once():
    sizes, shifts = np.array([1.0, 0.8]), RNG.normal(0, 0.5, (5, 3))
    pairs = list(itertools.product(range(2), range(5)))
    turned = PROBES @ TURNS.swapaxes(1, 2)
    means = np.stack(
        [DISTANCE[numbered(sizes[a] * turned + shifts[b])].mean(axis=1) for a, b in pairs], axis=1
    )
    least, size, shift = nearest_tried(PROBES, TURNS, sizes, shifts, DISTANCE)
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
