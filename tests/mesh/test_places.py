"""Places: the same coordinates are one place, others are not, however they were rounded."""

import numpy as np
import pytest
from shapes import blob, soup

from wm3d.mesh import places
from wm3d.mesh.kernels import row_hashes


def splitmix(key: np.ndarray) -> np.ndarray:
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB), (31, 1)):
        key = (key ^ (key >> np.uint64(shift))) * np.uint64(factor)
    return key


def test_hashes_mix_one_column_after_the_other():
    rows = np.random.default_rng(1).integers(0, 2**64, (1000, 3), dtype=np.uint64)
    wanted = splitmix(splitmix(splitmix(rows[:, 0]) ^ rows[:, 1]) ^ rows[:, 2])
    np.testing.assert_array_equal(row_hashes(rows), wanted)


def test_corners_of_unwelded_faces_share_their_places():
    mesh = blob(1, 3)
    first, place = places(soup(mesh).vertices)
    assert len(first) == len(mesh.vertices)
    np.testing.assert_array_equal(soup(mesh).vertices[first][place], soup(mesh).vertices)


@pytest.mark.parametrize("decimals", [1, 2, 3])
def test_rounded_coordinates_do_not_meet_by_chance(decimals):
    rounded = np.round(blob(0, 6).vertices, decimals)
    assert len(places(rounded).first) == len(np.unique(rounded, axis=0))


def test_zero_has_no_sign():
    assert len(places(np.array([[0.0, 1.0, 0.0], [-0.0, 1.0, -0.0]])).first) == 1
