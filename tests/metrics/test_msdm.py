"""MSDM and MSDM2: curvature of known surfaces, numpy twins, identities, invariances, growth with noise."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from shapes import blob, icosphere, inside_out, rotation, uv_cylinder

from wm3d.arrays import FloatArray
from wm3d.attacks import ATTACKS
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import msdm, msdm2
from wm3d.metrics.perceptual import kernels
from wm3d.metrics.perceptual.connectivity import Connectivity
from wm3d.metrics.perceptual.curvature import mean_absolute_curvature
from wm3d.metrics.perceptual.msdm import terms

Metric = Callable[[Mesh, Mesh], float]


def curvature(mesh: Mesh, radius: float) -> FloatArray:
    return mean_absolute_curvature(
        mesh.vertices, mesh.faces, Connectivity(mesh.faces, len(mesh.vertices)), radius
    )


def noisy(mesh: Mesh, percent: float, seed: int = 0) -> Mesh:
    noise = np.random.default_rng(seed).normal(size=mesh.vertices.shape)
    return mesh.with_vertices(mesh.vertices + percent / 100 * mesh.diagonal * noise)


def moved(mesh: Mesh, scale: float, turn: FloatArray) -> Mesh:
    return mesh.with_vertices(scale * mesh.vertices @ turn.T + [3.0, -1.0, 7.0])


def component(mesh: Mesh, edges: set[tuple[int, int]], i: int, radius: float) -> set[int]:
    """Vertices that hang together with vertex i inside the ball about it."""
    inside = np.linalg.norm(mesh.vertices - mesh.vertices[i], axis=1) <= radius
    found, grown = {i}, True
    while grown:
        more = {q for p, q in edges if p in found and inside[q]} - found
        found, grown = found | more, bool(more)
    return found


def share(mesh: Mesh, i: int, p: int, q: int, radius: float) -> float:
    """Part of the edge from p to q that lies in the ball about vertex i, by bisection."""
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        point = mesh.vertices[p] + middle * (mesh.vertices[q] - mesh.vertices[p])
        low, high = (middle, high) if np.linalg.norm(point - mesh.vertices[i]) <= radius else (low, middle)
    return low


@pytest.mark.parametrize("radius", [0.08, 0.3])
def test_kernels_agree_with_their_twins(radius: float) -> None:
    """Radii below and above the length of an edge."""
    mesh = noisy(icosphere(2), 1.0)
    connectivity = Connectivity(mesh.faces, len(mesh.vertices))
    first, vertex, edge = connectivity.neighbours
    angles = connectivity.dihedral_angles(mesh.vertices, mesh.faces)
    start = np.repeat(np.arange(len(mesh.vertices)), np.diff(first))
    angle_of = {(int(p), int(q)): angles[e] for p, q, e in zip(start, vertex, edge, strict=True)}
    values = np.random.default_rng(4).normal(size=(len(mesh.vertices), 2))
    tensors = kernels.curvature_tensors(mesh.vertices, first, vertex, angles[edge], radius)
    statistics = kernels.window_statistics(mesh.vertices, first, vertex, values, radius)
    for i in range(0, len(mesh.vertices), 20):
        inside = component(mesh, set(angle_of), i, radius)
        points, weights, tensor = [values[p] for p in inside], [], np.zeros((3, 3))
        weights = [np.linalg.norm(mesh.vertices[p] - mesh.vertices[i]) for p in inside]
        for (p, q), angle in angle_of.items():
            if p not in inside:
                continue
            along = mesh.vertices[q] - mesh.vertices[p]
            part = share(mesh, i, p, q, radius)
            tensor += (
                angle * (part / 2 if q in inside else part) * np.outer(along, along) / np.linalg.norm(along)
            )
            if q not in inside:
                points.append((1 - part) * values[p] + part * values[q])
                weights.append(radius)
        np.testing.assert_allclose(tensors[i], tensor / (math.pi * radius**2), atol=1e-9)
        gauss = np.exp(-(np.array(weights) ** 2) / (2 * (radius / 2) ** 2))
        mean = np.average(points, axis=0, weights=gauss)
        covariance = np.cov(np.transpose(points), aweights=gauss, ddof=0)
        expected = [*mean, covariance[0, 0], covariance[1, 1], covariance[0, 1]]
        np.testing.assert_allclose(statistics[i], expected, atol=1e-9)


def test_curvature_of_sphere_and_cylinder() -> None:
    """K is 1/r on a sphere, ½ · 1/r on a cylinder; the triangles at the rim of the ball are felt."""
    assert curvature(icosphere(5, radius=2.0), 0.2) == pytest.approx(0.5, rel=0.07)
    cylinder = uv_cylinder(radius=1.0, height=4.0, around=256, along=256)
    side = np.abs(cylinder.vertices[:, 2]) < 1.5
    assert curvature(cylinder, 0.1)[side] == pytest.approx(0.5, rel=0.02)


def test_winding_and_folds_do_not_matter() -> None:
    mesh = blob(subdivisions=3)
    np.testing.assert_allclose(curvature(mesh, 0.05), curvature(inside_out(mesh), 0.05), rtol=1e-9)
    folded = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.9, 0]], [[0, 1, 2], [1, 0, 3]])
    angles = Connectivity(folded.faces, 4).dihedral_angles(folded.vertices, folded.faces)
    assert sorted(angles) == pytest.approx([0, 0, 0, 0, math.pi])


def test_terms_are_those_of_the_definition() -> None:
    """Means 2 and 5, standard deviations 3 and 1, covariance −2."""
    result = terms(np.array([[2.0, 5.0, 9.0, 1.0, -2.0]]))
    np.testing.assert_allclose(np.ravel(result), [3 / 6, 2 / 4, 5 / 4])


@pytest.mark.parametrize("metric", [msdm, msdm2])
def test_identical_meshes_have_no_distortion(metric: Metric) -> None:
    mesh = blob(subdivisions=4)
    assert metric(mesh, mesh.with_vertices(mesh.vertices)) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("metric", [msdm, msdm2])
def test_distortion_grows_with_the_noise_and_stays_below_one(metric: Metric) -> None:
    mesh = blob(subdivisions=4)
    values = [metric(mesh, noisy(mesh, percent)) for percent in (0.01, 0.03, 0.1, 0.3)]
    assert values == sorted(values)
    assert 0 < values[0] < 0.5 * values[-1]
    assert values[-1] < 1


@pytest.mark.parametrize("metric", [msdm, msdm2])
def test_similarity_of_both_meshes_changes_nothing(metric: Metric) -> None:
    original = blob(subdivisions=4)
    other = noisy(original, 0.1)
    value = metric(original, other)
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    assert metric(*(moved(mesh, 1e4, quarter) for mesh in (original, other))) == pytest.approx(
        value, rel=1e-6
    )
    # any other turn changes the axis-aligned box, and so the scales
    turned = metric(*(moved(mesh, 1.0, rotation(2)) for mesh in (original, other)))
    assert turned == pytest.approx(value, rel=0.1)


def test_msdm2_is_symmetric_and_takes_any_connectivity() -> None:
    original = blob(subdivisions=4)
    coarse = ATTACKS.build("simplify", {"ratio": 0.5})(original, np.random.default_rng(0))
    assert msdm2(original, coarse) == pytest.approx(msdm2(coarse, original), rel=1e-6)
    assert 0.01 < msdm2(original, coarse) < 1


def test_msdm2_does_not_see_the_order_of_the_vertices() -> None:
    mesh = blob(subdivisions=4)
    order = np.random.default_rng(1).permutation(len(mesh.vertices))
    shuffled = Mesh(mesh.vertices[order], np.argsort(order)[mesh.faces])
    assert msdm2(mesh, shuffled) == pytest.approx(0, abs=1e-9)
    assert msdm(mesh, shuffled) > 0.1


def test_open_meshes_and_unused_vertices() -> None:
    whole = blob(subdivisions=4)
    stray = 0.5 * (whole.vertices.max(axis=0) + whole.vertices.min(axis=0))
    opened = Mesh(np.vstack([whole.vertices, stray]), whole.faces[:-500])
    assert msdm2(opened, opened.with_vertices(opened.vertices)) == pytest.approx(0, abs=1e-9)
    assert 0 < msdm2(opened, whole) < msdm2(noisy(opened, 1.0), whole)
    assert curvature(opened, 0.05)[-1] == 0


def test_msdm_needs_the_same_vertices() -> None:
    with pytest.raises(Wm3dError, match="MSDM compares vertex by vertex"):
        msdm(icosphere(2), icosphere(3))
