"""Kernels of the search for a pose, and the shifts it tries, against the same in numpy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import rotation

from wm3d.scanner.registration.search_kernels import (
    CELL,
    DAMPING,
    FAR,
    GRID,
    HALF_WIDTH,
    MOST_CHANGE,
    NEARNESS,
    OFF,
    RUN,
    TILT,
    approached,
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


def test_a_round_turns_shifts_and_scales_by_the_least_squares_of_distances_from_planes():
    rng = np.random.default_rng(1)
    probes, points = 0.3 * PROBES, 0.1 * rng.normal(size=(9, 3))
    normals, probe_normals = rng.normal(size=(9, 3)), rng.normal(size=PROBES.shape)
    normals, probe_normals = (n / np.linalg.norm(n, axis=1, keepdims=True) for n in (normals, probe_normals))
    nearest, distance = rng.integers(0, 9, GRID**3), rng.uniform(0, 1.2 * FAR, GRID**3)
    sizes, shifts = rng.uniform(0.5, 1.0, 30), rng.normal(0, 0.1, (30, 3))
    found = approached(
        probes, probe_normals, TURNS, sizes, shifts, points, normals, nearest, distance, 1, 0.4, 1.1
    )
    bounded = 0
    for n in range(30):
        arms = sizes[n] * probes @ TURNS[n].T
        landmark, far = (field[numbered(arms + shifts[n])] for field in (nearest, distance))
        plane = normals[landmark]
        cosine = np.sum(probe_normals @ TURNS[n].T * plane, axis=1)
        weight = np.where(far < FAR, np.maximum(cosine, 0) * (1 - (far / FAR) ** 2) ** 2, 0)
        off = np.sum((arms + shifts[n] - points[landmark]) * plane, axis=1)
        slope = np.column_stack([np.cross(arms, plane), plane, np.sum(arms * plane, axis=1)])
        damping = np.sqrt(DAMPING * weight.sum()) * np.eye(7)  # as rows of their own
        rows = np.vstack([np.sqrt(weight)[:, None] * slope, damping])
        change, *_ = np.linalg.lstsq(rows, np.append(-np.sqrt(weight) * off, np.zeros(7)))
        bounded += (np.abs(change) > MOST_CHANGE).any()
        change = change.clip(-MOST_CHANGE, MOST_CHANGE)
        turn = Rotation.from_rotvec(change[:3]).as_matrix() @ TURNS[n]
        size = np.clip(sizes[n] * (1 + change[6]), 0.4, 1.1)
        for got, expected in zip(found, (turn, size, shifts[n] + change[3:6]), strict=True):
            np.testing.assert_allclose(got[n], expected, rtol=1e-6, atol=1e-6)
    assert 0 < bounded < 30


def test_probes_of_a_box_find_its_faces_from_a_place_near_and_stay_where_nothing_is():
    faces = np.vstack([np.eye(3), -np.eye(3)])
    grid = np.stack(np.meshgrid(*2 * [np.linspace(-0.9, 0.9, 7)]), axis=-1).reshape(-1, 2)
    box = np.vstack(
        [np.roll(np.column_stack([np.full(49, s), grid]), k, 1) for s in (1, -1) for k in range(3)]
    )
    box_normals = np.repeat(faces, 49, axis=0)
    box = box * [1.0, 0.7, 0.5]
    lookup = np.array([np.argmin(((box - place) ** 2).sum(axis=1)) for place in centres()], dtype=np.int64)
    distance = np.minimum(np.linalg.norm(centres() - box[lookup], axis=1), FAR)
    turn = Rotation.from_rotvec([0.2, -0.15, 0.1]).as_matrix()
    start = np.stack([turn, turn]), np.array([0.9, 0.9]), np.array([[0.1, -0.1, 0.05], [9.0, 0.0, 0.0]])
    turns, sizes, shifts = approached(
        box, box_normals, *start, box, box_normals, lookup, distance, 12, 0.4, 1.1
    )
    assert np.degrees(Rotation.from_matrix(turns[0]).magnitude()) < 1
    assert sizes[0] == pytest.approx(1, abs=0.01)
    assert np.abs(shifts[0]).max() < 0.01
    for part, before in zip((turns, sizes, shifts), start, strict=True):
        np.testing.assert_allclose(part[1], before[1], atol=1e-12)


def centres() -> np.ndarray:
    """Middles of the cells of the cube."""
    return (np.indices((GRID,) * 3).reshape(3, -1).T + 0.5) * CELL - HALF_WIDTH
