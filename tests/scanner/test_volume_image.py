"""The volume image: solids whose cells are known, its numpy twin, and what must not change it."""

import sys

import numpy as np
import pytest
from shapes import blob, box, icosphere, inside_out, uv_cylinder

from wm3d.attacks import Subdivide
from wm3d.mesh import Mesh, signed_volume, surface_area, vertex_normals
from wm3d.scanner.affine import principal_frame
from wm3d.scanner.volume import (
    VolumeImage,
    kernels,
    volume_image,
    volume_image_reference,
    volume_jacobian,
)

GRID = (32, 24)
COARSE = principal_frame(blob(0, 3)).posed(blob(0, 3)), blob(0, 3).faces
FINE = principal_frame(blob(0, 4)).posed(blob(0, 4)), blob(0, 4).faces
LOW, HEIGHT = -2.0, 4.0  # the blobs reach from −1.8 to 1.7

INWARD = -1
"""`outward` of a mesh that `about_z` has put there, where outward faces look inward: a frame of the scanner
mirrors, `about_z` only turns."""


def about_z(mesh: Mesh) -> np.ndarray:
    return np.column_stack([mesh.vertices[:, 2], mesh.vertices[:, 0], mesh.vertices[:, 1]])


def of(posed: np.ndarray, faces: np.ndarray, outward: int = 1) -> VolumeImage:
    # through Mesh, so that the kernel is compiled for one kind of arrays
    return volume_image(posed, Mesh(posed, faces).faces, GRID, LOW, HEIGHT, outward)


def finely(posed: np.ndarray, faces: np.ndarray, outward: int = 1) -> VolumeImage:
    """The image by eight times as many parts along a side, whose own error is far below that of `of`."""
    columns, rows = GRID
    volumes, areas, _ = kernels.deposit(
        posed, Mesh(posed, faces).faces, rows, columns, LOW, HEIGHT, 8.0, sys.maxsize
    )
    return VolumeImage(-outward * volumes, areas)


def relative(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.linalg.norm(found - expected) / np.linalg.norm(expected))


@pytest.mark.parametrize("grid", [(8, 8), GRID, (96, 64)])
def test_image_adds_up_to_the_solid_and_its_surface(grid):
    # the weights of the cells add up to 1 from half a row above the lower end to half a row below the upper
    posed, faces = COARSE
    image = volume_image(posed, faces, grid, -2.5, 5.0, 1)
    assert image.volumes.shape == image.areas.shape == grid[::-1]
    # s1, s2, s3 are left-handed, so the solid in the frame has a negative volume
    assert image.volumes.sum() == pytest.approx(-signed_volume(Mesh(posed, faces)), rel=1e-12)
    assert image.areas.sum() == pytest.approx(surface_area(Mesh(posed, faces)), rel=1e-12)
    assert image.volumes.sum() > 0
    assert (image.areas >= 0).all()


def test_faces_that_span_the_cylinder_are_read_at_no_more_points_than_time_allows(monkeypatch):
    rng = np.random.default_rng(4)
    soup, grid = Mesh(rng.uniform(-1.0, 1.0, (600, 3)), np.arange(600).reshape(200, 3)), (128, 96)
    whole = volume_image(soup.vertices, soup.faces, grid, LOW, HEIGHT, 1)
    points, deposit = [], kernels.deposit

    def counted(*arguments):
        dealt = deposit(*arguments)
        points.append(dealt[-1])
        return dealt

    monkeypatch.setattr(kernels, "deposit", counted)
    monkeypatch.setattr("wm3d.scanner.volume.image.MOST_POINTS", 40_000)
    coarse = volume_image(soup.vertices, soup.faces, grid, LOW, HEIGHT, 1)
    assert min(points[:2]) > 5 * 40_000
    assert max(points[2:]) < 2 * 40_000
    assert coarse.volumes.sum() == pytest.approx(whole.volumes.sum(), rel=1e-9)
    assert coarse.areas.sum() == pytest.approx(surface_area(soup), rel=1e-9)
    assert relative(coarse.areas, whole.areas) < 0.2


@pytest.mark.parametrize("first", [0, 1, 2])
def test_corners_on_the_axis_have_no_angle_of_their_own(first):
    cone = uv_cylinder(along=1)
    tip = np.isclose(cone.vertices[:, 2], 1.0)
    posed = about_z(Mesh(np.where(tip[:, None], [0.0, 0.0, 1.0], cone.vertices), cone.faces))
    image = of(posed, np.roll(cone.faces, first, axis=1))
    for seen in (image.volumes, image.areas):  # a turn by one column leaves the cone as it is
        np.testing.assert_allclose(seen, np.roll(seen, 1, axis=1), rtol=1e-9, atol=1e-12)
    assert image.areas.sum() == pytest.approx(surface_area(Mesh(posed, cone.faces)), rel=1e-12)


