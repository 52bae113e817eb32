"""Kernels of the search for a pose, and the shifts it tries, against the same in numpy."""

import numpy as np
import pytest
from shapes import rotation

from wm3d.scanner.registration.search_kernels import (
    CELL,
    GRID,
    HALF_WIDTH,
    NEARNESS,
    OFF,
    RUN,
    TILT,
    cells,
    misfits,
    nearest_tried,
)
from wm3d.scanner.registration.shifts import FINENESS, REACH, Runs, even_shifts

RNG = np.random.default_rng(1)
PROBES = RNG.normal(0, 1.2, (40, 3))  # some lie beside the cube
TURNS = np.stack([rotation(seed) for seed in range(30)])
DISTANCE = RNG.uniform(0, 0.5, GRID**3)


def numbered(places: np.ndarray) -> np.ndarray:
    layers = np.floor((places + HALF_WIDTH) / CELL).astype(int).clip(0, GRID - 1)
    return np.ravel_multi_index(np.moveaxis(layers, -1, 0), (GRID,) * 3)


def test_places_are_numbered_by_their_cells_and_beside_the_cube_by_the_nearest():
    assert (np.abs(PROBES) > HALF_WIDTH).any()
    np.testing.assert_array_equal(cells(PROBES), numbered(PROBES))


@pytest.mark.parametrize("step", [2, 3])
def test_best_of_the_shifts_tried_is_that_of_all_looked_up_at_once(step: int):
    sizes, shifts = np.array([1.0, 0.8]), even_shifts(RNG.normal(0, [0.2, 0.1, 0.9], (500, 3)), step)
    most = np.abs(shifts).max(axis=0)
    assert most[2] > RUN * step // 2 > most[1]  # more than a run in a line, and less
    cube = DISTANCE.reshape((GRID,) * 3).round(2)  # so that some means are equal
    padded = np.pad(cube, np.column_stack([most, most]), mode="edge")
    turned = PROBES @ TURNS.swapaxes(1, 2)
    layers = [np.floor((size * turned + HALF_WIDTH) / CELL).astype(int).clip(0, GRID - 1) for size in sizes]
    least, shift = nearest_tried(PROBES, TURNS, sizes, *Runs.of(shifts, step, cube))
    for a in range(2):
        sums = [padded[tuple(np.moveaxis(layers[a] + most + s, -1, 0))].sum(axis=1) for s in shifts]
        hundreds = np.rint(100 * np.stack(sums, axis=1))
        np.testing.assert_allclose(FINENESS * least[:, a], hundreds.min(axis=1) / 100 / 40, rtol=1e-12)
        np.testing.assert_array_equal(shift[:, a], hundreds.argmin(axis=1))


def test_shifts_lie_evenly_in_the_ellipsoid_that_points_spread_to_the_nearest_first():
    points = RNG.normal(0, [0.6, 0.4, 0.8], (500, 3))
    shifts = even_shifts(points, 2)
    far = np.einsum("bi,ij,bj->b", shifts, np.linalg.inv(np.cov(points.T) / CELL**2 + np.eye(3)), shifts)
    assert (np.diff(far) >= -1e-9).all()
    assert far.max() <= REACH**2
    assert not shifts[0].any()
    assert not (shifts % 2).any()
    assert len(np.unique(shifts, axis=0)) == len(shifts)
    ellipsoid = 4 / 3 * np.pi * REACH**3 * np.sqrt(np.linalg.det(np.cov(points.T) / CELL**2 + np.eye(3)))
    assert len(shifts) == pytest.approx(ellipsoid / 2**3, rel=0.1)


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
