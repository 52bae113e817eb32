"""Vertices follow a change of the range image: eq. 12 by another route, and what it must do on its own."""

import numpy as np
import pytest
from shapes import blob, inside_out

from wm3d.scanner import VertexPca, scan
from wm3d.schemes import kernels
from wm3d.schemes.movement import move_vertices, radial_moves_reference, radial_normals

MESH = blob(1, 4)
CYLINDER = VertexPca()(MESH)
POSED = CYLINDER.posed(MESH)
NORMALS = radial_normals(MESH, POSED)


@pytest.mark.parametrize("grid", [(36, 40), (35, 41), (1, 1), (2, 2), (3, 1)])
@pytest.mark.parametrize("shift", [(0, 0), (0.3, -0.4)], ids=["about the axis", "beside the axis"])
def test_kernel_equals_numpy_twin(grid, shift):
    columns, rows = grid
    rng = np.random.default_rng(rows)
    posed = POSED + np.array([0.0, *shift])
    normals = kernels.radial_normals(posed, MESH.faces, 1)
    arguments = (posed, normals, rng.normal(size=(rows, columns)), CYLINDER.hmin, CYLINDER.height)
    expected = radial_moves_reference(*arguments)
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(kernels.radial_moves(*arguments), expected, rtol=0, atol=1e-11)


def test_kernel_equals_twin_on_the_grid_points_the_axis_and_the_ends():
    # angles at and between grid points of four columns, the axis itself, heights from end to end
    plane = np.array([[x, y] for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)])
    posed = np.array([[height, *point] for height in np.linspace(0, 4, 9) for point in plane])
    change = np.random.default_rng(2).normal(size=(4, 4))
    for sign in (1.0, -1.0):
        arguments = (posed, sign * posed[:, 1:], change, 0.0, 4.0)
        np.testing.assert_allclose(
            kernels.radial_moves(*arguments), radial_moves_reference(*arguments), rtol=0, atol=1e-14
        )


def test_normals_are_area_weighted_and_point_outwards_whatever_the_winding():
    corners = MESH.vertices[MESH.faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    expected = np.zeros(MESH.vertices.shape)
    for k in range(3):
        np.add.at(expected, MESH.faces[:, k], area)
    expected = expected @ CYLINDER.axes[1:].T
    for mesh in (MESH, inside_out(MESH)):
        np.testing.assert_allclose(radial_normals(mesh, POSED), expected, rtol=0, atol=1e-15)
    assert (np.einsum("ij,ij->i", expected, POSED[:, 1:]) > 0).mean() > 0.98  # nearly star-shaped


def test_weights_are_a_partition_of_unity():
    # a constant change moves every vertex between the first and the last row by just that, straight inwards
    rows, step = 40, 0.003
    moved = move_vertices(MESH, POSED, NORMALS, CYLINDER, np.full((rows, 36), step))
    planes = CYLINDER.planes(rows)
    between = (POSED[:, 0] >= planes[0]) & (POSED[:, 0] <= planes[-1])
    change = CYLINDER.posed(moved) - POSED
    inwards = -step * POSED[:, 1:] / np.linalg.norm(POSED[:, 1:], axis=1, keepdims=True)
    np.testing.assert_allclose(change[:, 0], 0, atol=1e-15)
    np.testing.assert_allclose(change[between, 1:], inwards[between], rtol=0, atol=1e-15)
    assert (np.linalg.norm(change[~between, 1:], axis=1) < step).all()


def test_a_wall_that_faces_the_axis_is_moved_by_the_rays_from_the_other_side():
    # the same vertices with normals towards the axis: the rays that see them start at the opposite angle
    change = np.zeros((1, 4))
    change[0, 0] = 0.1  # column 0 starts at +s3
    posed = np.array([[0.5, 0.0, 1.0], [0.5, 0.0, -1.0]])  # at +s3 and at −s3
    outwards = posed[:, 1:]
    seen = kernels.radial_moves(posed, outwards, change, 0.0, 1.0)
    np.testing.assert_allclose(seen, [[0, -0.1], [0, 0]], atol=1e-16)
    seen = kernels.radial_moves(posed, -outwards, change, 0.0, 1.0)
    np.testing.assert_allclose(seen, [[0, 0], [0, -0.1]], atol=1e-16)


def test_scanner_sees_the_change_that_was_asked_for():
    mesh = blob(2, 6)
    cylinder = VertexPca()(mesh)
    grid = (36, 40)
    before = scan(mesh, grid, cylinder).ranges
    wanted = 1e-3 * cylinder.radius * np.random.default_rng(3).normal(size=before.shape)
    posed = cylinder.posed(mesh)
    moved = move_vertices(mesh, posed, radial_normals(mesh, posed), cylinder, wanted)
    got = scan(moved, grid, cylinder).ranges - before
    inner = slice(2, -2)  # near the poles many columns share few vertices
    assert np.corrcoef(wanted[inner].ravel(), got[inner].ravel())[0, 1] > 0.95
    slope = np.sum(wanted[inner] * got[inner]) / np.sum(wanted[inner] ** 2)
    assert slope == pytest.approx(1, abs=0.1)
