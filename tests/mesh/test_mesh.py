"""Mesh: what it refuses, what it promises."""

import numpy as np
import pytest
from shapes import box, tetrahedron

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

CORNERS = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    ("vertices", "faces", "sentence"),
    [
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], "vertex 2 has a coordinate that is NaN"),
        ([[0, 0, 0], [np.inf, 0, 0], [0, 1, 0]], [[0, 1, 2]], "vertex 1 has a coordinate that is NaN or inf"),
        ([[0, 0, 0], [1e300, 0, 0], [0, 1, 0]], [[0, 1, 2]], "a coordinate is 1e\\+300; rescale"),
        ([[2, 3, 4]] * 3, [[0, 1, 2]], "all vertices lie in one point"),
        (CORNERS, [[0, 1, 3]], "a face names vertex 3, but the vertices are 0 to 2"),
        (CORNERS, [[0, 1, -1]], "a face names vertex -1, but"),
        (CORNERS, [[0, 1, 1.5]], "faces must hold whole numbers"),
        (CORNERS, [[0, 1, np.nan]], "faces must hold whole numbers"),
        (CORNERS, np.empty((0, 3)), "has no faces; wm3d needs a triangle mesh, not a point cloud"),
        (CORNERS, [[0, 1, 2, 0]], r"faces must be an \(n, 3\) array of numbers, got int64 \(1, 4\)"),
        ([[0, 0], [1]], [[0, 1, 2]], r"vertices must be an \(n, 3\) array of numbers"),
        ([["a", "b", "c"]], [[0, 0, 0]], r"vertices must be an \(n, 3\) array of numbers, got <U1"),
    ],
)
def test_impossible_mesh_is_refused_in_one_sentence(vertices, faces, sentence):
    with pytest.raises(Wm3dError, match=f"^part: {sentence}") as refusal:
        Mesh(vertices, faces, name="part")
    assert str(refusal.value).count("\n") == 0


def test_mesh_owns_its_arrays_and_nobody_can_write_to_them():
    vertices = np.array(CORNERS, dtype=np.float64)
    mesh = Mesh(vertices, [[0, 1, 2]])
    vertices[0] = 9
    assert mesh.vertices[0].tolist() == [0, 0, 0]
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        mesh.faces[0] = 1


def test_unused_vertices_open_borders_and_degenerate_faces_are_allowed():
    mesh = Mesh([*CORNERS, [5, 5, 5]], [[0, 1, 2], [1, 1, 2]])
    assert len(mesh.vertices) == 4
    assert len(mesh.faces) == 2


def test_digest_sees_every_bit_but_not_the_name():
    mesh = box()
    assert Mesh(mesh.vertices, mesh.faces, name="other").digest() == mesh.digest()
    nudged = mesh.vertices.copy()
    nudged[3, 1] = np.nextafter(nudged[3, 1], 1)
    assert mesh.with_vertices(nudged).digest() != mesh.digest()
    assert Mesh(mesh.vertices, np.roll(mesh.faces, 1, axis=0)).digest() != mesh.digest()


def test_digest_is_the_same_on_every_machine():
    # golden: sha256 of "4 4\n", the vertices as little-endian float64 and the faces as little-endian int64
    assert tetrahedron().digest() == "450eaa3e721657de53aedc367c48e9323d5985c5d72d2373be656bb88cd7318d"


def test_with_vertices_keeps_faces_and_name_and_checks_the_coordinates():
    mesh = box()
    moved = mesh.with_vertices(mesh.vertices + 1)
    assert moved.faces is mesh.faces
    assert moved.name == mesh.name
    with pytest.raises(Wm3dError, match=r"box: expected \(8, 3\) vertices, got \(7, 3\)"):
        mesh.with_vertices(mesh.vertices[:7])
    with pytest.raises(Wm3dError, match="NaN"):
        mesh.with_vertices(np.full((8, 3), np.nan))


def test_repr_is_short():
    assert repr(box()) == "Mesh('box', 8 vertices, 12 faces)"


def test_diagonal_of_a_box_is_pythagoras():
    assert box((1, 2, 2)).diagonal == 3


def test_read_only_vertices_are_kept_uncopied_and_others_are_not():
    mesh = tetrahedron()
    fresh = mesh.vertices + 1.0
    assert mesh.with_vertices(fresh).vertices is not fresh
    fresh.flags.writeable = False
    assert mesh.with_vertices(fresh).vertices is fresh
    assert mesh.with_vertices(fresh[:]).vertices is not fresh  # a view: its owner may still write
