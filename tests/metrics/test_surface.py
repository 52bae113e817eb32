"""Hausdorff, MRMS, normal deviation: analytic values, a brute-force twin, pymeshlab, bounds, invariances."""

import math
from collections.abc import Iterator

import numpy as np
import pymeshlab
import pytest
from shapes import blob, box, icosphere, inside_out, rotation, tetrahedron

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import hausdorff, hausdorff_error, mrms, normal_deviation
from wm3d.metrics.surface import Surface, both_ways, distances, kernels
from wm3d.metrics.surface.tree import kernels as tree

SHEET = ([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])


def sheet(height: float = 0.0, side: float = 1.0) -> Mesh:
    """Square in the plane z = height, open."""
    return Mesh(np.array(SHEET[0]) * [side, side, 1] + [0, 0, height], SHEET[1], name="sheet")


@pytest.fixture(autouse=True)
def wide_spacing(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Fewer cells than by default: what is exact or bounded must be so at any spacing."""
    monkeypatch.setattr(distances, "SPACING", 0.02)
    both_ways.cache_clear()
    yield
    both_ways.cache_clear()


def segment_distance(p: FloatArray, a: FloatArray, b: FloatArray) -> float:
    t = np.clip(np.dot(p - a, b - a) / max(np.dot(b - a, b - a), 1e-300), 0, 1)
    return float(np.linalg.norm(p - a - t * (b - a)))


def triangle_distance(p: FloatArray, triangle: FloatArray) -> float:
    """Numpy twin: the foot of the perpendicular by least squares if it is inside, else the nearest edge."""
    a, b, c = triangle
    v, w = np.linalg.lstsq(np.column_stack([b - a, c - a]), p - a, rcond=None)[0]
    inside = v >= 0 and w >= 0 and v + w <= 1
    edges = [segment_distance(p, *edge) for edge in ((a, b), (b, c), (c, a))]
    return float(np.linalg.norm(a + v * (b - a) + w * (c - a) - p)) if inside else min(edges)


def test_nearest_point_agrees_with_brute_force() -> None:
    rng = np.random.default_rng(1)
    vertices = rng.normal(size=(40, 3))
    faces = rng.integers(0, 40, (60, 3))  # some without area: an edge twice, or a single point
    faces[0], faces[1] = [1, 1, 2], [3, 3, 3]
    vertices[10] = vertices[8] + 0.3 * (vertices[9] - vertices[8])
    faces[2] = [8, 9, 10]  # corners in a line
    surface = Surface(vertices, faces)
    points = rng.normal(size=(100, 3)) * 1.5
    found = surface.nearest(points)
    expected = [min(triangle_distance(p, t) for t in vertices[faces]) for p in points]
    np.testing.assert_allclose(found.distance, expected, rtol=1e-9)
    nearest = np.einsum("kj,kjx->kx", found.weights, surface.corners[found.face])
    np.testing.assert_allclose(np.linalg.norm(points - nearest, axis=1), found.distance, rtol=1e-9)
    assert found.weights.min() >= 0
    np.testing.assert_allclose(found.weights.sum(axis=1), 1)


def test_rectangles_hold_their_triangles_and_touch_them_over_their_faces() -> None:
    rng = np.random.default_rng(4)
    triangles = rng.normal(size=(60, 3, 3))
    triangles[0] = triangles[0, 0]  # a point
    triangles[1, 2] = 0.3 * triangles[1, 0] + 0.7 * triangles[1, 1]  # a line
    frames = tree.frames(triangles)
    for t, triangle in enumerate(triangles):
        for p in rng.normal(size=(20, 3)):
            bound = math.sqrt(tree.rectangle_distance(tuple(p), frames, t))
            assert bound <= triangle_distance(p, triangle) * (1 + 1e-12)
        normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        above = triangle.mean(axis=0) + normal
        exact = math.sqrt(tree.rectangle_distance(tuple(above), frames, t))
        assert exact == pytest.approx(np.linalg.norm(normal), abs=1e-12)


def test_numbers_do_not_depend_on_the_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    original, other = icosphere(3), icosphere(2, 1.1)
    found = []
    for threads in (1, 2):
        monkeypatch.setattr("wm3d.threads.config.NUMBA_NUM_THREADS", threads)
        both_ways.cache_clear()
        found.append(both_ways(original, other))
    assert found[0] == found[1]


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8, 100])
def test_tree_keeps_every_face_once(count: int) -> None:
    rng = np.random.default_rng(count)
    faces = np.arange(3 * count).reshape(-1, 3)
    surface = Surface(rng.normal(size=(3 * count, 3)), faces)
    np.testing.assert_array_equal(np.sort(surface.faces, axis=0), faces)


def test_cells_cover_their_triangles_with_short_edges() -> None:
    triangles = np.random.default_rng(2).normal(size=(5, 3, 3))
    triangles[4] = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
    cells, parent = kernels.cells(triangles, 0.1)
    edges = np.linalg.norm(cells - np.roll(cells, 1, axis=1), axis=2)
    assert edges.max() <= 0.1
    assert 20 <= (parent == 4).sum() < 200  # a grid as fine has 400
    area = np.bincount(parent, kernels.moments(cells)[1])
    np.testing.assert_allclose(area, kernels.moments(triangles)[1], atol=1e-12)
    assert (np.diff(parent) >= 0).all()


def test_the_number_of_cells_is_known_roughly_before_they_are_cut() -> None:
    rng = np.random.default_rng(4)
    triangles = rng.normal(size=(30, 3, 3))
    triangles[0, 2] = triangles[0, 1]  # no area, but two long edges
    triangles[1] *= 1e-3  # not cut
    for triangle in triangles:
        estimate = kernels.cells_cut(triangle[None], 0.05)
        found = len(kernels.cells(triangle[None], 0.05)[0])
        assert found == 1 if estimate == 0 else found / 4 < estimate < 2.5 * found


def test_a_surface_in_another_unit_is_refused_before_it_is_cut() -> None:
    other = Mesh(1000 * box().vertices, box().faces, name="mm")
    for metric in (hausdorff, hausdorff_error, mrms, normal_deviation):
        with pytest.raises(
            Wm3dError, match=r"^mm: is 1,000 times as large as box; bring them to one unit\.$"
        ):
            metric(box(), other)
    assert hausdorff(other, box()) > 0


def test_a_surface_folded_beyond_measure_is_refused_and_a_rough_one_is_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(distances, "MOST_CUT", 5000)
    ball = blob(subdivisions=3)  # 1280 faces
    noise = np.random.default_rng(5).normal(size=ball.vertices.shape)
    crumpled, rough = (ball.with_vertices(ball.vertices + size * noise) for size in (0.3, 0.01))
    with pytest.raises(
        Wm3dError, match=r"^blob-0: its surface is too folded to be measured, in some .* smooth it"
    ):
        mrms(ball, crumpled)
    assert mrms(ball, rough) > 0


def test_moments_agree_with_numpy() -> None:
    triangles = np.random.default_rng(3).normal(size=(50, 3, 3))
    centroids, areas, reach, spread = kernels.moments(triangles)
    a, b, c = triangles.transpose(1, 0, 2)
    np.testing.assert_allclose(centroids, triangles.mean(axis=1))
    np.testing.assert_allclose(areas, np.linalg.norm(np.cross(b - a, c - a), axis=1))
    offsets = np.linalg.norm(triangles - triangles.mean(axis=1, keepdims=True), axis=2)
    np.testing.assert_allclose(reach, offsets.max(axis=1))
    # ∫‖x − centroid‖² over the area of a triangle is (sum of the squared edges) / 36
    edges = ((triangles - np.roll(triangles, 1, axis=1)) ** 2).sum(axis=(1, 2))
    np.testing.assert_allclose(spread, edges / 36)


def test_sheets_at_a_distance() -> None:
    assert hausdorff(sheet(), sheet(0.25)) == pytest.approx(0.25, rel=1e-12)
    assert mrms(sheet(), sheet(0.25)) == pytest.approx(0.25, rel=1e-12)
    assert normal_deviation(sheet(), sheet(0.25)) == 0


def test_both_directions_count() -> None:
    """From the small sheet all is near; from the large one the far corner is at √2 / 2."""
    small, large = sheet(side=0.5), sheet()
    there, back = both_ways(small, large)
    assert there.farthest == pytest.approx(0, abs=1e-12)
    assert back.farthest == pytest.approx(math.sqrt(0.5), rel=1e-12)
    assert hausdorff(small, large) == hausdorff(large, small) == pytest.approx(math.sqrt(0.5))
    # ∫ d² over the outer L: two strips of ∫(x − ½)² = 1/48 each, and a corner square of 2/48
    assert mrms(small, large) == pytest.approx(math.sqrt(1 / 12), rel=1e-3)


def test_offset_sphere() -> None:
    inner, outer = icosphere(4), icosphere(4, radius=1.1)
    assert hausdorff(inner, outer) == pytest.approx(0.1, rel=1e-9)  # at the vertices, radially
    assert mrms(inner, outer) == pytest.approx(0.1, rel=2e-3)
    assert normal_deviation(inner, outer) < 1.0
    assert normal_deviation(inner, inside_out(outer)) > 179


def test_scaled_cube() -> None:
    """A corner of the outer cube is √3/2 of the added side from the inner, the rest of a face less."""
    assert hausdorff(box(), box((1.2, 1.2, 1.2))) == pytest.approx(0.1 * math.sqrt(3), rel=1e-12)
    assert both_ways(box(), box((1.2, 1.2, 1.2)))[0].farthest == pytest.approx(0.1, rel=1e-9)


def test_shifted_tetrahedron() -> None:
    """The far face moves away along its normal: no vertex is as far as its shift, but the apex is."""
    shifted = tetrahedron().with_vertices(tetrahedron().vertices + np.array([0.3, 0, 0]))
    assert both_ways(tetrahedron(), shifted)[0].farthest == pytest.approx(0.3, rel=1e-9)
    assert both_ways(tetrahedron(), shifted)[1].farthest == pytest.approx(0.3, rel=1e-9)


def test_farthest_point_within_a_face_is_found() -> None:
    """Over a pit the farthest points of a flat sheet are no vertices and no centroid of a cell."""
    x = np.array([0.0, 0.37, 1.0])
    grid = np.array([[a, b, 0.0] for a in x for b in x])
    grid[4, 2] = -0.4
    quads = [[3 * i + j, 3 * i + 3 + j, 3 * i + 4 + j, 3 * i + 1 + j] for i in range(2) for j in range(2)]
    pit = Mesh(grid, [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])])
    way = both_ways(sheet(), pit)[0]
    lattice = np.stack(np.meshgrid(*[np.linspace(0, 1, 801)] * 2), axis=-1).reshape(-1, 2)
    truth = Surface(pit.vertices, pit.faces).nearest(np.column_stack([lattice, np.zeros(len(lattice))]))
    assert way.farthest <= truth.distance.max() + 1e-3
    assert truth.distance.max() <= way.farthest + way.farthest_error
    assert way.farthest_error <= distances.TOLERANCE * sheet().diagonal * (1 + 1e-9)


@pytest.mark.parametrize("percent", [0.05, 0.5])
def test_agrees_with_pymeshlab_called_both_ways(percent: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(distances, "SPACING", 0.006)
    original = blob(subdivisions=4)
    noise = np.random.default_rng(5).normal(size=original.vertices.shape)
    noisy = original.with_vertices(original.vertices + percent / 100 * original.diagonal * noise)
    meshes = pymeshlab.MeshSet()
    for mesh in (original, noisy):
        meshes.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.faces))
    ways = [
        meshes.get_hausdorff_distance(
            sampledmesh=a,
            targetmesh=1 - a,
            samplevert=True,
            sampleface=True,
            samplenum=200_000,
            maxdist=pymeshlab.PercentageValue(100),
        )
        for a in (0, 1)
    ]
    # its samples are random points: it finds at most the true maximum, and its RMS has a sampling error
    theirs = max(way["max"] for way in ways)
    assert theirs <= hausdorff(original, noisy) + hausdorff_error(original, noisy) + 1e-6
    assert theirs == pytest.approx(hausdorff(original, noisy), rel=2e-2)
    assert max(way["RMS"] for way in ways) == pytest.approx(mrms(original, noisy), rel=2e-2)


def test_error_bounds_hold_against_a_finer_sampling(monkeypatch: pytest.MonkeyPatch) -> None:
    original, other = blob(subdivisions=3), blob(subdivisions=2)
    coarse = both_ways(original, other)
    monkeypatch.setattr(distances, "SPACING", distances.SPACING / 4)
    both_ways.cache_clear()
    fine = both_ways(original, other)
    for rough, exact in zip(coarse, fine, strict=True):
        assert rough.farthest <= exact.farthest + exact.farthest_error
        assert exact.farthest <= rough.farthest + rough.farthest_error
        assert abs(rough.rms - exact.rms) <= rough.rms_error + exact.rms_error
        assert rough.rms == pytest.approx(exact.rms, rel=1e-2)  # far better than the bound


def test_similarity_scales_lengths_and_keeps_angles() -> None:
    original = blob(subdivisions=3)
    other = original.with_vertices(original.vertices * [1.02, 1, 1])
    moved = [
        mesh.with_vertices(3e4 * mesh.vertices @ rotation(1).T + [5e4, 0, -9e4]) for mesh in (original, other)
    ]
    assert hausdorff(*moved) == pytest.approx(3e4 * hausdorff(original, other), rel=1e-3)
    assert mrms(*moved) == pytest.approx(3e4 * mrms(original, other), rel=1e-3)
    assert normal_deviation(*moved) == pytest.approx(normal_deviation(original, other), rel=2e-2)


def test_identical_meshes_have_no_distance() -> None:
    mesh = blob(subdivisions=3)
    twin = mesh.with_vertices(mesh.vertices)
    assert hausdorff(mesh, twin) < 1e-14
    assert mrms(mesh, twin) < 1e-14
    assert normal_deviation(mesh, twin) < 1e-6


def test_vertices_without_a_face_do_not_count() -> None:
    stray = Mesh(np.vstack([sheet(0.1).vertices, [[0, 0, 50.0]]]), sheet().faces)
    assert hausdorff(sheet(), stray) == pytest.approx(0.1)


def test_surface_without_area_has_a_hausdorff_distance_but_no_mean() -> None:
    line = Mesh([[0, 0, 0.5], [1, 0, 0.5], [1, 0, 0.5]], [[0, 1, 2]], name="line")
    assert hausdorff(sheet(), line) == pytest.approx(math.sqrt(1.25))
    with pytest.raises(Wm3dError, match="line: its faces have no area"):
        mrms(sheet(), line)
