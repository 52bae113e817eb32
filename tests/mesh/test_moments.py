"""Moments: analytic solids, plain numpy twins, and how they move with the mesh."""

import numpy as np
import pytest
from shapes import blob, box, icosphere, inside_out, rotation, tetrahedron, uv_cylinder

from wm3d.errors import Wm3dError
from wm3d.mesh import (
    Mesh,
    is_balanced,
    is_closed,
    orientation,
    signed_volume,
    surface_area,
    vertex_moments,
    volume_moments,
)

CLOSED = [tetrahedron(), box((1, 2, 3)), icosphere(3), uv_cylinder(), blob(1, 4)]


def without_faces(mesh: Mesh, *dropped: int) -> Mesh:
    return Mesh(mesh.vertices, np.delete(mesh.faces, dropped, axis=0), name=mesh.name)


def corners(mesh: Mesh, apex) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return tuple((mesh.vertices[mesh.faces] - apex).swapaxes(0, 1))


def test_vertex_moments_of_a_box_are_a_quarter_of_the_squared_extents():
    mean, covariance = vertex_moments(box((1, 2, 3)))
    assert mean.tolist() == [0, 0, 0]
    assert np.array_equal(covariance, np.diag([1, 4, 9]) / 4)


def test_vertex_moments_count_unused_vertices_as_the_paper_does():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [3, 3, 4]], [[0, 1, 2]])
    assert vertex_moments(mesh).mean.tolist() == [1, 1, 1]


