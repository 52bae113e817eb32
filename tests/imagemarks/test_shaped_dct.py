"""The shaped block-DCT mark: the activity model, the amplitudes, the detector, what an embedder climbs."""

from unittest.mock import patch

import numpy as np
import pytest
from scipy.stats import laplace

from wm3d.imagemarks.blocks import AC, block_dct, inverse_block_dct
from wm3d.imagemarks.shaped_dct import (
    LEAST_AREA,
    MARGIN,
    MOST_AMPLITUDE,
    SHAPING,
    Agreement,
    ShapedDct,
    activity_scale,
)
from wm3d.stats import key_signs, key_signs_batch

ROWS, COLUMNS = 64, 96
BLOCKS = ROWS * COLUMNS // 64


def model(blocks: int, seed: int) -> np.ndarray:
    """Activities that span a factor of a hundred times a profile that falls tenfold: (blocks, 63)."""
    rng = np.random.default_rng(seed)
    return 10 ** rng.uniform(-1, 1, (blocks, 1)) * 10 ** -np.linspace(0, 1, AC)


def host(seed: int = 0) -> np.ndarray:
    """Laplacian coefficients of that model, and blocks that differ in their mean, as an image."""
    rng = np.random.default_rng([seed, 1])
    coefficients = rng.uniform(50, 60, (BLOCKS, AC + 1))
    coefficients[:, 1:] = rng.laplace(size=(BLOCKS, AC)) * model(BLOCKS, seed)
    return inverse_block_dct(coefficients, (ROWS, COLUMNS))


VOLUMES = host()
AREAS = np.random.default_rng(2).uniform(0.5, 1.5, VOLUMES.shape)
MARK = ShapedDct.of(VOLUMES, AREAS)


def test_activity_scale_is_exact_where_sizes_are_a_product():
    scale = model(50, 3)
    signs = key_signs(1, scale.size).reshape(scale.shape)
    np.testing.assert_allclose(activity_scale(scale * signs), scale, rtol=1e-12)


def test_activity_scale_recovers_the_model_behind_laplacian_coefficients():
    scale = model(300, 4)
    error = np.log(activity_scale(scale * np.random.default_rng(5).laplace(size=scale.shape)) / scale)
    # |y| over its mean has the variance 1: a block averages 63 of them, a frequency 300
    expected = np.sqrt(1 / 63 + 1 / 300)
    assert np.sqrt((error**2).mean()) == pytest.approx(expected, rel=0.2)


def test_activity_scale_keeps_silent_blocks_and_frequencies_out_of_the_means():
    scale = model(50, 6)
    silent = scale.copy()
    silent[[3, 17]] = 0
    silent[:, [5, 62]] = 0
    np.testing.assert_allclose(activity_scale(silent), silent, rtol=1e-12)
    assert (activity_scale(np.zeros((4, AC))) == 0).all()


def test_coefficients_and_response_are_read_from_the_image():
    np.testing.assert_array_equal(MARK.received, block_dct(VOLUMES)[:, 1:])
    np.testing.assert_array_equal(MARK.scale, activity_scale(MARK.received))
    means = [AREAS[i : i + 8, j : j + 8].mean() for i in range(0, ROWS, 8) for j in range(0, COLUMNS, 8)]
    np.testing.assert_allclose(MARK.response, MARK.amplitude * np.array(means)[:, None], rtol=1e-12)


def test_amplitude_falls_with_a_power_of_the_contrast_up_to_a_limit():
    area = MARK.response / MARK.amplitude
    contrast = MARK.scale / area
    expected = (np.median(contrast) / contrast) ** SHAPING
    np.testing.assert_allclose(MARK.amplitude, np.minimum(expected, MOST_AMPLITUDE), rtol=1e-12)
    assert np.median(MARK.amplitude) == pytest.approx(1, rel=0.01)
    assert MARK.amplitude.max() == MOST_AMPLITUDE


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_unit_of_length_does_not_matter(unit):
    other = ShapedDct.of(unit**3 * VOLUMES, unit**2 * AREAS)
    np.testing.assert_allclose(other.amplitude, MARK.amplitude, rtol=1e-9)
    np.testing.assert_allclose(other.evidence(0.1 * unit).b, MARK.evidence(0.1).b, rtol=1e-6, atol=1e-12)


def test_pattern_is_the_amplitude_with_the_signs_of_the_key_and_no_mean():
    signs = key_signs(7, BLOCKS * AC)
    pattern = MARK.pattern(signs)
    assert pattern.shape == (BLOCKS, AC + 1)
    assert (pattern[:, 0] == 0).all()
    np.testing.assert_array_equal(pattern[:, 1:], MARK.amplitude * signs.reshape(BLOCKS, AC))


def marked(strength: float, seed: int) -> ShapedDct:
    """The host with a mark of some strength in every coefficient."""
    signs = key_signs(seed, BLOCKS * AC)
    change = AREAS * strength * inverse_block_dct(MARK.pattern(signs), VOLUMES.shape)
    return ShapedDct.of(VOLUMES + change, AREAS)


def test_evidence_is_odd_in_the_image():
    evidence, opposite = MARK.evidence(0.05), ShapedDct.of(-VOLUMES, AREAS).evidence(0.05)
    np.testing.assert_allclose(opposite.b, -evidence.b, rtol=1e-9)
    assert evidence.offset == opposite.offset == 0
    assert (np.sign(evidence.b) == np.sign(MARK.received.ravel())).all()


