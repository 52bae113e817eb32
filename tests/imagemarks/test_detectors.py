"""The detectors: the literature's formulas, term by term, against offset + Σ b w."""

import numpy as np
import pytest
from scipy.special import gamma
from scipy.stats import gennorm

from wm3d.imagemarks import GgdLrt, Linear
from wm3d.imagemarks.detectors import _maximum_likelihood

ALPHA = 1.3


def received(seed: int = 0, blocks: int = 100, frequencies: int = 63) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.laplace(0, rng.uniform(0.5, 30, frequencies), (blocks, frequencies))


def test_likelihood_ratio_equals_the_formula_of_hernandez_and_perez_gonzalez():
    y, c, rng = received(), 0.8, np.random.default_rng(1)
    sigma = np.sqrt(np.mean(y**2, axis=0))
    beta = np.sqrt(gamma(3 / c) / gamma(1 / c)) / sigma
    evidence = GgdLrt(shape=c).evidence(y, ALPHA)
    for _ in range(200):
        w = rng.choice([-1, 1], y.shape)
        ratio = np.sum(beta**c * (np.abs(y) ** c - np.abs(y - ALPHA * w) ** c))
        assert evidence.score(w.ravel()).statistic == pytest.approx(ratio, rel=1e-10, abs=1e-8)


@pytest.mark.parametrize("shape", [0.5, 1.0, "ml"])
def test_likelihood_ratio_is_that_of_scipys_densities(shape):
    y = received(2, blocks=40, frequencies=5)
    if shape == "ml":
        c, power_scale = _maximum_likelihood(np.abs(y))
        scale = power_scale ** (-1 / c)
    else:
        c = shape
        scale = np.sqrt(np.mean(y**2, axis=0)) * np.sqrt(gamma(1 / c) / gamma(3 / c))
    w = np.random.default_rng(3).choice([-1, 1], y.shape)
    ratio = np.sum(gennorm.logpdf(y - ALPHA * w, c, scale=scale) - gennorm.logpdf(y, c, scale=scale))
    statistic = GgdLrt(shape=shape).evidence(y, ALPHA).score(w.ravel()).statistic
    assert statistic == pytest.approx(ratio, rel=1e-10)


def test_gaussian_likelihood_ratio_is_the_linear_correlator():
    y = received(4)
    gaussian, linear = GgdLrt(shape=2).evidence(y, ALPHA), Linear().evidence(y, ALPHA)
    # β² = 1/(2σ²): b = β² ((y+α)² − (y−α)²)/2 = α y/σ²
    np.testing.assert_allclose(gaussian.b, ALPHA * linear.b, rtol=1e-9)
    np.testing.assert_allclose(linear.b, (y / np.mean(y**2, axis=0)).ravel(), rtol=1e-12)
    assert linear.offset == 0
    w = np.random.default_rng(5).choice([-1, 1], y.size)
    assert gaussian.score(w).z == pytest.approx(linear.score(w).z, rel=1e-9)


@pytest.mark.parametrize("shape", [0.5, 0.8, 1.0, 2.0])
def test_maximum_likelihood_finds_the_shape_and_scale_that_scipy_finds(shape):
    y = gennorm.rvs(shape, scale=3, size=(4000, 2), random_state=6)
    c, power_scale = _maximum_likelihood(np.abs(y))
    # the standard error of the shape at n = 4000 is below 4 %; 15 % is far outside it
    np.testing.assert_allclose(c, shape, rtol=0.15)
    for k in range(2):
        fitted, _, scale = gennorm.fit(y[:, k], floc=0)
        own = gennorm.logpdf(y[:, k], c[k], scale=power_scale[k] ** (-1 / c[k])).sum()
        assert own >= gennorm.logpdf(y[:, k], fitted, scale=scale).sum() - 1e-6
        assert c[k] == pytest.approx(fitted, rel=1e-3)


@pytest.mark.parametrize("detector", [GgdLrt(), GgdLrt(shape="ml"), GgdLrt(shape=2), Linear()])
def test_unread_blocks_and_empty_frequencies_have_no_weight(detector):
    y = received(7)
    y[[3, 50]] = np.nan
    y[:, 10] = 0
    evidence = detector.evidence(y, ALPHA)
    b = evidence.b.reshape(y.shape)
    assert (b[[3, 50]] == 0).all()
    assert (b[:, 10] == 0).all()
    read = np.delete(np.delete(y, [3, 50], axis=0), 10, axis=1)
    alone = detector.evidence(read, ALPHA)
    np.testing.assert_allclose(np.delete(np.delete(b, [3, 50], axis=0), 10, axis=1).ravel(), alone.b)
    assert evidence.offset == pytest.approx(alone.offset, rel=1e-12)


@pytest.mark.parametrize("detector", [GgdLrt(), GgdLrt(shape="ml"), Linear()])
def test_weights_do_not_depend_on_the_unit_of_the_grey_levels(detector):
    y = received(8)
    here, there = detector.evidence(y, ALPHA), detector.evidence(1e4 * y, 1e4 * ALPHA)
    np.testing.assert_allclose(there.b / there.scale, here.b / here.scale, rtol=1e-6)
