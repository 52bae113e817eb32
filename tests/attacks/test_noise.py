"""Gaussian noise: its two amplitudes, and that it is Gaussian, independent and centred."""

import numpy as np
import pytest
from scipy.stats import kstest
from shapes import blob

from wm3d.attacks import GaussianNoise, kernels

MESH = blob(2, 5)


@pytest.mark.parametrize(
    ("amplitude", "rms_percent"), [("rms-vector", 0.6), ("per-axis", 0.6 * np.sqrt(3))]
)  # fmt: skip
def test_amplitude_is_a_share_of_the_diagonal(amplitude, rms_percent):
    noisy = GaussianNoise(percent=0.6, amplitude=amplitude)(MESH, np.random.default_rng(1))
    noise = noisy.vertices - MESH.vertices
    diagonal = np.linalg.norm(MESH.vertices.max(axis=0) - MESH.vertices.min(axis=0))
    sigma = rms_percent / 100 * diagonal / np.sqrt(3)
    # 30726 draws: the rms has a relative standard error of 0.4 %; six of them, false alarm 2e-9
    assert np.sqrt(np.mean(np.sum(noise**2, axis=1))) == pytest.approx(np.sqrt(3) * sigma, rel=0.024)
    # false alarm 1e-6 each
    assert kstest(noise.ravel() / sigma, "norm").pvalue > 1e-6
    assert np.abs(np.corrcoef(noise.T) - np.eye(3)).max() < 5 / np.sqrt(len(noise))


def test_noise_is_the_same_share_at_any_scale_and_the_same_draw_at_any_strength():
    weak, strong = (GaussianNoise(percent=p)(MESH, np.random.default_rng(3)) for p in (0.1, 0.4))
    np.testing.assert_allclose(
        strong.vertices - MESH.vertices, 4 * (weak.vertices - MESH.vertices), atol=1e-14
    )
    big = GaussianNoise(percent=0.1)(MESH.with_vertices(1000 * MESH.vertices), np.random.default_rng(3))
    np.testing.assert_allclose(big.vertices, 1000 * weak.vertices, rtol=1e-12)


def test_the_kernel_draws_what_numpy_draws_bit_for_bit():
    noisy = kernels.with_noise(MESH.vertices, 0.3, np.random.default_rng(4))
    noise = np.random.default_rng(4).standard_normal(MESH.vertices.shape)
    np.testing.assert_array_equal(noisy, MESH.vertices + 0.3 * noise)
