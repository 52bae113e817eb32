"""The paper's pose: axes, signs and cylinder by their definitions, and meshes that have none."""

import numpy as np
import pytest
from shapes import blob, box, icosphere, rotation, uv_cylinder

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.scanner import Cylinder, VertexPca, scan


@pytest.mark.parametrize("seed", range(5))
def test_axes_signs_and_cylinder_follow_their_definitions(seed):
    mesh = blob(seed, 3)
    cylinder = VertexPca()(mesh)
    s1, s2, s3 = cylinder.axes
    np.testing.assert_allclose(cylinder.axes @ cylinder.axes.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(s3, np.cross(s2, s1), atol=1e-14)
    np.testing.assert_allclose(cylinder.center, mesh.vertices.mean(axis=0), atol=1e-14)

    posed = (mesh.vertices - cylinder.center) @ cylinder.axes.T
    np.testing.assert_allclose(cylinder.posed(mesh), posed, atol=1e-14)
    moments = np.cov(posed.T, bias=True)
    np.testing.assert_allclose(moments, np.diag(np.diag(moments)), atol=1e-14)
    assert moments[0, 0] > moments[1, 1] > moments[2, 2]
    for k in (0, 1):  # eq. 3
        above, below = posed[posed[:, k] > 0], posed[posed[:, k] < 0]
        assert np.mean(np.sum(above**2, axis=1)) > np.mean(np.sum(below**2, axis=1))

    across = np.hypot(posed[:, 1], posed[:, 2])  # eqs. 1 and 2
    expected = [across.max(), posed[:, 0].min(), posed[:, 0].max()]
    np.testing.assert_allclose([cylinder.radius, cylinder.hmin, cylinder.hmax], expected, rtol=1e-14)


def test_egg_has_the_axes_of_its_ellipsoid_towards_its_longer_ends():
    sphere = icosphere(3)
    egg = Mesh(sphere.vertices * [3, 2, 1] * (1 + 0.2 * sphere.vertices * [1, -1, 0]), sphere.faces)
    np.testing.assert_allclose(VertexPca()(egg).axes, [[1, 0, 0], [0, -1, 0], [0, 0, 1]], atol=0.01)


def flattened(mesh: Mesh, scale: tuple[float, float, float], name: str) -> Mesh:
    return Mesh(mesh.vertices * scale @ rotation(4).T + [5, 6, 7], mesh.faces, name=name)


@pytest.mark.parametrize(
    ("mesh", "sentence"),
    [
        (icosphere(2), "two principal moments of the vertices are equal"),
        (box(), "two principal moments of the vertices are equal"),
        (uv_cylinder(1, 5), "two principal moments of the vertices are equal"),
        (box((3, 2, 1)), "is symmetric along its principal axis s1"),
        # these have vertices in the mirror planes, which rounding must not deal out to the sides
        (flattened(icosphere(3), (3, 2, 1), "ellipsoid"), "is symmetric along its principal axis s1"),
        (flattened(uv_cylinder(), (3, 2, 9), "tube"), "is symmetric along its principal axis s1"),
        (flattened(icosphere(3), (3, 2, 0), "sheet"), "all vertices lie in a plane"),
        (Mesh([[0, 0, 0], [3, 0, 0], [0, 1, 2]], [[0, 1, 2]], "triangle"), "all vertices lie in a plane"),
        (Mesh([[0, 0, 0], [3, 1, 0], [6, 2, 0]], [[0, 1, 2]], "line"), "all vertices lie in a plane"),
    ],
    ids=lambda value: value.name if isinstance(value, Mesh) else "",
)
def test_mesh_without_unique_axes_is_refused_in_one_sentence(mesh, sentence):
    with pytest.raises(Wm3dError, match=f"^{mesh.name}: {sentence}") as refusal:
        scan(mesh)
    assert str(refusal.value).count(". ") == 0


def test_cylinder_that_is_empty_or_not_left_handed_is_refused():
    axes = np.array([[0.0, 0, 1], [0, 1, 0], [1, 0, 0]])
    with pytest.raises(Wm3dError, match="a cylinder of radius 0 and height 1 is empty"):
        Cylinder(np.zeros(3), axes, 0.0, 0.0, 1.0)
    with pytest.raises(Wm3dError, match="a cylinder of radius 1 and height nan is empty"):
        Cylinder(np.zeros(3), axes, 1.0, 0.0, np.nan)
    for wrong in (np.eye(3), 2 * axes, axes + 0.01):
        with pytest.raises(Wm3dError, match="unit rows s1, s2, s3 at right angles"):
            Cylinder(np.zeros(3), wrong, 1.0, 0.0, 1.0)


@pytest.mark.parametrize("degrees", [1e-6, 0.5, 90.0, 180.0])
def test_axis_deviation_is_the_largest_angle_between_axes(degrees):
    axes = np.array([[0.0, 0, 1], [0, 1, 0], [1, 0, 0]])
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_s1 = np.array([[1, 0, 0], [0, cosine, sine], [0, -sine, cosine]])
    frame, turned = (Cylinder(np.zeros(3), a, 1.0, 0.0, 1.0) for a in (axes, about_s1 @ axes))
    assert frame.axis_deviation(turned) == pytest.approx(degrees, rel=1e-9)
    assert frame.axis_deviation(frame) == 0
