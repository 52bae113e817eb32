"""The whole-image DCT mark: ±α on the lowest coefficients and on no other."""

import numpy as np
import pytest
from scipy.fft import dct

from wm3d.imagemarks import Cox, GgdLrt
from wm3d.stats import key_signs

IMAGE = np.random.default_rng(1).uniform(0, 255, (16, 24))
ROWS, COLUMNS = (dct(np.eye(n), axis=0, norm="ortho") for n in IMAGE.shape)


def test_the_lowest_coefficients_move_by_alpha_in_zig_zag_order():
    mark, signs = Cox(alpha=2.5, count=5), [1, -1, -1, 1, 1]
    change = ROWS @ (mark.embed(IMAGE, np.array(signs)) - IMAGE) @ COLUMNS.T
    expected = np.zeros(IMAGE.shape)
    for place, sign in zip([(0, 1), (1, 0), (2, 0), (1, 1), (0, 2)], signs, strict=True):
        expected[place] = 2.5 * sign
    np.testing.assert_allclose(change, expected, atol=1e-12)


def test_an_image_with_fewer_coefficients_has_all_but_the_mean_marked():
    mark = Cox(alpha=2.0)
    assert mark.capacity(IMAGE.shape) == 16 * 24 - 1
    assert mark.capacity((80, 80)) == 1000
    change = mark.embed(IMAGE, key_signs(3, 383)) - IMAGE
    assert change.mean() == pytest.approx(0, abs=1e-12)
    np.testing.assert_allclose(np.sort(np.abs(ROWS @ change @ COLUMNS.T).ravel())[1:], 2.0, atol=1e-12)


def test_coefficients_of_one_anti_diagonal_share_their_scale():
    mark = Cox(count=9)
    received = ROWS @ IMAGE @ COLUMNS.T
    diagonals = [
        [received[0, 1], received[1, 0]],
        [received[2, 0], received[1, 1], received[0, 2]],
        [received[0, 3], received[1, 2], received[2, 1], received[3, 0]],
    ]
    parts = [GgdLrt().evidence(np.array(diagonal)[:, None], mark.alpha) for diagonal in diagonals]
    evidence = mark.evidence(IMAGE)
    np.testing.assert_allclose(evidence.b, np.concatenate([part.b for part in parts]), rtol=1e-10)
    assert evidence.offset == pytest.approx(sum(part.offset for part in parts), rel=1e-10)
