"""What every image mark owes: signs where it says, an exact null, and eyes only for usable pixels."""

import numpy as np
import pytest
from scipy.stats import kstest

from wm3d.errors import Wm3dError
from wm3d.imagemarks import IMAGEMARKS, Cox, DctAdditive, DwtAdditive, GgdLrt, ImageMark, Linear, QimDct
from wm3d.stats import key_signs

VARIANTS = [
    *(cls() for cls in IMAGEMARKS.values()),
    Cox(detector=Linear()),
    DwtAdditive(wavelet="haar", levels=(1,), detector=GgdLrt(shape="ml")),
    QimDct(frequencies=63),
]
WAVES = np.random.default_rng(0).normal(size=(6, 2)) / 25
PLANE = np.indices((40, 48)).reshape(2, -1)
HOST = np.cos(WAVES @ PLANE + np.arange(6)[:, None]).sum(axis=0).reshape(40, 48)  # smooth, like a surface
IMAGE = 255 * (HOST - HOST.min()) / np.ptp(HOST) + np.random.default_rng(1).normal(0, 1, HOST.shape)
USABLE = np.ones(IMAGE.shape, bool)
USABLE[5:20, 30:41] = False


def every_mark(marks: list[ImageMark]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("mark", marks, ids=lambda mark: mark.label())


@every_mark(VARIANTS)
def test_mark_is_a_value_that_its_parameters_rebuild(mark):
    assert IMAGEMARKS.build(mark.name, mark.parameters()) == mark
    assert hash(mark) == hash(mark.model_copy())


@every_mark(VARIANTS)
def test_right_key_is_found_and_wrong_keys_follow_the_exact_null(mark):
    n = mark.capacity(IMAGE.shape)
    evidence = mark.evidence(mark.embed(IMAGE, key_signs(1, n)))
    assert evidence.b.shape == (n,)
    assert evidence.score(key_signs(1, n)).log10_p < -20
    wrong = [evidence.score(key_signs(seed, n)) for seed in range(100, 400)]
    z = np.array([score.z for score in wrong])
    # five standard errors each, and the p-values uniform at a false-alarm rate of 1e-6
    assert abs(z.mean()) < 5 / np.sqrt(300)
    assert abs(z.var() - 1) < 5 * np.sqrt(2 / 300)
    assert kstest([score.p_value for score in wrong], "uniform").pvalue > 1e-6


@every_mark(VARIANTS)
def test_pixels_that_are_not_usable_are_neither_changed_nor_read(mark):
    signs = key_signs(2, mark.capacity(IMAGE.shape))
    marked = mark.embed(IMAGE, signs, USABLE)
    np.testing.assert_array_equal(marked[~USABLE], IMAGE[~USABLE])
    evidence = mark.evidence(marked, USABLE)
    elsewhere = mark.evidence(np.where(USABLE, marked, 1e4), USABLE)
    np.testing.assert_array_equal(elsewhere.b, evidence.b)
    np.testing.assert_array_equal(evidence.b != 0, mark.carried(USABLE))
    assert evidence.score(signs).log10_p < -10


@every_mark(VARIANTS)
def test_a_mask_that_allows_every_pixel_changes_nothing(mark):
    signs = key_signs(3, mark.capacity(IMAGE.shape))
    everywhere = np.ones_like(USABLE)
    marked = mark.embed(IMAGE, signs)
    np.testing.assert_array_equal(mark.embed(IMAGE, signs, everywhere), marked)
    np.testing.assert_array_equal(mark.evidence(marked, everywhere).b, mark.evidence(marked).b)


@every_mark(VARIANTS)
def test_an_image_without_usable_pixels_tells_nothing(mark):
    nowhere = np.zeros_like(USABLE)
    signs = key_signs(4, mark.capacity(IMAGE.shape))
    assert not mark.carried(nowhere).any()
    np.testing.assert_array_equal(mark.embed(IMAGE, signs, nowhere), IMAGE)
    evidence = mark.evidence(IMAGE, nowhere)
    assert evidence.b.shape == signs.shape
    assert evidence.score(signs).p_value == 1


@every_mark([DctAdditive(), Cox(), DwtAdditive()])
def test_twice_the_strength_is_twice_the_change(mark):
    signs = key_signs(5, mark.capacity(IMAGE.shape))
    change, doubled = (m.embed(IMAGE, signs) - IMAGE for m in (mark, mark.scaled(2.0)))
    np.testing.assert_allclose(doubled, 2 * change, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "parameters", "sentence"),
    [
        ("cox", {"alpha": 0}, "imagemark cox: alpha = 0: "),
        ("cox", {"count": 0}, "imagemark cox: count = 0: "),
        ("dwt-additive", {"levels": []}, "levels = []: "),
        ("dwt-additive", {"wavelet": "bior4.4"}, "wavelet = 'bior4.4': input should be 'haar', 'db2',"),
        ("qim-dct", {"frequencies": 64}, "frequencies = 64: "),
        ("qim-dct", {"alpha": 1}, "unknown parameter 'alpha'"),
        ("qim", {}, "unknown imagemark 'qim'; did you mean 'qim-dct'?"),
    ],
)
def test_wrong_parameters_are_named_in_one_sentence(name, parameters, sentence):
    with pytest.raises(Wm3dError) as refusal:
        IMAGEMARKS.build(name, parameters)
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)
