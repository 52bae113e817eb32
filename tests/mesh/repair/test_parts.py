"""Closed parts wound against each other: turned over where they lie apart, left where one is a hollow."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapes import blob, box, icosphere, inside_out, soup, together

from wm3d.mesh import Mesh, large_parts, signed_volume, whole_surface
from wm3d.mesh.repair.kernels import face_parts, part_volumes
from wm3d.mesh.repair.parts import part_turns


def moved(mesh: Mesh, shift: float) -> Mesh:
    return mesh.with_vertices(mesh.vertices + shift)


BALL, SMALL, TINY = icosphere(3), icosphere(2, 0.5), icosphere(1, 0.1)
VOLUME, INNER = signed_volume(BALL), signed_volume(SMALL)


@pytest.mark.parametrize(
    ("mesh", "volume"),
    [
        (together(BALL, moved(inside_out(SMALL), 5)), VOLUME + INNER),
        (together(inside_out(BALL), moved(SMALL, 5)), -VOLUME - INNER),  # as the largest is wound
        (together(BALL, inside_out(SMALL)), VOLUME - INNER),  # a hollow
        (together(BALL, SMALL), VOLUME + INNER),  # a kernel, as it was
        (
            together(icosphere(3, 1.5), moved(inside_out(together(BALL, inside_out(SMALL))), 5)),
            signed_volume(icosphere(3, 1.5)) + VOLUME - INNER,  # a hollow goes with what it is in
        ),
        (
            together(*(moved(SMALL, 2 * k) for k in range(20)), moved(inside_out(SMALL), -5)),  # many alike
            21 * INNER,
        ),
        (together(BALL, moved(inside_out(TINY), 5)), VOLUME - signed_volume(TINY)),  # a splinter
    ],
    ids=["apart", "apart, inwards", "hollow", "kernel", "hollow apart", "many alike", "splinter"],
)
def test_parts_bound_what_they_bound_each_for_itself(mesh, volume):
    assert signed_volume(whole_surface(mesh)) == pytest.approx(volume, rel=1e-12)


def test_an_open_part_stays():
    upper = BALL.vertices[BALL.faces].mean(axis=1)[:, 2] > 0.3
    mesh = together(BALL, moved(inside_out(Mesh(BALL.vertices, BALL.faces[upper])), 5))
    assert (part_turns(mesh.vertices, mesh.faces) == 1).all()


def test_a_crumb_beside_a_large_open_part_stays():
    upper = BALL.vertices[BALL.faces].mean(axis=1)[:, 2] > 0.3
    crumbs = together(moved(TINY, 3), moved(inside_out(TINY), 5))
    mesh = together(Mesh(BALL.vertices, BALL.faces[upper]), crumbs)
    assert (part_turns(mesh.vertices, mesh.faces) == 1).all()


def test_large_parts_are_those_of_many_faces_largest_first_and_tell_whether_they_are_closed():
    upper = BALL.vertices[BALL.faces].mean(axis=1)[:, 2] > -0.9
    bowl = Mesh(BALL.vertices, BALL.faces[upper])
    large, small = icosphere(4), moved(blob(0, 3), 5)
    mesh = together(moved(bowl, -5), small, large, moved(box(), 9))
    for stored in (mesh, soup(mesh)):
        found = large_parts(stored)
        assert [(len(part.mesh.faces), part.closed) for part in found] == [
            (len(large.faces), True),
            (len(small.faces), True),
            (len(bowl.faces), False),
        ]
        assert signed_volume(found[0].mesh) == pytest.approx(signed_volume(large))
    assert large_parts(large) == large_parts(soup(large)) == []


def test_kernels_number_and_measure_parts_as_scipy_and_each_mesh_alone_do():
    meshes = [blob(0, 3), moved(box(), 5), moved(inside_out(blob(1, 2)), 9)]
    mesh = together(*meshes)
    faces = np.random.default_rng(0).permutation(mesh.faces)
    part, parts = face_parts(len(mesh.vertices), faces)
    links = coo_array((np.ones(2 * len(faces)), (faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel())))
    count, label = connected_components(links, directed=False)
    assert parts == count == 3
    assert len(np.unique(np.column_stack([part, label[faces[:, 0]]]), axis=0)) == 3
    volumes, closed = part_volumes(mesh.vertices, faces, part, parts)
    assert sorted(volumes) == pytest.approx(sorted(map(signed_volume, meshes)), rel=1e-9)
    assert closed.all()
    _, opened = part_volumes(mesh.vertices, faces[1:], *face_parts(len(mesh.vertices), faces[1:]))
    assert np.count_nonzero(opened) == 2
