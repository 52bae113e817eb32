"""Broken files and mirror images: how many faces, which way round, and the solid that stays."""

import numpy as np
import pytest
from shapes import blob

from wm3d.attacks import DropFaces, FlipFaces, Mirror, RepeatFaces
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, is_closed, signed_volume
from wm3d.mesh.repair.sides import Sides

BLOB = blob(1, 3)
FACES = len(BLOB.faces)


def drawn(attack) -> Mesh:
    return attack(BLOB, np.random.default_rng(1))


def as_set(faces) -> set[tuple[int, ...]]:
    return {tuple(face) for face in faces.tolist()}


def test_dropped_faces_are_the_share_asked_for():
    left = drawn(DropFaces(percent=25))
    assert len(left.faces) == FACES - round(0.25 * FACES)
    corners = np.round(left.vertices[left.faces], 12).reshape(-1, 9)
    assert as_set(corners) <= as_set(np.round(BLOB.vertices[BLOB.faces], 12).reshape(-1, 9))


def test_dropping_all_faces_is_refused():
    with pytest.raises(Wm3dError, match=r"drop-faces 99.99 leaves no face; drop fewer\.$"):
        drawn(DropFaces(percent=99.99))


def test_flipped_faces_are_the_share_asked_for_and_the_others_stay():
    flipped = drawn(FlipFaces(percent=25))
    turned = (flipped.faces != BLOB.faces).any(axis=1)
    assert np.count_nonzero(turned) == round(0.25 * FACES)
    np.testing.assert_array_equal(flipped.faces[turned], BLOB.faces[turned, ::-1])


def test_flipped_patches_hang_together():
    flipped = drawn(FlipFaces(percent=25, patches=8))
    turned = (flipped.faces != BLOB.faces).any(axis=1)
    assert 0.05 * FACES < np.count_nonzero(turned) < 0.5 * FACES
    border = np.abs(Sides.of(flipped.faces).net) == 2
    alone = np.abs(Sides.of(drawn(FlipFaces(percent=25)).faces).net) == 2
    assert np.count_nonzero(border) < 0.4 * np.count_nonzero(alone)


@pytest.mark.parametrize("turned", [False, True])
def test_repeated_faces_come_behind_all_others(turned):
    repeated = drawn(RepeatFaces(percent=25, turned=turned))
    np.testing.assert_array_equal(repeated.faces[:FACES], BLOB.faces)
    again = repeated.faces[FACES:]
    assert len(again) == round(0.25 * FACES)
    assert as_set(again[:, ::-1] if turned else again) <= as_set(BLOB.faces)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_mirror_image_is_as_large_looks_outwards_and_is_its_own_way_back(axis):
    image = drawn(Mirror(axis=axis))
    k = "xyz".index(axis)
    others = [other for other in range(3) if other != k]
    np.testing.assert_array_equal(image.vertices[:, others], BLOB.vertices[:, others])
    assert is_closed(image)
    assert signed_volume(image) == pytest.approx(signed_volume(BLOB), rel=1e-12)
    back = Mirror(axis=axis)(image, np.random.default_rng())
    np.testing.assert_allclose(back.vertices, BLOB.vertices, rtol=0, atol=1e-15)
