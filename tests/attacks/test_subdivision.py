"""Subdivision: counts, known positions, limits and borders of the three rules."""

import numpy as np
import pytest
from shapes import blob, box, icosphere, tetrahedron

from wm3d.attacks import Subdivide
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, is_closed, signed_volume, surface_area

RNG = np.random.default_rng(0)


@pytest.mark.parametrize(("rule", "factor"), [("midpoint", 4), ("loop", 4), ("sqrt3", 3)])
@pytest.mark.parametrize("mesh", [tetrahedron(), box(), blob(1, 3)], ids=lambda mesh: mesh.name)
def test_faces_multiply_and_a_closed_surface_stays_closed(rule, factor, mesh):
    result = Subdivide(rule=rule)(mesh, RNG)
    assert len(result.faces) == factor * len(mesh.faces)
    assert len(result.vertices) - len(result.faces) / 2 == 2  # Euler, genus 0
    assert is_closed(result)
    assert signed_volume(result) > 0


def test_midpoints_change_neither_area_nor_volume():
    mesh = blob(1, 3)
    result = Subdivide(rule="midpoint")(mesh, RNG)
    np.testing.assert_array_equal(result.vertices[: len(mesh.vertices)], mesh.vertices)
    assert surface_area(result) == pytest.approx(surface_area(mesh), rel=1e-12)
    assert signed_volume(result) == pytest.approx(signed_volume(mesh), rel=1e-12)


def test_loop_positions_on_a_tetrahedron():
    mesh = tetrahedron()
    result = Subdivide(rule="loop")(mesh, RNG)
    # β = (5/8 − (3/8 + cos(2π/3)/4)²)/3 = 3/16, so an old vertex is 7/16 v + 3/16 (sum of the others)
    total = mesh.vertices.sum(axis=0)
    old = 7 / 16 * mesh.vertices + 3 / 16 * (total - mesh.vertices)
    # 3/8 of either end and 1/8 of either vertex opposite
    pairs = [(i, j) for i in range(4) for j in range(i)]
    new = [total / 8 + (mesh.vertices[i] + mesh.vertices[j]) / 4 for i, j in pairs]
    expected = np.vstack([old, new])
    np.testing.assert_allclose(
        result.vertices[np.lexsort(result.vertices.T)], expected[np.lexsort(expected.T)], atol=1e-15
    )


def test_sqrt3_positions_on_a_tetrahedron():
    mesh = tetrahedron()
    result = Subdivide(rule="sqrt3")(mesh, RNG)
    # valence 3: α = (4 − 2 cos 2π/3)/9 = 5/9
    others = (mesh.vertices.sum(axis=0) - mesh.vertices) / 3
    np.testing.assert_allclose(result.vertices[:4], 4 / 9 * mesh.vertices + 5 / 9 * others, atol=1e-15)
    np.testing.assert_allclose(result.vertices[4:], mesh.vertices[mesh.faces].mean(axis=1), atol=1e-15)


def test_sqrt3_twice_splits_every_edge_in_three():
    mesh = icosphere(2)
    twice = Subdivide(rule="sqrt3")(Subdivide(rule="sqrt3")(mesh, RNG), RNG)
    length = [np.linalg.norm(np.diff(m.vertices[m.faces], axis=1), axis=2).mean() for m in (mesh, twice)]
    assert length[1] == pytest.approx(length[0] / 3, rel=0.03)


def test_sqrt3_leaves_borders_and_edges_of_three_faces():
    open_box = Mesh(box().vertices, box().faces[2:])
    result = Subdivide(rule="sqrt3")(open_box, RNG)
    assert len(result.faces) == 30
    rim = np.unique(box().faces[:2])
    np.testing.assert_array_equal(result.vertices[rim], box().vertices[rim])
    fan = Mesh([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    assert len(Subdivide(rule="sqrt3")(fan, RNG).faces) == 9


def test_loop_refuses_an_edge_of_three_faces():
    fan = Mesh([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]], [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    with pytest.raises(Wm3dError, match="needs a manifold surface"):
        Subdivide(rule="loop")(fan, RNG)