def test_rows_beyond_the_cylinder_are_left_out():
    posed, faces = COARSE
    whole = volume_image(posed, faces, GRID, LOW, HEIGHT, 1)
    upper = volume_image(posed, faces, (32, 12), LOW + HEIGHT / 2, HEIGHT / 2, 1)
    np.testing.assert_allclose(upper.volumes, whole.volumes[12:], atol=1e-15)
    np.testing.assert_allclose(upper.areas, whole.areas[12:], atol=1e-15)


@pytest.mark.parametrize("outward", [1, -1])
def test_kernel_agrees_with_its_numpy_twin(outward):
    posed, faces = COARSE
    expected = volume_image_reference(posed, faces, GRID, LOW, HEIGHT, outward)
    # three points a part, one part a cell: 0.3 % of the image; eight parts a cell leave the error of the twin
    for image, most in ((of(posed, faces, outward), 3e-3), (finely(posed, faces, outward), 3e-4)):
        assert relative(image.volumes, expected.volumes) < most
        assert relative(image.areas, expected.areas) < most
    assert np.sign(expected.volumes.sum()) == outward


def test_cylinder_about_the_axis_has_equal_cells():
    around, height = 96, 4.0
    mesh = uv_cylinder(1.0, height, around=around, along=30)
    columns, rows = 24, 16
    image = volume_image(about_z(mesh), mesh.faces, (columns, rows), -height / 2, height, INWARD)
    volume = around / 2 * np.sin(2 * np.pi / around) * height / (rows * columns)
    side = 2 * around * np.sin(np.pi / around) * height / (rows * columns)
    # caps have no flux across the axis, and the first and last row lose what they deal out beyond the ends:
    # ∫ (1 + cos πx)/2 over −½ < x < 1 is ¾ + 1/(2π)
    end = 0.75 + 1 / (2 * np.pi)
    expected = np.ones((rows, 1))
    expected[[0, -1]] = end
    np.testing.assert_allclose(image.volumes / volume, np.broadcast_to(expected, (rows, columns)), rtol=3e-3)
    np.testing.assert_allclose(image.areas[1:-1] / side, 1, rtol=3e-3)


def test_sphere_about_the_axis_has_the_cells_of_a_ball():
    # over |x| < 1, (1 + cos πx)/2 has the integral 1 and the second moment 1/3 − 2/π²; a slice of the ball at
    # the height h has the area π (1 − h²)
    columns, rows = 24, 16
    mesh = icosphere(5)
    image = volume_image(about_z(mesh), mesh.faces, (columns, rows), -1.2, 2.4, INWARD)
    step = 2.4 / rows
    height = -1.2 + (np.arange(rows) + 0.5) * step
    whole = np.abs(height) + step < 1
    expected = np.pi / columns * ((1 - height**2) * step - step**3 * (1 / 3 - 2 / np.pi**2))
    np.testing.assert_allclose(image.volumes[whole] / expected[whole, None], 1, atol=2e-3)
    assert whole.sum() == 12


def test_every_surface_behind_a_cell_counts():
    outer, inner = icosphere(4), inside_out(icosphere(4, 0.6))
    inside = about_z(inner) + np.array([0.1, 0.05, 0])
    vertices = np.vstack([about_z(outer), inside])
    faces = np.vstack([outer.faces, inner.faces + len(outer.vertices)])
    hollow = of(vertices, faces, INWARD)
    ball = of(about_z(outer), outer.faces, INWARD)
    void = of(inside, inner.faces, -INWARD)
    np.testing.assert_allclose(hollow.volumes, ball.volumes - void.volumes, atol=1e-15)
    np.testing.assert_allclose(hollow.areas, ball.areas + void.areas, atol=1e-15)


@pytest.mark.parametrize("columns", [1, 5])
def test_turn_about_the_axis_rolls_the_columns(columns):
    posed, faces = COARSE
    angle = 2 * np.pi * columns / GRID[0]  # from s3 to s2
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = posed @ np.array([[1, 0, 0], [0, cosine, sine], [0, -sine, cosine]]).T
    # into how many parts a face is cut depends on its extent along s2 and s3, so on the turn
    for read, most in ((of, 3e-3), (finely, 1e-4)):
        expected = np.roll(read(posed, faces).volumes, columns, axis=1)
        assert relative(read(turned, faces).volumes, expected) < most


