"""Simulated print and scan: the staircase on a cone, its bound, and each part on its own."""

import numpy as np
import pytest
from shapes import blob, lathe

from wm3d.attacks import PrintScan
from wm3d.mesh import signed_volume, volume_moments

MESH = blob(2, 4)
STAIRS = PrintScan(smoothing=0, noise_percent=0, tilt_degrees=0)


def test_a_layer_moves_no_vertex_by_more_than_half_of_it():
    printed = STAIRS.model_copy(update={"layer_percent": 1.0})(MESH, np.random.default_rng(1))
    moved = np.linalg.norm(printed.vertices - MESH.vertices, axis=1)
    layer = 0.01 * MESH.diagonal
    assert moved.max() <= 0.5 * layer
    assert moved.max() > 0.3 * layer
    assert signed_volume(printed) == pytest.approx(signed_volume(MESH), rel=2e-3)  # as often out as in


def test_a_cone_becomes_steps_with_upright_walls():
    # slope 45°: radius and height have the same step, layers of eight rings
    rings = np.linspace(0, 1, 401)
    cone = lathe(np.r_[0, rings], np.r_[0, 1 - rings], 64)
    layer = 8 / 400
    printed = STAIRS.model_copy(update={"layer_percent": 100 * layer / cone.diagonal})(
        cone, np.random.default_rng(1)
    )
    inside = slice(1 + 64 * 40, 1 + 64 * 360)
    height = cone.vertices[inside, 2]
    offset = height - layer * (np.floor(height / layer + 1e-9) + 0.5)
    away = np.abs(np.abs(offset) - layer / 2) > 1e-9  # on the edge of a layer rounding decides
    radius = np.linalg.norm(printed.vertices[inside, :2], axis=1)
    # along the normal (1, 1)/√2 by offset/√2: half of the way to the wall outwards, half upwards
    np.testing.assert_allclose((radius - (1 - height))[away], offset[away] / 2, atol=2e-5)
    np.testing.assert_allclose((printed.vertices[inside, 2] - height)[away], offset[away] / 2, atol=2e-5)


def test_tilt_alone_is_a_rotation_within_its_angle():
    attack = PrintScan(layer_percent=0, smoothing=0, noise_percent=0, tilt_degrees=10)
    angles = []
    for seed in range(20):
        turned = attack(MESH, np.random.default_rng(seed))
        center = MESH.vertices.mean(axis=0)
        rotation = np.linalg.lstsq(MESH.vertices - center, turned.vertices - center, rcond=None)[0]
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
        angles.append(np.degrees(np.arccos((np.trace(rotation) - 1) / 2)))
    assert max(angles) <= 10
    # twenty uniform angles all below 3° or all above 7°: 2 · 0.3²⁰ = 7e-11
    assert min(angles) < 7
    assert max(angles) > 3


def test_the_noise_is_the_share_of_the_diagonal():
    attack = STAIRS.model_copy(update={"layer_percent": 0.0, "noise_percent": 0.1})
    noise = attack(MESH, np.random.default_rng(1)).vertices - MESH.vertices
    # 7686 draws: relative standard error 0.81 %; five of them, false alarm 6e-7
    assert 100 * noise.std() / MESH.diagonal == pytest.approx(0.1, rel=0.041)


def test_all_of_it_still_is_the_model():
    scan = PrintScan(tilt_degrees=0)(MESH, np.random.default_rng(1))
    before, after = volume_moments(MESH), volume_moments(scan)
    assert after.volume == pytest.approx(before.volume, rel=0.02)
    assert np.linalg.norm(after.centroid - before.centroid) < 2e-3 * MESH.diagonal
