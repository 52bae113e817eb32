"""Histograms of distances: bins, moments and power maps against plain definitions; the sampled surface."""

import numpy as np
import pytest
from scipy.stats import beta
from shapes import blob, box, icosphere

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, surface_area
from wm3d.schemes import SCHEMES
from wm3d.schemes.radial import MEAN, VARIANCE, Spread, exponents, kernels
from wm3d.schemes.radial_area import area_centroid, quantiles


def spread(radii, bins=4, weights=None):
    radii = np.asarray(radii, dtype=float)
    weights = np.ones(len(radii)) if weights is None else np.asarray(weights, dtype=float)
    return Spread(np.zeros(3), radii, weights, 1.0, 3.0, bins)


def test_bins_divide_the_range_and_leave_out_what_lies_beyond():
    index, t = spread([]).place(np.array([0.9, 1.0, 1.25, 1.5, 2.9, 3.0, 3.1]))
    assert index.tolist() == [-1, 0, 0, 1, 3, 3, -1]
    np.testing.assert_allclose(t, [0, 0, 0.5, 0, 0.8, 1, 0], atol=1e-12)
    np.testing.assert_allclose(spread([]).distance(index[1:-1], t[1:-1]), [1.0, 1.25, 1.5, 2.9, 3.0])


def test_moments_are_weighted_and_empty_bins_have_none():
    histogram = spread([1.1, 1.4, 2.2, 2.2], weights=[3, 1, 1, 1])
    np.testing.assert_allclose(histogram.counts, [4, 0, 2, 0])
    np.testing.assert_allclose(histogram.moments(MEAN), [(3 * 0.2 + 0.8) / 4, 0, 0.4, 0])
    np.testing.assert_allclose(histogram.moments(VARIANCE), [0.36, 0, 0.04, 0])


@pytest.mark.parametrize("moment", [MEAN, VARIANCE], ids=["mean", "variance"])
def test_neutral_moment_and_deviation_are_those_of_the_uniform_law(moment):
    t = beta(1, 1).ppf((np.arange(100_000) + 0.5) / 100_000)
    assert moment.value(t).mean() == pytest.approx(moment.neutral, abs=1e-9)
    assert moment.value(t).std() == pytest.approx(moment.deviation, abs=1e-9)
    k = np.full(len(t), 1.7)
    np.testing.assert_allclose(moment.value(moment.mapped(t, k)), moment.value(t) ** k, atol=1e-12)


def test_exponent_is_the_analytic_one_for_the_uniform_law():
    # the mean of t^k is 1/(k+1), that of |y|^2k is 1/(2k+1)
    dense = spread(1 + 2 * (np.arange(400_000) + 0.5) / 400_000)
    signs, alpha = np.array([1, -1, 1, -1], dtype=np.int8), 0.1
    for moment, expected in (
        (MEAN, lambda target: 1 / target - 1),
        (VARIANCE, lambda target: (1 / target - 1) / 2),
    ):
        target = moment.neutral + alpha * signs
        np.testing.assert_allclose(exponents(dense, moment, signs, target), expected(target), rtol=1e-4)


def test_exponent_is_one_where_nothing_is_to_be_done_and_nan_where_nothing_can_be():
    histogram = spread([1.4, 1.5, 2.25])  # t = 0.8; 0; 0.5; none
    signs = np.ones(4, dtype=np.int8)
    k = exponents(histogram, MEAN, signs, np.full(4, 0.6))
    assert k[0] == 1
    assert np.isnan(k[[1, 3]]).all()
    assert 0.5 ** k[2] == pytest.approx(0.6, abs=1e-9)
    assert 0.5 ** k[2] >= 0.6  # the target is reached, not nearly so


def test_sampled_surface_equals_plain_twin():
    mesh, center = box((3.0, 2.0, 1.0)), np.array([0.1, 0.2, 0.3])
    parts = kernels.cuts(mesh.vertices, mesh.faces, 0.5, 256)
    edges = mesh.vertices[mesh.faces] - mesh.vertices[np.roll(mesh.faces, -1, axis=1)]
    np.testing.assert_array_equal(parts, np.ceil(np.linalg.norm(edges, axis=2).max(axis=1) / 0.5))
    radii, areas, face, shares = kernels.samples(mesh.vertices, mesh.faces, parts, center)
    assert len(radii) == (parts**2).sum()
    assert areas.sum() == pytest.approx(surface_area(mesh))
    np.testing.assert_allclose(shares.sum(axis=1), 1)
    assert (shares > 0).all()
    points = np.einsum("kj,kji->ki", shares, mesh.vertices[mesh.faces[face]])
    np.testing.assert_allclose(radii, np.linalg.norm(points - center, axis=1))
    # the centroids of equal parts have the centroid of the face, and no two are in one place
    np.testing.assert_allclose([shares[face == f].mean(axis=0) for f in range(12)], 1 / 3)
    assert len(np.unique(np.round(np.column_stack([face, shares]), 9), axis=0)) == len(face)


def test_centroid_and_quantiles_are_over_the_area():
    sphere = icosphere(3)
    half = sphere.vertices[sphere.faces].mean(axis=1)[:, 2] > 0
    cap = Mesh(sphere.vertices + 5.0, sphere.faces[half], "cap")
    # a hemisphere has its centroid at half its radius, up to the ragged border
    np.testing.assert_allclose(area_centroid(cap), [5, 5, 5.5], atol=0.03)
    values = np.random.default_rng(1).permutation(np.arange(1000.0))
    assert quantiles(values, np.ones(1000), (0.1, 0.5)).tolist() == pytest.approx([99.5, 499.5])
    heavy = quantiles(np.array([1.0, 2.0, 3.0]), np.array([1.0, 8.0, 1.0]), (0.5,))
    assert heavy.tolist() == [2.0]


def test_area_scheme_refuses_a_surface_that_leaves_bins_empty():
    inner = blob(0, 3)
    outer = 5 * inner.vertices + [0.1, 0.2, 0.3]
    faces = np.vstack([inner.faces, inner.faces + len(outer)])
    shells = Mesh(np.vstack([inner.vertices, outer]), faces, "shells")
    with pytest.raises(Wm3dError, match=r"^shells: its faces are too large for 64 bins: \d+ bits cannot"):
        SCHEMES.build("radial-area", {}).embed(shells, 1)


def test_area_scheme_refuses_faces_that_take_too_many_samples():
    needle = blob(0, 4)
    needle = Mesh(needle.vertices * [1e4, 1, 1], needle.faces, "needle")
    with pytest.raises(Wm3dError, match=r"^needle: its faces are so long and thin that they take \d+ "):
        SCHEMES.build("radial-area", {}).embed(needle, 1)
