"""The renderer against analytic shapes and against its plain numpy twin."""

import numpy as np
import pytest
from shapes import blob, icosphere, inside_out

from wm3d.bench import kernels
from wm3d.bench.render import View, rasterize_reference, render, upright
from wm3d.scanner import VertexPca


def frontal(size: int = 80) -> View:
    """Unit sphere from the positive z axis, a tenth of the picture left free on each side."""
    return View(np.eye(3), np.zeros(3), 0.4 * size, (size, size))


def test_depth_of_a_sphere_is_its_equation() -> None:
    view = frontal()
    depth = render(icosphere(5), view).depth
    y, x = (np.mgrid[:80, :80] + 0.5 - 40) / view.scale
    inside = x**2 + y**2 < 0.9
    # nearest of 3×3 rays a pixel: it may lie a third of a pixel nearer to the middle
    slope = np.hypot(x, y) / np.sqrt(1 - np.minimum(x**2 + y**2, 0.9)) * np.sqrt(2) / 3 / view.scale
    error = depth[inside] - np.sqrt(1 - (x**2 + y**2)[inside])
    assert np.all(error > -2e-3)
    assert np.all(error < slope[inside] + 5e-3)
    assert np.all(np.isneginf(depth[x**2 + y**2 > 1.05**2]))


def test_kernel_agrees_with_its_plain_twin() -> None:
    mesh, view = blob(1, subdivisions=2), frontal(48)
    points = view.project(mesh.vertices)
    face, depth, weights = kernels.rasterize(points, mesh.faces, 48, 48)
    wanted_face, wanted_depth, wanted_weights = rasterize_reference(points, mesh.faces, 48, 48)
    np.testing.assert_array_equal(face, wanted_face)
    np.testing.assert_allclose(depth, wanted_depth, atol=1e-12)
    np.testing.assert_allclose(weights, wanted_weights, atol=1e-9)


def test_projection_puts_a_vertex_where_the_picture_shows_it() -> None:
    mesh = icosphere(4)
    view = View.around(mesh.vertices, np.eye(3), (60, 90))
    colors = np.tile([0.0, 0.0, 1.0], (len(mesh.vertices), 1))
    spot = np.linalg.norm(mesh.vertices - [0.6, 0.64, 0.48], axis=1) < 0.15
    colors[spot] = [1.0, 0.0, 0.0]
    image = render(mesh, view, colors).image
    x, y, _ = view.project([0.6, 0.64, 0.48])
    assert image[int(y), int(x), 0] > 5 * image[int(y), int(x), 2]
    mirrored = image[int(y), int(90 - x)]
    assert mirrored[2] > 5 * mirrored[0]


def test_points_behind_the_model_are_hidden() -> None:
    picture = render(icosphere(4), frontal())
    points = [[0.2, 0.1, 1.2], [0.2, 0.1, 0.5], [0.2, 0.1, -1.2], [1.15, 0.1, -1.2], [9.0, 9.0, -1.0]]
    np.testing.assert_array_equal(picture.hides(points), [False, True, True, False, False])


def test_picture_does_not_depend_on_the_winding() -> None:
    mesh, view = blob(2, subdivisions=3), frontal()
    np.testing.assert_allclose(render(mesh, view).image, render(inside_out(mesh), view).image, atol=1e-12)


@pytest.mark.parametrize("turn", [0.0, 130.0])
def test_upright_views_are_not_mirrored_and_show_the_asked_column(turn: float) -> None:
    mesh = blob(3, subdivisions=3)
    cylinder = VertexPca()(mesh)
    axes = upright(cylinder, turn, tilt=10)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1)
    _, s2, s3 = cylinder.axes
    outward = np.cos(np.radians(turn)) * s3 + np.sin(np.radians(turn)) * s2  # e_v of eq. 4
    assert axes[2] @ outward == pytest.approx(np.cos(np.radians(10)))
    assert axes[1] @ cylinder.axes[0] > 0.9