@pytest.mark.parametrize("mesh", [*CLOSED, without_faces(blob(2, 4), 5, 6, 7)], ids=lambda mesh: mesh.name)
def test_kernels_agree_with_plain_numpy(mesh):
    mean, covariance = vertex_moments(mesh)
    np.testing.assert_allclose(mean, mesh.vertices.mean(axis=0), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(covariance, np.cov(mesh.vertices.T, bias=True), rtol=1e-12, atol=1e-14)

    a, b, c = corners(mesh, mesh.vertices.mean(axis=0))
    normals = np.cross(b - a, c - a)
    assert surface_area(mesh) == pytest.approx(np.linalg.norm(normals, axis=1).sum() / 2, rel=1e-12)

    det = np.einsum("ij,ij->i", a, np.cross(b, c))
    s = a + b + c
    first = np.einsum("i,ij->j", det, s) / 24
    second = sum(np.einsum("i,ij,ik->jk", det, x, x) for x in (s, a, b, c)) / 120
    volume = det.sum() / 6
    assert signed_volume(mesh) == pytest.approx(volume, rel=1e-12)
    found = volume_moments(mesh)
    assert found.volume == signed_volume(mesh)
    offset = first / volume
    np.testing.assert_allclose(found.centroid, mesh.vertices.mean(axis=0) + offset, atol=1e-12)
    np.testing.assert_allclose(found.covariance, second / volume - np.outer(offset, offset), atol=1e-12)


def test_volume_moments_of_box_and_tetrahedron_are_exact():
    volume, centroid, covariance = volume_moments(box((1, 2, 3)))
    assert volume == pytest.approx(6, rel=1e-15)
    np.testing.assert_allclose(centroid, 0, atol=1e-16)
    np.testing.assert_allclose(covariance, np.diag([1, 4, 9]) / 12, atol=1e-15)

    volume, centroid, covariance = volume_moments(tetrahedron())
    assert volume == pytest.approx(1 / 6, rel=1e-15)
    np.testing.assert_allclose(centroid, [0.25] * 3, atol=1e-15)
    # corner simplex: variance 3/80, covariance -1/80
    np.testing.assert_allclose(covariance, (4 * np.eye(3) - 1) / 80, atol=1e-15)


def test_ellipsoid_moments_converge_to_the_analytic_ones():
    semi_axes = np.array([1.0, 0.7, 0.4])
    errors = []
    for subdivisions in (3, 4, 5):
        sphere = icosphere(subdivisions)
        volume, _, covariance = volume_moments(sphere.with_vertices(sphere.vertices * semi_axes))
        expected = 4 / 3 * np.pi * semi_axes.prod()
        errors.append([abs(volume / expected - 1), *np.abs(np.diag(covariance) / (semi_axes**2 / 5) - 1)])
    ratio = np.array(errors[:-1]) / np.array(errors[1:])
    np.testing.assert_allclose(ratio, 4, rtol=0.05)  # second order in the edge length
    assert np.max(errors[-1]) < 2e-3


def test_cylinder_area_and_volume_are_those_of_the_prism():
    n, radius, height = 48, 0.5, 3.0
    mesh = uv_cylinder(radius, height, around=n, along=7)
    base = n / 2 * radius**2 * np.sin(2 * np.pi / n)
    side = 2 * n * radius * np.sin(np.pi / n) * height
    assert signed_volume(mesh) == pytest.approx(base * height, rel=1e-12)
    assert surface_area(mesh) == pytest.approx(2 * base + side, rel=1e-12)


@pytest.mark.parametrize("mesh", [blob(3, 4), without_faces(blob(3, 4), *range(40))], ids=["closed", "open"])
def test_moments_move_with_the_mesh(mesh):
    turn, shift, scale = rotation(8), np.array([1e4, -2e4, 3e4]), 2.5
    moved = mesh.with_vertices(scale * mesh.vertices @ turn.T + shift)
    assert signed_volume(moved) == pytest.approx(scale**3 * signed_volume(mesh), rel=1e-9)
    assert surface_area(moved) == pytest.approx(scale**2 * surface_area(mesh), rel=1e-9)
    before, after = volume_moments(mesh), volume_moments(moved)
    pairs = [
        ((before.centroid, before.covariance), (after.centroid, after.covariance)),
        (vertex_moments(mesh), vertex_moments(moved)),
    ]
    for (mean, covariance), (moved_mean, moved_covariance) in pairs:
        np.testing.assert_allclose(moved_mean, scale * turn @ mean + shift, rtol=0, atol=1e-9)
        np.testing.assert_allclose(moved_covariance, scale**2 * turn @ covariance @ turn.T, rtol=0, atol=1e-9)


@pytest.mark.parametrize("mesh", CLOSED, ids=lambda mesh: mesh.name)
def test_winding_flips_volume_and_orientation_and_nothing_else(mesh):
    flipped = inside_out(mesh)
    assert orientation(mesh) == 1
    assert orientation(flipped) == -1
    assert signed_volume(flipped) == pytest.approx(-signed_volume(mesh), rel=1e-14)
    np.testing.assert_allclose(volume_moments(flipped).centroid, volume_moments(mesh).centroid, atol=1e-14)
    np.testing.assert_allclose(
        volume_moments(flipped).covariance, volume_moments(mesh).covariance, atol=1e-14
    )


def test_open_box_loses_the_cone_over_its_hole_and_keeps_its_orientation():
    open_box = without_faces(box(), 0, 1)
    assert signed_volume(open_box) == pytest.approx(1 - 1 / 6, rel=1e-15)
    assert orientation(open_box) == 1
    assert orientation(inside_out(open_box)) == -1
    assert not is_closed(open_box)


def test_closed_means_one_opposite_for_each_directed_edge():
    assert all(is_closed(mesh) for mesh in CLOSED)
    cube = box()
    assert not is_closed(without_faces(cube, 4))
    one_flipped = cube.faces.copy()
    one_flipped[3] = one_flipped[3, ::-1]
    assert not is_closed(Mesh(cube.vertices, one_flipped))
    assert not is_closed(Mesh(cube.vertices, np.vstack([cube.faces, cube.faces])))


@pytest.mark.parametrize("seed", range(5))
def test_balanced_means_that_directed_edges_and_their_opposites_are_the_same(seed):
    rng = np.random.default_rng(seed)
    faces = rng.integers(0, 50_000, size=(200, 3))  # below, some occur twice, some are points
    faces = np.vstack([faces, faces[:20], faces[:5, [0, 0, 0]], faces[:5, [0, 0, 1]]])
    backwards = faces[:, ::-1]
    vertices = rng.normal(size=(50_000, 3))
    for chosen in (np.vstack([faces, backwards]), np.vstack([faces, backwards[1:]]), faces):
        mesh = Mesh(vertices, rng.permutation(chosen))
        directed = np.vstack([mesh.faces[:, [i, (i + 1) % 3]] for i in range(3)])
        same = np.array_equal(*(np.sort(edges @ [50_000, 1]) for edges in (directed, directed[:, ::-1])))
        assert is_balanced(mesh) == same == (len(chosen) == 2 * len(faces))


def test_sheet_has_no_volume_moments():
    sheet = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], name="sheet")
    assert orientation(sheet) == 1
    with pytest.raises(Wm3dError, match="sheet: its faces enclose no volume"):
        volume_moments(sheet)


def test_real_meshes_have_the_known_topology(data_mesh):
    assert is_closed(data_mesh("igea"))
    assert orientation(data_mesh("igea")) == 1
    assert is_closed(data_mesh("horse"))
    assert orientation(data_mesh("horse")) == -1
    assert not is_closed(data_mesh("bunny-zipper"))
    assert orientation(data_mesh("bunny-zipper")) == 1