def test_a_key_scores_the_sign_that_bayes_expects_of_each_coefficient():
    a, strength = 0.7, 0.35
    received = laplace(scale=2.0).rvs(size=(BLOCKS, AC), random_state=9)
    ones = np.ones_like(received)
    mark = ShapedDct(received, ones, 2.0 * ones, ones)
    # any scale will do here, if only all coefficients have the same
    with patch.object(ShapedDct, "_unmarked_scale", return_value=2.0 * ones):
        b = mark.evidence(strength).b.reshape(received.shape)
    plus, minus = (laplace(loc=sign * a, scale=2.0).pdf(received) for sign in (1, -1))
    np.testing.assert_allclose(b, (plus - minus) / (plus + minus), rtol=1e-9, atol=1e-15)


def test_scale_is_that_of_the_host_under_the_mark():
    strength = 0.2
    mark = marked(strength, 12)
    there = mark._unmarked_scale(strength * mark.response)

    def error(scale):
        return float(np.median(np.abs(np.log(scale / MARK.scale))))

    # the mark is half as large as the host, and adds to the size of what is received
    assert error(mark.scale) > 0.4
    assert error(there) < 0.5 * error(mark.scale)


def test_blocks_without_surface_carry_nothing_and_are_not_read():
    volumes, areas = VOLUMES.copy(), AREAS.copy()
    volumes[:8, :8] = areas[:8, :8] = 0  # beyond the model
    areas[8:16, :8] *= 0.9 * LEAST_AREA  # a few slivers
    volumes[16:24, :8] = 3.0  # a smooth piece, without any AC
    mark = ShapedDct.of(volumes, areas)
    silent = [0, COLUMNS // 8, 2 * COLUMNS // 8]
    assert np.flatnonzero(~mark.carries).tolist() == silent
    assert (mark.response[silent] == 0).all()
    assert (mark.pattern(key_signs(1, BLOCKS * AC))[silent] == 0).all()
    b = mark.evidence(0.05).b.reshape(BLOCKS, AC)
    assert (b[silent] == 0).all()
    assert (np.delete(b, silent, axis=0) != 0).all()


@pytest.mark.parametrize(
    ("volumes", "areas"), [(np.zeros((8, 16)), np.zeros((8, 16))), (np.ones((8, 16)), np.ones((8, 16)))]
)
def test_empty_or_flat_image_carries_nothing(volumes, areas):
    mark = ShapedDct.of(volumes, areas)
    assert not mark.carries.any()
    assert mark.evidence(1.0).score(key_signs(1, 2 * AC)).p_value == 1


def test_moves_that_the_mark_asks_for_are_found_and_other_keys_are_not():
    signs, strength = key_signs(11, BLOCKS * AC), 0.05
    moved = VOLUMES + AREAS * strength * inverse_block_dct(MARK.pattern(signs), VOLUMES.shape)
    evidence = ShapedDct.of(moved, AREAS).evidence(strength)
    assert evidence.score(signs).z > 10
    z = key_signs_batch(range(1000, 3000), BLOCKS * AC) @ evidence.b / evidence.scale
    # five standard errors of mean and variance each: 1.2e-6 false alarms; the largest of 2000: 1e-6
    assert abs(z.mean()) < 5 / np.sqrt(2000)
    assert abs(z.var() - 1) < 5 * np.sqrt(2 / 2000)
    assert z.max() < 6.2


def value(agreement: Agreement, coefficients: np.ndarray) -> float:
    margin = agreement.per_margin * coefficients
    return float((agreement.weight * margin / np.sqrt(1 + margin**2)).sum())


def agreement_of_a_key() -> Agreement:
    signs = key_signs(13, BLOCKS * AC)
    change = 0.05 * MARK.response * signs.reshape(BLOCKS, AC)
    agreement = Agreement.of(MARK, signs, change)
    assert agreement is not None
    return agreement


def test_margin_is_measured_in_the_amplitude_of_the_pattern():
    agreement, amplitude = agreement_of_a_key(), 0.05 * MARK.response
    np.testing.assert_allclose(np.abs(agreement.per_margin), 1 / (MARGIN * amplitude), rtol=1e-12)
    np.testing.assert_allclose(agreement.weight, np.minimum(1, amplitude / MARK.scale), rtol=1e-12)


def test_gradient_is_the_slope_of_the_agreement_and_curvature_bounds_its_change():
    agreement, y = agreement_of_a_key(), MARK.received
    direction = np.random.default_rng(14).normal(size=y.shape) * MARK.scale
    step = 1e-6
    rise = value(agreement, y + step * direction) - value(agreement, y - step * direction)
    assert rise / (2 * step) == pytest.approx((agreement.gradient(y) * direction).sum(), rel=1e-6)
    change = agreement.gradient(y + direction) - agreement.gradient(y)
    assert (np.abs(change) <= agreement.curvature * np.abs(direction)).all()


def test_pattern_that_moves_the_image_the_wrong_way_has_no_agreement():
    signs = key_signs(13, BLOCKS * AC)
    assert Agreement.of(MARK, signs, -0.05 * MARK.response * signs.reshape(BLOCKS, AC)) is None
