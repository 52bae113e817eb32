"""Fine signs: the values that say them, the sign to expect of a phase, and when a layer is not read."""

import numpy as np
import pytest
from scipy.special import ive
from scipy.stats import vonmises

from wm3d.imagemarks.blocks import AC
from wm3d.imagemarks.fine_signs import LAYERS, FineSigns, _kappa
from wm3d.imagemarks.shaped_dct import ShapedDct
from wm3d.stats import RademacherSum, key_signs

BLOCKS = 40
STEP = np.random.default_rng(0).uniform(0.5, 2, (BLOCKS, 1))
FINE = FineSigns(STEP)
SIGNS = key_signs(1, FINE.capacity)


def read(received: np.ndarray, fine: FineSigns = FINE) -> np.ndarray:
    """Expected signs by layer, of coefficients of a host that is wide enough: (LAYERS, blocks, 63)."""
    ones = np.ones_like(received)
    mark = ShapedDct(received, 5 * ones, ones[:, :1], ones)
    return fine.expected(mark).reshape(LAYERS, -1, AC)


def host(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).laplace(scale=5, size=(BLOCKS, AC))


def score(expected: np.ndarray, signs: np.ndarray = SIGNS) -> np.ndarray:
    """z of each layer, 0 for one that is not read."""
    layers = signs.reshape(expected.shape)
    return np.array(
        [RademacherSum(0.0, b.ravel()).score(w.ravel()).z for b, w in zip(expected, layers, strict=True)]
    )


def test_nearest_values_say_the_signs_and_lie_within_half_a_step():
    received = host(2)
    nearest = FINE.nearest(received, SIGNS)
    assert (np.abs(nearest - received) <= STEP / 2 + 1e-12).all()
    for layer, signs in enumerate(SIGNS.reshape(LAYERS, BLOCKS, AC)):
        assert (np.sign(np.sin(2 * np.pi * 4**layer * nearest / STEP)) == signs).all()
    # as far on average as to one value in every step: Δ/√12, whatever the host is
    assert (((nearest - received) / STEP) ** 2).mean() == pytest.approx(1 / 12, rel=0.05)
    np.testing.assert_allclose(FINE.nearest(nearest, SIGNS), nearest, rtol=0, atol=1e-12)


def test_every_fine_sign_counts_where_nothing_was_lost():
    expected = read(FINE.nearest(host(3), SIGNS))
    assert (np.sign(expected).ravel() == SIGNS).all()
    np.testing.assert_allclose(score(expected), np.sqrt(BLOCKS * AC), rtol=0.01)


def test_layers_fall_silent_one_after_the_other_as_noise_grows():
    marked, rng = FINE.nearest(host(4), SIGNS), np.random.default_rng(5)
    silent = [
        [(layer == 0).all() for layer in read(marked + share * STEP * rng.normal(size=marked.shape))]
        for share in (0, 0.03, 0.12, 1)
    ]
    assert silent == [
        [False, False, False],
        [False, False, True],
        [False, True, True],
        [True, True, True],
    ]


def test_an_unmarked_image_of_a_wide_host_says_nothing():
    # a layer that is not there is read with a chance of 3e-5: four standard deviations
    assert all((read(host(seed)) == 0).all() for seed in range(6, 26))


def test_sign_is_the_one_that_bayes_expects_of_a_phase():
    kappa, plus = 1.7, vonmises(kappa=1.7, loc=np.pi / 2)
    signs = key_signs(7, BLOCKS * AC).reshape(BLOCKS, AC)
    phase = signs * plus.rvs(size=signs.shape, random_state=8)
    found = read(phase * STEP / (2 * np.pi))[0]
    there, opposite = plus.pdf(phase), plus.pdf(-phase)
    np.testing.assert_allclose(found, (there - opposite) / (there + opposite), atol=0.05)
    doubled = -np.cos(2 * phase)
    assert _kappa(doubled) == pytest.approx(kappa, rel=0.1)
    exact = np.full(1000, ive(2, kappa) / ive(0, kappa))
    assert _kappa(exact) == pytest.approx(kappa, rel=1e-9)


def test_few_coefficients_must_say_it_more_clearly():
    # 504 of them: with a mean of 0.05 asked for alone, one layer in eighteen would be read
    few = FineSigns(STEP[:8])
    assert all((read(host(seed)[:8], few) == 0).all() for seed in range(200, 260))  # 3e-5 a layer


def test_what_reaches_no_phase_but_one_does_not_dull_the_others():
    marked = FINE.nearest(host(12), SIGNS)
    still = np.arange(BLOCKS)[:, None] % 2 == 0  # flat blocks, all of whose coefficients are about 0
    received = np.where(still, 1e-3 * STEP, marked)
    ones = np.ones_like(received)
    mark = ShapedDct(received, np.where(still, 1e-3, 5.0) * ones, ones[:, :1], ones)
    expected = FINE.expected(mark).reshape(LAYERS, BLOCKS, AC)
    np.testing.assert_allclose(expected[:, 1::2], read(marked)[:, 1::2], rtol=0.05)


def test_a_wrong_key_scores_nothing():
    expected = read(FINE.nearest(host(9), SIGNS))
    wrong = score(expected, key_signs(10, FINE.capacity))
    assert (np.abs(wrong) < 5).all()  # 2e-6 false alarm for three normal scores


def test_blocks_without_a_step_carry_nothing():
    some = FineSigns(np.where(np.arange(BLOCKS)[:, None] % 2, STEP, 0))
    received = host(11)
    nearest = some.nearest(received, SIGNS)
    np.testing.assert_array_equal(nearest[::2], received[::2])
    expected = read(nearest, some)
    assert (expected[:, ::2] == 0).all()
    assert (expected[:, 1::2] != 0).all()
    assert (read(received, FineSigns(np.zeros((BLOCKS, 1)))) == 0).all()
