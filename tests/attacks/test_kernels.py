"""Signed distance on a grid: equal to brute force, whatever way the faces lie and are wound."""

import numpy as np
import pytest
from shapes import blob, box, icosphere, inside_out, rotation
from trimesh.triangles import closest_point

from wm3d.attacks.voxels import MarchingCubes, signed_distance
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, is_closed, signed_volume


def brute_force(mesh, nodes):
    """Distance to the nearest face by trimesh; winding number by solid angles (van Oosterom, Strackee)."""
    triangles = mesh.vertices[mesh.faces]
    distance, winding = np.empty(len(nodes)), np.empty(len(nodes))
    for i, node in enumerate(nodes):
        feet = closest_point(triangles, np.broadcast_to(node, (len(triangles), 3)))
        distance[i] = np.linalg.norm(feet - node, axis=1).min()
        corners = triangles - node
        a, b, c = np.moveaxis(corners / np.linalg.norm(corners, axis=2, keepdims=True), 1, 0)
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        dots = (np.einsum("ij,ij->i", *pair) for pair in ((a, b), (b, c), (c, a)))
        winding[i] = 2 * np.arctan2(volume, 1 + sum(dots)).sum() / (4 * np.pi)
    return distance, winding


NESTED = Mesh(
    np.vstack([icosphere(2).vertices, 0.5 * icosphere(1).vertices]),
    np.vstack([icosphere(2).faces, len(icosphere(2).vertices) + inside_out(icosphere(1)).faces]),
    name="hollow",
)


@pytest.mark.parametrize("mesh", [box((3, 2, 1)), blob(4, 3), inside_out(blob(4, 3)), NESTED])
def test_distance_and_sign_are_those_of_brute_force(mesh):
    cell, origin = mesh.diagonal / 24, mesh.vertices.min(axis=0) - 0.06 * mesh.diagonal
    field = signed_distance(mesh, origin, cell)
    rng = np.random.default_rng(1)
    index = rng.integers(0, field.shape, (300, 3))
    distance, winding = brute_force(mesh, origin + cell * index)
    np.testing.assert_allclose(np.abs(field[tuple(index.T)]), np.minimum(distance / cell, 1), atol=1e-12)
    clear = distance > 1e-9
    np.testing.assert_array_equal((field[tuple(index.T)] < 0)[clear], (np.abs(winding) > 0.5)[clear])
    assert (np.abs(winding) > 0.5).sum() > 20


def test_nodes_on_faces_edges_and_corners_do_not_leak():
    # every face of the box lies in a plane of nodes, every edge and corner on a line of them
    mesh = box((4, 4, 4))
    field = signed_distance(mesh, np.full(3, -4.0), 1.0)
    inside = np.argwhere(field < 0)
    np.testing.assert_array_equal(inside.min(axis=0), [3, 3, 3])
    np.testing.assert_array_equal(inside.max(axis=0), [5, 5, 5])
    assert len(inside) == 27
    assert (field == 0).sum() == 5**3 - 3**3


def test_faces_without_area_are_as_near_as_their_edges():
    mesh = blob(4, 2)
    start, end = mesh.faces[0, :2]
    needle = np.array([[start, end, end], [end, start, start]])
    with_needles = Mesh(mesh.vertices, np.vstack([mesh.faces, needle]))
    origin = mesh.vertices.min(axis=0) - 0.1
    np.testing.assert_array_equal(
        signed_distance(with_needles, origin, 0.1), signed_distance(mesh, origin, 0.1)
    )


def test_marching_cubes_keep_a_cavity_and_a_turned_box():
    hollow = MarchingCubes(cells=48)(NESTED, np.random.default_rng(0))
    assert is_closed(hollow)
    assert signed_volume(hollow) == pytest.approx(signed_volume(NESTED), rel=0.01)
    turned = Mesh(box((3, 2, 1)).vertices @ rotation(3).T, box().faces)
    result = MarchingCubes(cells=96)(turned, np.random.default_rng(0))
    assert signed_volume(result) == pytest.approx(6, rel=0.01)


def test_a_grid_too_coarse_for_a_plate_is_refused():
    plate = Mesh(box((10, 10, 1e-3)).vertices, box().faces, name="plate")
    with pytest.raises(Wm3dError, match=r"^plate: marching-cubes 8 finds no node inside; use more cells\.$"):
        MarchingCubes(cells=8)(plate, np.random.default_rng(0))
