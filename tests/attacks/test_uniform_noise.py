"""Uniform noise of the LIRIS benchmark: its bound, its shape, and one unit for all noise."""

import numpy as np
import pytest
from scipy.stats import kstest
from shapes import blob, icosphere

from wm3d.attacks import GaussianNoise, UniformNoise

MESH = blob(2, 5)


def test_every_coordinate_is_uniform_within_its_share_of_the_mean_radius():
    noisy = UniformNoise(percent=0.5)(MESH, np.random.default_rng(1))
    radius = np.linalg.norm(MESH.vertices - MESH.vertices.mean(axis=0), axis=1).mean()
    noise = (noisy.vertices - MESH.vertices) / (0.005 * radius)
    assert np.abs(noise).max() <= 1 + 1e-9
    # false alarm 1e-6
    assert kstest(noise.ravel(), "uniform", args=(-1, 2)).pvalue > 1e-6


def test_the_common_unit_is_the_deviation_that_is_measured():
    # r̄ = 1 and a diagonal of 2√3, so σ = (A/√3)/(2√3) = A/6
    assert UniformNoise(percent=0.6).sigma_percent(icosphere()) == pytest.approx(0.1, rel=1e-3)
    for attack in (UniformNoise(percent=0.5), GaussianNoise(percent=0.6)):
        noise = attack(MESH, np.random.default_rng(1)).vertices - MESH.vertices
        # 30726 draws: relative standard error at most 0.41 %; five of them, false alarm 1e-6
        assert 100 * noise.std() / MESH.diagonal == pytest.approx(attack.sigma_percent(MESH), rel=0.021)
