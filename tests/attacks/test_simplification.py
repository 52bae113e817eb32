"""Simplification: the wanted number of faces, a sound mesh, and the same result in every unit."""

import numpy as np
import pytest
from shapes import blob

from wm3d.attacks import Simplify
from wm3d.attacks.clustering import cluster
from wm3d.attacks.kernels import count_faces
from wm3d.mesh import Mesh, is_closed, signed_volume

ENGINES = {"fast-simplification": 2, "pymeshlab-quadric": 2, "clustering": 30}
"""How far from the wanted number of faces each may stop, of the 5120 of the blob or the bunny's 56172."""


@pytest.fixture(scope="module", params=["blob", "bunny"])
def mesh(request) -> Mesh:
    if request.param == "bunny":
        return request.getfixturevalue("bunny")
    return Mesh(blob(4, 4).vertices + np.array([5, -6, 7]), blob(4, 4).faces)


@pytest.mark.parametrize("simplifier", ENGINES)
def test_target_is_reached_and_the_solid_stays_in_its_place(mesh, simplifier):
    result = Simplify(ratio=0.5, simplifier=simplifier)(mesh, np.random.default_rng(0))
    assert abs(len(result.faces) - len(mesh.faces) // 2) <= ENGINES[simplifier]
    assert signed_volume(result) == pytest.approx(signed_volume(mesh), rel=0.01)
    for bound in (np.min, np.max):
        before, after = bound(mesh.vertices, axis=0), bound(result.vertices, axis=0)
        np.testing.assert_allclose(after, before, rtol=0, atol=0.02 * mesh.diagonal)
    corners = np.sort(result.faces, axis=1)
    assert len(np.unique(corners, axis=0)) == len(corners)
    assert (np.diff(corners, axis=1) > 0).all()
    if simplifier != "clustering":  # which may pinch a thin part
        assert is_closed(result)


@pytest.mark.parametrize("simplifier", ENGINES)
def test_unit_of_the_mesh_does_not_matter(simplifier):
    # quadric engines hold errors against absolute bounds; powers of two keep every bit of the coordinates
    small, attack = blob(5, 3), Simplify(simplifier=simplifier)
    large = small.with_vertices(2.0**20 * small.vertices)
    here, there = attack(small, np.random.default_rng(0)), attack(large, np.random.default_rng(0))
    np.testing.assert_array_equal(there.faces, here.faces)
    np.testing.assert_array_equal(there.vertices, 2.0**20 * here.vertices)


def test_clustered_vertices_are_the_means_of_their_cells():
    mesh, size = blob(6, 3), 0.2
    vertices, faces = cluster(mesh.vertices, mesh.faces, size)
    cells = np.floor((mesh.vertices - mesh.vertices.min(axis=0)) / size)
    members: dict[tuple[float, ...], list[np.ndarray]] = {}
    for cell, vertex in zip(map(tuple, cells), mesh.vertices, strict=True):
        members.setdefault(cell, []).append(vertex)
    means = {cell: np.mean(group, axis=0) for cell, group in members.items()}
    expected = np.array(list(means.values()))
    nearest = np.abs(vertices[:, None] - expected).max(axis=2).min(axis=1)
    assert nearest.max() < 1e-14
    assert len(vertices) <= len(expected)

    # each face joins the means of the cells of some face of the input, wound alike
    of_face = [[tuple(np.round(means[tuple(cells[v])], 9)) for v in face] for face in mesh.faces]
    wound = {tuple(corners[k:] + corners[:k]) for corners in of_face for k in range(3)}
    kept = [tuple(tuple(np.round(vertices[v], 9)) for v in face) for face in faces]
    assert set(kept) <= wound


def test_clustering_ignores_vertices_that_no_face_uses():
    mesh = blob(6, 3)
    stray = Mesh(np.vstack([mesh.vertices, mesh.vertices[:50] * 0.9]), mesh.faces)
    for result, expected in zip(
        cluster(stray.vertices, stray.faces, 0.2), cluster(mesh.vertices, mesh.faces, 0.2), strict=True
    ):
        np.testing.assert_array_equal(result, expected)


def test_faces_are_counted_as_clustering_leaves_them(bunny):
    for size in (0.004, 0.01, 0.03, 0.1, 2.0):
        size *= bunny.diagonal
        cells = np.floor((bunny.vertices - bunny.vertices.min(axis=0)) / size)
        _, cell = np.unique(cells, axis=0, return_inverse=True)
        corners = np.unique(np.sort(cell[bunny.faces], axis=1), axis=0)
        whole = corners[(np.diff(corners, axis=1) > 0).all(axis=1)]
        assert count_faces(bunny.vertices, bunny.faces, size) == len(whole)
        assert len(cluster(bunny.vertices, bunny.faces, size)[1]) == len(whole)
