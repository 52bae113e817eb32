"""Similarity transforms: shape kept, orientation kept, every range of the draw respected and filled."""

import numpy as np
import pytest
from scipy.stats import kstest
from shapes import box

from wm3d.attacks import Similarity
from wm3d.mesh import signed_volume

MESH = box((3, 2, 1))


def test_shape_and_orientation_are_kept_and_draws_fill_their_ranges():
    attack, rng = Similarity(min_scale=0.5, max_scale=4, translation=2), np.random.default_rng(1)
    pairs = np.triu_indices(8, 1)
    distances = np.linalg.norm(MESH.vertices[pairs[0]] - MESH.vertices[pairs[1]], axis=1)
    mean_radius = np.linalg.norm([3, 2, 1]) / 2
    scales, shifts, axes = [], [], []
    for _ in range(300):
        result = attack(MESH, rng)
        ratios = np.linalg.norm(result.vertices[pairs[0]] - result.vertices[pairs[1]], axis=1) / distances
        np.testing.assert_allclose(ratios, ratios[0], rtol=1e-12)
        assert signed_volume(result) == pytest.approx(6 * ratios[0] ** 3, rel=1e-10)
        scales.append(ratios[0])
        shifts.append(result.vertices.mean(axis=0) / mean_radius)  # the box is centred on the origin
        axes.append((result.vertices[7] - result.vertices[3])[2] / (3 * ratios[0]))
    # uniform scale, shift and, by Archimedes, cosine of a random direction; false alarm 1e-6 each
    assert kstest(scales, "uniform", (0.5, 3.5)).pvalue > 1e-6
    assert kstest(np.ravel(shifts), "uniform", (-2, 4)).pvalue > 1e-6
    assert kstest(axes, "uniform", (-1, 2)).pvalue > 1e-6
    assert np.abs(np.corrcoef(np.transpose(shifts)) - np.eye(3)).max() < 5 / np.sqrt(300)
    assert min(scales) >= 0.5
    assert max(scales) <= 4
    assert np.abs(shifts).max() <= 2


def test_without_scale_and_translation_it_is_a_rotation():
    result = Similarity(min_scale=1, max_scale=1, translation=0)(MESH, np.random.default_rng(2))
    np.testing.assert_allclose(
        np.linalg.norm(result.vertices, axis=1), np.linalg.norm(MESH.vertices, axis=1), rtol=1e-14
    )
    assert np.abs(result.vertices - MESH.vertices).max() > 0.1
