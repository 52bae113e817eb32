"""The ray casting: exact on analytic shapes, equal to its numpy twin, without gaps on edges and vertices."""

import numpy as np
import pytest
from shapes import blob, box, icosphere, inside_out, lathe, uv_cylinder

from wm3d.mesh import Mesh
from wm3d.scanner import Cylinder, VertexPca, kernels, scan
from wm3d.scanner.reference import cast_reference
from wm3d.scanner.scan import MAX_GRID

UPRIGHT = np.array([[0.0, 0, 1], [0, 1, 0], [1, 0, 0]])  # e_v = (cos, sin, 0)


def upright(radius: float, hmin: float, hmax: float) -> Cylinder:
    return Cylinder(np.zeros(3), UPRIGHT, radius, hmin, hmax)


def moved(mesh: Mesh, shift: tuple[float, float, float]) -> Mesh:
    return mesh.with_vertices(mesh.vertices + np.array(shift))


def box_distance(columns: int, half: tuple[float, float]) -> np.ndarray:
    """Distance from the centre of an upright box to its wall, (columns,)."""
    angle = 2 * np.pi * np.arange(columns) / columns
    with np.errstate(divide="ignore"):
        return np.minimum(half[0] / np.abs(np.cos(angle)), half[1] / np.abs(np.sin(angle)))


