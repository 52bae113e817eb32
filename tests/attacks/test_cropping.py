"""Cropping: how much goes, that it goes on one side, and that a plane cuts cleanly."""

import numpy as np
import pytest
from shapes import blob, icosphere

from wm3d.attacks import Crop, HalfSpaceCrop
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, surface_area


@pytest.mark.parametrize("percent", [10, 30, 50])
def test_crop_removes_its_share_of_the_vertices_in_one_piece(percent):
    mesh = blob(1, 4)
    result = Crop(percent=percent)(mesh, np.random.default_rng(2))
    kept = {tuple(v) for v in result.vertices}
    assert kept <= {tuple(v) for v in mesh.vertices}
    # a vertex whose faces all lost a corner goes too, at most one ring along the cut
    removed = len(mesh.vertices) - len(kept)
    share = percent / 100 * len(mesh.vertices)
    assert share - 0.5 <= removed <= share + 5
    direction = np.random.default_rng(2).standard_normal(3)
    lost = [v for v in mesh.vertices if tuple(v) not in kept]
    deepest = np.sort(np.dot(lost, direction))[removed - round(share) :]
    assert (result.vertices @ direction).max() < deepest.min()


@pytest.mark.parametrize("percent", [5, 20, 50, 90])
def test_a_plane_takes_a_cap_of_archimedes_area(percent):
    sphere = icosphere(5)
    result = HalfSpaceCrop(percent=percent)(sphere, np.random.default_rng(3))
    # the area of a cap is proportional to its height
    assert surface_area(result) / surface_area(sphere) == pytest.approx(1 - percent / 100, abs=1e-4)


def test_the_cut_is_one_closed_line_in_the_plane():
    result = HalfSpaceCrop(percent=40)(icosphere(3), np.random.default_rng(3))
    edges = np.sort(result.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    rim = unique[count == 1]
    assert set(count) == {1, 2}
    assert (np.unique(rim, return_counts=True)[1] == 2).all()
    assert len(result.vertices) - len(unique) + len(result.faces) == 1  # Euler, a disc
    direction = np.random.default_rng(3).standard_normal(3)
    direction /= np.linalg.norm(direction)
    height = result.vertices @ direction
    np.testing.assert_allclose(height[np.unique(rim)], height.max(), atol=1e-12)


def test_faces_keep_their_winding():
    result = HalfSpaceCrop(percent=40)(icosphere(3), np.random.default_rng(3))
    a, b, c = (result.vertices[result.faces[:, k]] for k in range(3))
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) > 0).all()


def test_a_crop_that_leaves_nothing_is_refused():
    triangle = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], name="triangle")
    with pytest.raises(Wm3dError, match=r"^triangle: crop 50 leaves no face; crop less\.$"):
        Crop(percent=50)(triangle, np.random.default_rng(0))
