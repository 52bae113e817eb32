"""The wavelet mark: ±α on the chosen details, nothing on any other coefficient."""

import numpy as np
import pytest
import pywt

from wm3d.errors import Wm3dError
from wm3d.imagemarks import IMAGEMARKS, DwtAdditive
from wm3d.stats import key_signs

IMAGE = np.random.default_rng(1).uniform(0, 255, (32, 64))


@pytest.mark.parametrize("wavelet", ["haar", "db2", "db4", "sym4"])
@pytest.mark.parametrize("levels", [(1,), (3,), (1, 3), (1, 2, 3)])
def test_chosen_details_move_by_alpha_and_the_energy_is_that_of_the_signs(wavelet, levels):
    mark = DwtAdditive(alpha=1.5, levels=levels, wavelet=wavelet)
    signs = key_signs(5, mark.capacity(IMAGE.shape))
    change = mark.embed(IMAGE, signs) - IMAGE
    assert (change**2).sum() == pytest.approx(1.5**2 * signs.size, rel=1e-10)

    found, smooth = [], change
    for level in (1, 2, 3):
        smooth, details = pywt.dwt2(smooth, wavelet, mode="periodization")
        if level in levels:
            found += [subband.ravel() for subband in details]
        else:
            np.testing.assert_allclose(details, 0, atol=1e-10)
    np.testing.assert_allclose(smooth, 0, atol=1e-10)
    np.testing.assert_allclose(np.concatenate(found), 1.5 * signs, atol=1e-10)


def test_haar_details_of_the_first_level_are_differences_in_squares_of_four():
    mark = DwtAdditive(alpha=2.0, levels=(1,), wavelet="haar")
    signs = np.ones(mark.capacity((8, 8)), int)
    change = mark.embed(np.zeros((8, 8)), signs)
    # α/2 times the sum of the patterns [+ +; − −], [+ −; + −] and [+ −; − +]
    np.testing.assert_allclose(change, np.tile([[3.0, -1.0], [-1.0, -1.0]], (4, 4)), atol=1e-10)


def test_a_sign_has_a_place_where_its_wavelet_touches_usable_pixels_only():
    usable = np.ones(IMAGE.shape, bool)
    usable[9, 20] = usable[31, 0] = False
    for wavelet in ("haar", "db4"):
        mark = DwtAdditive(wavelet=wavelet)
        touches = [
            (mark.embed(np.zeros(IMAGE.shape), row)[~usable] != 0).any()
            for row in np.eye(mark.capacity(IMAGE.shape))
        ]
        np.testing.assert_array_equal(mark.carried(usable), ~np.array(touches))


def test_levels_are_a_set():
    assert DwtAdditive(levels=(3, 1, 3)) == DwtAdditive(levels=(1, 3))
    with pytest.raises(Wm3dError, match=r"levels.0 = 4: input should be less than or equal to 3"):
        IMAGEMARKS.build("dwt-additive", {"levels": [4]})
