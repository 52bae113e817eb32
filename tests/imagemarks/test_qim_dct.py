"""Quantization index modulation: coefficients land on the lattice of their sign, and are read from there."""

import numpy as np
import pytest

from wm3d.imagemarks import QimDct
from wm3d.imagemarks.blocks import block_dct, inverse_block_dct
from wm3d.stats import key_signs

IMAGE = np.random.default_rng(1).uniform(0, 255, (24, 32))
MARK = QimDct(step=10.0, frequencies=3)
PLACES = [1, 8, 16]  # (0, 1), (1, 0) and (2, 0): the lowest three in zig-zag order
SIGNS = key_signs(7, MARK.capacity(IMAGE.shape))
DITHER = np.arange(SIGNS.size) * (np.sqrt(5) - 1) / 2


def test_coefficients_land_on_the_nearest_point_of_the_lattice_of_their_sign():
    before, after = block_dct(IMAGE), block_dct(MARK.embed(IMAGE, SIGNS))
    phase = after[:, PLACES].ravel() / 10 - DITHER - SIGNS / 4
    np.testing.assert_allclose(phase, np.rint(phase), atol=1e-9)
    assert np.abs(after - before)[:, PLACES].max() <= 5 + 1e-9
    np.testing.assert_allclose(np.delete(after - before, PLACES, axis=1), 0, atol=1e-9)


def test_the_statistic_is_the_difference_of_squared_distances_by_enumeration():
    points = 10 * (np.arange(-100, 100)[:, None] + DITHER % 1)
    received = block_dct(IMAGE)[:, PLACES].ravel()
    minus, plus = (np.abs(received - points - shift).min(axis=0) for shift in (-2.5, 2.5))
    np.testing.assert_allclose(MARK.evidence(IMAGE).b, (minus**2 - plus**2) / 100, atol=1e-9)


def test_an_undisturbed_mark_is_read_without_a_wrong_sign():
    b = MARK.evidence(MARK.embed(IMAGE, SIGNS)).b
    np.testing.assert_allclose(b, SIGNS / 4, atol=1e-9)  # the other lattice is Δ/2 away


@pytest.mark.parametrize("error", [-0.2, 0.2, 0.3])
def test_a_sign_flips_when_its_coefficient_moves_by_more_than_a_quarter_of_the_step(error):
    coefficients = block_dct(MARK.embed(IMAGE, SIGNS))
    coefficients[:, PLACES] += error * MARK.step
    b = MARK.evidence(inverse_block_dct(coefficients, IMAGE.shape)).b
    assert (np.sign(b) == SIGNS).all() == (abs(error) < 0.25)