@pytest.mark.parametrize("columns", [1, 2, 7, 36, 45])
@pytest.mark.parametrize("shift", [(0, 0, 0), (0.1, 0.15, -0.9)], ids=["about the axis", "beside the axis"])
@pytest.mark.parametrize("kept", [1.0, 0.8], ids=["closed", "open"])
def test_kernel_equals_numpy_twin(columns, shift, kept):
    rng = np.random.default_rng(columns)
    for seed, outward in ((1, 1), (2, -1)):
        mesh = blob(seed, 3) if outward == 1 else inside_out(blob(seed, 3))
        cylinder = VertexPca()(mesh)
        faces = mesh.faces[rng.random(len(mesh.faces)) < kept]
        arguments = (cylinder.posed(mesh) + shift, faces, cylinder.planes(21), columns, 2.0, outward)
        expected = cast_reference(*arguments)
        assert np.isfinite(expected).any()
        np.testing.assert_allclose(kernels.cast(*arguments), expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("columns", [1, 2, 3, MAX_GRID - 1, MAX_GRID])
def test_kernel_equals_twin_on_the_coarsest_and_finest_grids(columns):
    rng = np.random.default_rng(6)
    vertices, faces = rng.normal(size=(30, 3)), rng.integers(0, 30, (20, 3))
    arguments = (vertices, faces, np.array([-0.3, 0.2]), columns, 4.0, 1)
    np.testing.assert_allclose(kernels.cast(*arguments), cast_reference(*arguments), rtol=0, atol=1e-12)


def test_kernel_equals_twin_where_rays_meet_edges_and_vertices_exactly():
    # Integer coordinates, heights that differ by 2 or 4, planes at every integer, four columns: all side
    # tests of both routes are exact, and very many are ties.
    rng = np.random.default_rng(5)
    planes = np.arange(-2.0, 3.0)
    hits = 0
    for _ in range(300):
        vertices = rng.integers(-2, 3, (12, 3)).astype(float)
        vertices[:, 0] = 2 * rng.integers(-1, 2, 12)
        arguments = (vertices, rng.integers(0, 12, (10, 3)), planes, 4, 4.0, 1)
        expected = cast_reference(*arguments)
        hits += np.isfinite(expected).sum()
        np.testing.assert_allclose(kernels.cast(*arguments), expected, rtol=0, atol=1e-14)
    assert hits > 1000


def test_vertices_of_a_sphere_on_the_rays_are_ranged_exactly():
    rows, around = 16, 24
    heights = np.concatenate([[-1], -1 + (np.arange(rows) + 0.5) * 2 / rows, [1]])
    radii = np.sqrt(1 - heights**2)
    image = scan(lathe(heights, radii, around), (around, rows), upright(1.5, -1, 1))
    np.testing.assert_allclose(image.ranges, np.repeat(1.5 - radii[1:-1, None], around, axis=1), atol=1e-15)


def test_polyhedral_sphere_lies_between_its_inscribed_and_circumscribed_spheres():
    mesh, cylinder = icosphere(3), upright(1.5, -0.9, 0.9)
    a, b, c = mesh.vertices[mesh.faces].swapaxes(0, 1)
    normal = np.cross(b - a, c - a)
    inradius = np.min(np.einsum("ij,ij->i", normal, a) / np.linalg.norm(normal, axis=1))
    height = cylinder.planes(30)[:, None]
    from_axis = 1.5 - scan(mesh, (31, 30), cylinder).ranges
    assert (from_axis <= np.sqrt(1 - height**2) + 1e-15).all()
    assert (from_axis >= np.sqrt(inradius**2 - height**2)).all()


@pytest.mark.parametrize("rows", [16, 32, 33], ids=["on the rings", "between the rings", "anywhere"])
def test_polygonal_cylinder_is_ranged_exactly_on_and_between_its_edges(rows):
    image = scan(uv_cylinder(1, 2, around=64, along=32), (128, rows), upright(2, -1, 1))
    expected = np.where(np.arange(128) % 2, np.cos(np.pi / 64), 1.0)  # mid-facet and edge
    np.testing.assert_allclose(image.ranges, np.tile(2 - expected, (rows, 1)), atol=1e-15)


@pytest.mark.parametrize("columns", [4, 5, 8, 60])
@pytest.mark.parametrize("rows", [2, 4, 5], ids=["in the caps", "two rows above and below", "at the middle"])
def test_box_is_ranged_exactly_even_in_the_planes_of_its_caps(columns, rows):
    cylinder = upright(2, -2, 2)
    image = scan(box((2, 2, 2)), (columns, rows), cylinder)
    inside = np.abs(cylinder.planes(rows)) <= 1
    np.testing.assert_allclose(
        image.ranges[inside], np.tile(2 - box_distance(columns, (1, 1)), (inside.sum(), 1)), atol=1e-15
    )
    assert np.isnan(image.ranges[~inside]).all()


@pytest.mark.parametrize("columns", [4, 7, 12, 84])
def test_wall_through_the_axis_is_met_at_the_axis(columns):
    # the wall x = 0 holds the axis, and at the middle plane its diagonal edge crosses the axis
    image = scan(moved(box((2, 2, 2)), (1, 0, 0)), (columns, 5), upright(3, -1, 1))
    cosine, sine = kernels.directions(columns)
    with np.errstate(divide="ignore"):
        ahead = np.minimum(2 / np.abs(cosine), 1 / np.abs(sine))
    expected = np.where(cosine >= 0, 3 - ahead, 3.0)
    np.testing.assert_allclose(image.ranges, np.tile(expected, (5, 1)), atol=1e-15)


def test_far_wall_is_seen_from_inside_only_where_it_faces_the_ray():
    # beside the axis: rays that start on the far side cross the axis first and meet the shape beyond it
    image = scan(moved(box((1, 1, 2)), (1.5, 0, 0)), (4, 3), upright(3, -1, 1))
    np.testing.assert_allclose(image.ranges, np.tile([1.0, np.nan, 4.0, np.nan], (3, 1)), atol=1e-15)


@pytest.mark.parametrize("columns", [4, 8, 12])
def test_rays_along_the_axes_are_exact(columns):
    cosine, sine = kernels.directions(columns)
    quarters = slice(None, None, columns // 4)
    assert cosine[quarters].tolist() == [1, 0, -1, 0]
    assert sine[quarters].tolist() == [0, 1, 0, -1]
