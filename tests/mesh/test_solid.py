"""Moments of solids: closed forms, points drawn inside, an exact second route, and linear maps."""

from itertools import combinations_with_replacement
from math import comb, factorial

import numpy as np
import pytest
import trimesh
from shapes import blob, box, icosphere, inside_out, rotation, tetrahedron, uv_cylinder

from wm3d.attacks import Crop
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, SolidMoments, solid_moments, volume_moments
from wm3d.mesh.kernels import cone_integrals, umbrella_step
from wm3d.mesh.solid import ENTRIES, ORDERS

BLOB = blob(1, 4)
MOMENTS = solid_moments(BLOB)
OPEN = Mesh(BLOB.vertices, BLOB.faces[40:], "open blob")


def tensors(moments: SolidMoments) -> dict[int, np.ndarray]:
    return {2: moments.second, 3: moments.third, 4: moments.fourth}


def assert_equal(found: SolidMoments, expected: SolidMoments, rtol: float = 1e-12) -> None:
    for order, tensor in tensors(expected).items():
        scale = np.trace(expected.second) ** (order / 2)
        np.testing.assert_allclose(tensors(found)[order], tensor, rtol=0, atol=rtol * scale)


def closed_forms(moments: SolidMoments, mean) -> None:
    """Compare every entry with ``mean(i, j, k)``, that of xⁱ yʲ zᵏ about the centroid."""
    for order, tensor in tensors(moments).items():
        for index in np.ndindex(tensor.shape):
            powers = (index.count(0), index.count(1), index.count(2))
            assert tensor[index] == pytest.approx(mean(*powers), abs=1e-15), (order, index)


def test_moments_of_a_box_are_products_of_those_of_its_sides():
    extents = (1.0, 2.0, 0.5)

    def mean(*powers):
        return np.prod([0 if p % 2 else (e / 2) ** p / (p + 1) for e, p in zip(extents, powers, strict=True)])

    closed_forms(solid_moments(box(extents)), mean)


def test_moments_of_a_corner_of_the_cube_are_those_of_dirichlet():
    def raw(*powers):  # of x, y, z and the fourth barycentric coordinate, all alike
        return factorial(3) * np.prod([factorial(p) for p in powers]) / factorial(3 + sum(powers))

    def mean(i, j, k):
        return sum(
            comb(i, a) * comb(j, b) * comb(k, c) * (-0.25) ** (i + j + k - a - b - c) * raw(a, b, c)
            for a in range(i + 1)
            for b in range(j + 1)
            for c in range(k + 1)
        )

    moments = solid_moments(tetrahedron())
    np.testing.assert_allclose(moments.centroid, 0.25, rtol=1e-14)
    closed_forms(moments, mean)


def test_moments_of_a_ball_are_approached_with_the_square_of_the_edge():
    def errors(subdivisions):
        fourth = solid_moments(icosphere(subdivisions)).fourth
        return np.array([fourth[0, 0, 0, 0] / (3 / 35) - 1, fourth[0, 0, 1, 1] / (1 / 35) - 1])

    np.testing.assert_allclose(errors(3) / errors(4), 4, rtol=0.05)
    assert np.abs(errors(4)).max() < 0.01


def test_moments_are_the_means_of_points_drawn_in_the_solid():
    # the blob is star-shaped: points of the tetrahedra from its centroid to its faces
    rng, count = np.random.default_rng(0), 200_000
    corners = (BLOB.vertices - MOMENTS.centroid)[BLOB.faces]
    sizes = np.linalg.det(corners)
    assert (sizes > 0).all()
    face = rng.choice(len(sizes), count, p=sizes / sizes.sum())
    shares = rng.dirichlet(np.ones(4), count)[:, :3]
    points = np.einsum("kj,kji->ki", shares, corners[face])
    for order, tensor in tensors(MOMENTS).items():
        for index in combinations_with_replacement(range(3), order):
            drawn = points[:, index].prod(axis=1)
            # five standard errors for each of 31 means: a false alarm of 2e-5
            assert abs(drawn.mean() - tensor[index]) < 5 * drawn.std() / np.sqrt(count)


