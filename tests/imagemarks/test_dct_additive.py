"""The image mark: ±α on every AC coefficient, nothing on DC, nothing on unusable blocks."""

import numpy as np
import pytest

from wm3d.imagemarks import DctAdditive, GgdLrt, Linear
from wm3d.imagemarks.blocks import block_dct
from wm3d.stats import key_signs

RNG = np.random.default_rng(3)
IMAGE = RNG.uniform(0, 255, (24, 32))
SIGNS = key_signs(7, DctAdditive.capacity(IMAGE.shape))


def test_capacity_is_63_signs_a_block():
    assert DctAdditive.capacity((80, 80)) == 6300
    assert SIGNS.size == 63 * 12


def test_every_ac_coefficient_moves_by_alpha_and_no_dc():
    marked = DctAdditive(alpha=0.9).embed(IMAGE, SIGNS)
    change = block_dct(marked) - block_dct(IMAGE)
    np.testing.assert_allclose(change[:, 0], 0, atol=1e-12)
    np.testing.assert_allclose(change[:, 1:], 0.9 * SIGNS.reshape(12, 63), atol=1e-12)


def test_blocks_with_an_unusable_pixel_are_neither_marked_nor_read():
    usable = np.ones(IMAGE.shape, bool)
    usable[0, 0] = usable[10, 20] = False
    image = np.where(usable, IMAGE, 1e6)  # what such a pixel holds must not matter
    mark = DctAdditive()
    marked = mark.embed(image, SIGNS, usable)
    skipped = np.zeros(IMAGE.shape, bool)
    skipped[:8, :8] = skipped[8:16, 16:24] = True
    np.testing.assert_array_equal(marked[skipped], image[skipped])
    assert (marked[~skipped] != image[~skipped]).mean() > 0.99

    b = mark.evidence(marked, usable).b.reshape(12, 63)
    assert (b[[0, 6]] == 0).all()
    assert (np.delete(b, [0, 6], axis=0) != 0).all()
    elsewhere = np.delete(block_dct(IMAGE)[:, 1:], [0, 6], axis=0) + 1.3 * np.delete(
        SIGNS.reshape(12, 63), [0, 6], axis=0
    )
    expected = mark.detector.evidence(elsewhere, mark.alpha).b.reshape(10, 63)
    np.testing.assert_allclose(np.delete(b, [0, 6], axis=0), expected, rtol=1e-9)


def test_an_image_without_a_usable_block_tells_nothing():
    evidence = DctAdditive().evidence(IMAGE, np.zeros(IMAGE.shape, bool))
    assert (evidence.b == 0).all()
    assert evidence.score(SIGNS).p_value == 1


@pytest.mark.parametrize("detector", [GgdLrt(), GgdLrt(shape="ml"), Linear()], ids=lambda d: d.label())
def test_mark_in_a_noise_image_is_found_and_other_keys_are_not(detector):
    # white noise of standard deviation 6: the linear correlator's z is near 1.3 √6300 / 6 = 17
    image = np.random.default_rng(4).normal(0, 6, (80, 80))
    mark = DctAdditive(detector=detector)
    signs = key_signs(11, mark.capacity((80, 80)))
    evidence = mark.evidence(mark.embed(image, signs))
    assert evidence.score(signs).z > 10
    # the largest of 100 wrong keys: above 5.6 with probability 1e-6
    assert max(evidence.score(key_signs(k, signs.size)).z for k in range(100, 200)) < 5.6