def test_move_along_the_axis_shifts_the_rows():
    posed, faces = COARSE
    moved = of(posed + np.array([2 * HEIGHT / GRID[1], 0, 0]), faces)
    np.testing.assert_allclose(moved.volumes[2:], of(posed, faces).volumes[:-2], atol=1e-14)


def test_triangulation_matters_no_more_than_the_quadrature():
    posed, faces = COARSE
    halves = Subdivide(rule="midpoint")(Mesh(posed, faces), np.random.default_rng(0))
    for read, most in ((of, 3e-3), (finely, 1e-4)):
        whole, parts = read(posed, faces), read(halves.vertices, halves.faces)
        assert relative(parts.volumes, whole.volumes) < most
        assert relative(parts.areas, whole.areas) < most


def test_surface_moved_along_its_normals_adds_its_area_times_the_move():
    posed, faces = FINE
    normals = vertex_normals(Mesh(posed, faces))
    for read, delta, most in ((of, 1e-2, 0.02), (finely, 1e-2, 0.01), (finely, 1e-3, 0.002)):
        here = read(posed, faces)
        gained = read(posed + delta * normals, faces).volumes - here.volumes
        assert relative(gained, delta * here.areas) < most


def test_winding_and_sign_go_together():
    posed, faces = COARSE
    outward = of(posed, faces, 1)
    # the three points of a part are the same from whichever corner they are counted
    inward = of(posed, faces[:, ::-1], -1)
    np.testing.assert_allclose(inward.volumes, outward.volumes, atol=1e-15)
    np.testing.assert_allclose(inward.areas, outward.areas, atol=1e-15)
    np.testing.assert_array_equal(of(posed, faces, -1).volumes, -outward.volumes)


def test_order_of_faces_and_vertices_does_not_matter():
    posed, faces = COARSE
    rng = np.random.default_rng(0)
    order = rng.permutation(len(posed))
    renumbered = np.argsort(order)[faces][rng.permutation(len(faces))]
    image, expected = of(posed[order], renumbered), of(posed, faces)
    np.testing.assert_allclose(image.volumes, expected.volumes, atol=1e-15)
    np.testing.assert_allclose(image.areas, expected.areas, atol=1e-15)


def test_faces_without_an_area_add_nothing():
    posed, faces = COARSE
    on_axis = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.5, 0, 0]])
    with_slivers = np.vstack([faces, [[0, 0, 1], [2, 2, 2]], len(posed) + np.array([[0, 1, 2]])])
    image = of(np.vstack([posed, on_axis]), with_slivers)
    # they shift where the halves are that are summed apart, and with it a last bit
    np.testing.assert_allclose(image.volumes, of(posed, faces).volumes, rtol=1e-14)
    np.testing.assert_allclose(image.areas, of(posed, faces).areas, rtol=1e-14)


@pytest.mark.parametrize("outward", [1, -1])
def test_jacobian_is_what_the_image_changes_by_for_small_moves(outward):
    posed, faces = FINE
    faces = Mesh(posed, faces[:, ::-1] if outward < 0 else faces).faces
    normals = posed / np.linalg.norm(posed, axis=1, keepdims=True)
    jacobian = volume_jacobian(posed, faces, normals, GRID, LOW, HEIGHT, outward)
    along = np.sin(3 * posed[:, 0]) + np.cos(2 * posed[:, 1])
    step = 1e-5
    ahead, behind = (
        volume_image_reference(
            posed + sign * step * along[:, None] * normals, faces, GRID, LOW, HEIGHT, outward
        )
        for sign in (1, -1)
    )
    slope = (ahead.volumes - behind.volumes) / (2 * step)
    assert relative((jacobian @ along).reshape(slope.shape), slope) < 0.03


LARGE_FACES = about_z(box((1.0, 1.3, 1.7))), box().faces


@pytest.mark.parametrize(("posed", "faces"), [COARSE, LARGE_FACES], ids=["blob", "box"])
def test_jacobian_adds_up_to_the_flux_through_the_faces(posed, faces):
    # within the rows, so that every face is dealt out in full
    directions = np.random.default_rng(3).normal(size=posed.shape)
    jacobian = volume_jacobian(posed, Mesh(posed, faces).faces, directions, (64, 48), -2.5, 5.0, 1)
    a, b, c = (posed[faces[:, k]] for k in range(3))
    flux = -np.einsum("fi,fki->fk", np.cross(b - a, c - a) / 6, directions[faces])
    expected = np.bincount(faces.ravel(), flux.ravel(), len(posed))
    np.testing.assert_allclose(jacobian.sum(axis=0), expected, rtol=0, atol=1e-12)