@pytest.mark.parametrize(
    "mesh", [box((1, 2, 3)), uv_cylinder(), inside_out(BLOB), OPEN], ids=lambda mesh: mesh.name
)
def test_kernel_is_exact_along_any_direction(mesh):
    # over a tetrahedron with the corner 0, the mean of (u·x)^p is p! 3!/(p + 3)! h_p(u·a, u·b, u·c), h_p the
    # complete homogeneous polynomial; all directions u together fix a symmetric tensor
    apex = np.array([0.1, -0.2, 0.3])
    corners = (mesh.vertices - apex)[mesh.faces]
    size = np.linalg.det(corners) / 6
    integrals = cone_integrals(mesh.vertices, mesh.faces, apex, 1.0)
    for u in np.random.default_rng(1).normal(size=(20, 3)):
        p1, p2, p3, p4 = (((corners @ u) ** k).sum(axis=1) for k in (1, 2, 3, 4))
        homogeneous = {
            0: np.ones(len(size)),
            1: p1,
            2: (p1**2 + p2) / 2,
            3: (p1**3 + 3 * p1 * p2 + 2 * p3) / 6,
            4: (p1**4 + 6 * p1**2 * p2 + 3 * p2**2 + 8 * p1 * p3 + 6 * p4) / 24,
        }
        for p, h in homogeneous.items():
            share = factorial(p) * factorial(3) / factorial(p + 3)
            found = sum(
                comb(p, i) * comb(p - i, j) * u[0] ** i * u[1] ** j * u[2] ** (p - i - j)
                * integrals[i, j, p - i - j]
                for i in range(p + 1)
                for j in range(p - i + 1)
            )  # fmt: skip
            assert found == pytest.approx(share * (size * h).sum(), rel=1e-11, abs=1e-13)
    i, j, k = np.indices((5, 5, 5))
    assert (integrals[i + j + k > 4] == 0).all()


@pytest.mark.parametrize("mesh", [uv_cylinder(), BLOB], ids=lambda mesh: mesh.name)
def test_centroid_and_second_moments_agree_with_two_other_codes(mesh):
    found, ours = solid_moments(mesh), volume_moments(mesh)
    np.testing.assert_allclose(found.centroid, ours.centroid, atol=1e-14)
    np.testing.assert_allclose(found.second, ours.covariance, atol=1e-14)
    theirs = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).mass_properties
    np.testing.assert_allclose(found.centroid, theirs["center_mass"], atol=1e-9)
    inertia = (np.trace(found.second) * np.eye(3) - found.second) * theirs["volume"]
    np.testing.assert_allclose(inertia, theirs["inertia"], atol=1e-9)


@pytest.mark.parametrize("mesh", [tetrahedron(), uv_cylinder(), BLOB, OPEN], ids=lambda mesh: mesh.name)
def test_winding_does_not_matter(mesh):
    np.testing.assert_allclose(
        solid_moments(inside_out(mesh)).centroid, solid_moments(mesh).centroid, atol=1e-14
    )
    assert_equal(solid_moments(inside_out(mesh)), solid_moments(mesh))


@pytest.mark.parametrize("mesh", [BLOB, OPEN], ids=lambda mesh: mesh.name)
@pytest.mark.parametrize("mirror", [1, -1])
def test_mapped_moments_are_the_moments_of_the_mapped_mesh(mesh, mirror):
    matrix = np.random.default_rng(2).normal(size=(3, 3))
    matrix[0] *= mirror * np.sign(np.linalg.det(matrix))
    shift = np.array([30.0, -20.0, 10.0])
    moments = solid_moments(mesh)
    there = solid_moments(Mesh(mesh.vertices @ matrix.T + shift, mesh.faces))
    assert_equal(moments.mapped(matrix), there, rtol=1e-11)
    np.testing.assert_allclose(there.centroid, matrix @ moments.centroid + shift, atol=1e-12)
    assert moments.mapped(matrix).centroid.tolist() == [0, 0, 0]


def test_maps_follow_one_another():
    first, second = np.random.default_rng(3).normal(size=(2, 3, 3))
    assert_equal(MOMENTS.mapped(first).mapped(second), MOMENTS.mapped(second @ first))
    assert_equal(MOMENTS.mapped(rotation(5)).mapped(rotation(5).T), MOMENTS)


def test_entries_hold_all_and_come_back():
    entries = MOMENTS.entries()
    assert entries.shape == (ENTRIES,)
    back = SolidMoments.of_entries(entries.tolist())
    assert_equal(back, MOMENTS)
    assert back.centroid.tolist() == [0, 0, 0]
    np.testing.assert_array_equal(back.entries(), entries)
    # 31 numbers of any kind are the moments of something, symmetric in all indices
    anything = SolidMoments.of_entries(np.arange(31.0))
    np.testing.assert_array_equal(anything.entries(), np.arange(31.0))
    for tensor in tensors(anything).values():
        for axis in range(1, tensor.ndim):
            np.testing.assert_array_equal(tensor, tensor.swapaxes(0, axis))


def test_distance_of_components_is_that_of_the_tensors():
    other = solid_moments(blob(2, 3))
    expected = sum(((tensors(MOMENTS)[order] - tensors(other)[order]) ** 2).sum() for order in ORDERS)
    found = ((MOMENTS.components() - other.components()) ** 2).sum()
    assert found == pytest.approx(expected, rel=1e-12)


def test_components_of_a_map_and_their_derivatives():
    moments = SolidMoments.of_entries(np.random.default_rng(4).normal(size=ENTRIES))
    matrix = np.random.default_rng(5).normal(size=(3, 3))
    components, derivatives = moments.components_of(matrix)
    np.testing.assert_allclose(components, moments.mapped(matrix).components(), atol=1e-12)
    assert derivatives.shape == (ENTRIES, 9)
    for entry in range(9):
        step = np.zeros(9)
        step[entry] = 0.5
        at = {k: moments.mapped(matrix + k * step.reshape(3, 3)).components() for k in (-2, -1, 1, 2)}
        # the five-point difference, exact for these polynomials of degree 4
        expected = (at[-2] - 8 * at[-1] + 8 * at[1] - at[2]) / (12 * 0.5)
        np.testing.assert_allclose(derivatives[:, entry], expected, atol=1e-11)


def border(mesh: Mesh) -> np.ndarray:
    """Edges that only one face has, turned as the faces of a cap need them: (k, 2)."""
    edges = {tuple(edge) for edge in mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()}
    return np.array([(b, a) for a, b in edges if (b, a) not in edges])


def capped(mesh: Mesh, apex: np.ndarray) -> Mesh:
    edges = border(mesh)
    cap = np.column_stack([edges, np.full(len(edges), len(mesh.vertices))])
    return Mesh(np.vstack([mesh.vertices, apex]), np.vstack([mesh.faces, cap]))


def with_specks(mesh: Mesh, points: np.ndarray) -> Mesh:
    """Add points as faces without area, which move the middle of the mesh and nothing else."""
    specks = np.repeat(np.arange(len(points))[:, None], 3, axis=1) + len(mesh.vertices)
    return Mesh(np.vstack([mesh.vertices, points]), np.vstack([mesh.faces, specks]))


def test_hole_is_closed_by_a_cone_from_the_centroid():
    first = solid_moments(capped(OPEN, OPEN.middle)).centroid
    expected = solid_moments(capped(OPEN, first))
    found = solid_moments(OPEN)
    np.testing.assert_allclose(found.centroid, expected.centroid, atol=1e-14)
    assert_equal(found, expected)
    assert np.abs(MOMENTS.fourth - found.fourth).max() > 1e-3 * np.abs(found.fourth).max()


@pytest.mark.parametrize("mesh", [BLOB, OPEN], ids=lambda mesh: mesh.name)
def test_vertices_that_no_face_uses_do_not_matter(mesh):
    far = Mesh(np.vstack([mesh.vertices, [[1e6, 0, 0]]]), mesh.faces)
    assert far.diagonal == mesh.diagonal
    assert_equal(solid_moments(far), solid_moments(mesh))


def test_where_vertices_lie_densely_hardly_matters():
    heap = np.tile(BLOB.vertices[100], (len(BLOB.vertices), 1))
    heaped = solid_moments(with_specks(OPEN, heap)).centroid
    moved = np.linalg.norm(heap[0] - OPEN.middle) / 2  # of the middle
    assert np.linalg.norm(heaped - solid_moments(OPEN).centroid) < 1e-3 * moved


@pytest.mark.parametrize("scale", [1e-49, 1e49])
def test_moments_follow_the_size_as_far_as_meshes_go(scale):
    there = solid_moments(BLOB.with_vertices(scale * BLOB.vertices))
    assert_equal(there.mapped(np.eye(3) / scale), MOMENTS)


def test_sheet_has_no_moments():
    sheet = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], name="sheet")
    with pytest.raises(Wm3dError, match=r"^sheet: its faces enclose no volume"):
        solid_moments(sheet)


@pytest.mark.parametrize("mesh", [BLOB, OPEN], ids=lambda mesh: mesh.name)
def test_umbrella_step_goes_towards_the_mean_of_the_neighbours(mesh):
    loose = Mesh(np.vstack([mesh.vertices, [[7, 8, 9]]]), mesh.faces)
    total, count = np.zeros_like(loose.vertices), np.zeros(len(loose.vertices))
    for start, end in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)):
        np.add.at(total, mesh.faces[:, start], mesh.vertices[mesh.faces[:, end]])
        np.add.at(count, mesh.faces[:, start], 1)
    used = count > 0
    expected = loose.vertices.copy()
    expected[used] += 0.3 * (total[used] / count[used, None] - expected[used])
    moved = umbrella_step(loose.vertices, loose.faces, 0.3)
    np.testing.assert_allclose(moved, expected, rtol=0, atol=1e-15)
    assert moved[-1].tolist() == [7, 8, 9]


def test_moments_are_seen_from_the_middle_where_the_centroid_sees_no_solid():
    part = Crop(percent=70)(blob(1, 2), np.random.default_rng(5))
    mesh = with_specks(part, np.tile([5.2, 3.8, -2.8], (len(part.vertices), 1)))
    np.testing.assert_allclose(
        solid_moments(mesh).second, volume_moments(mesh).covariance, rtol=1e-9, atol=1e-9
    )
