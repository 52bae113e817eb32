"""Scores and the signs of keys."""

import math

import numpy as np
import pytest

from wm3d.errors import Wm3dError
from wm3d.stats import RademacherSum, key_signs, key_signs_batch


def test_score_is_the_affine_function_of_the_signs():
    score = RademacherSum(10.0, [3.0, 0.0, -4.0]).score([1, -1, -1])
    assert score.statistic == 17.0
    assert score.z == pytest.approx(7 / 5)
    assert score.p_value == pytest.approx(1 / 4)  # two signs count, and both agree with b
    assert score.null.scale == 5.0


@pytest.mark.parametrize("seed", range(3))
def test_the_p_value_of_the_best_of_several_counts_them_all(seed):
    weights, key = np.linspace(1, 3, 40), key_signs(seed, 40)
    alone, best = (RademacherSum(0.0, weights, tries).score(key) for tries in (1, 24))
    assert best.z == alone.z
    assert best.null.log10_p([best.z, 9.0]).tolist() == [best.log10_p, best.null.log10_p(9.0)]
    assert best.p_value == pytest.approx(min(1.0, 24 * alone.p_value))
    assert best.null.log10_p_least == pytest.approx(alone.null.log10_p_least + np.log10(24))
    threshold = best.null.z_at(-6.0)
    above, below = best.null.log10_p([threshold - 1e-6, threshold + 1e-6])
    assert above >= -6.0 >= below


def test_negated_key_negates_z():
    null = RademacherSum(2.0, np.linspace(-1, 3, 100))
    signs = key_signs(3, 100)
    assert null.score(-signs).z == -null.score(signs).z
    assert null.score(-signs).statistic - 2.0 == -(null.score(signs).statistic - 2.0)


def test_uninformative_mesh_never_detects():
    score = RademacherSum(5.0, np.zeros(63)).score(key_signs(1, 63))
    assert (score.z, score.log10_p, score.p_value) == (0.0, 0.0, 1.0)
    assert score.null.log10_p_least == 0.0
    assert not score.detected(pf=0.999)


def test_detection_compares_logarithms_even_where_p_underflows():
    score = RademacherSum(0.0, np.ones(2000)).score(np.ones(2000))
    assert score.log10_p == pytest.approx(-2000 * math.log10(2), rel=1e-12)
    assert score.p_value == 0.0
    assert score.detected(pf=1e-300)
    assert not RademacherSum(0.0, np.ones(10)).score(np.ones(10)).detected(pf=1e-4)  # p = 2^-10
    with pytest.raises(Wm3dError, match="above 0"):
        score.detected(pf=0.0)


def test_least_p_value_is_one_key_in_all():
    null = RademacherSum(0.0, [1.0, -2.0, 0.0, 3.5])
    assert null.score([1, -1, 1, 1]).log10_p == null.log10_p_least == pytest.approx(math.log10(1 / 8))


def test_null_owns_its_weights():
    b = np.ones(4)
    null = RademacherSum(0.0, b)
    b[0] = 7
    assert null.scale == 2.0
    with pytest.raises(ValueError, match="read-only"):
        null.b[0] = 7


@pytest.mark.parametrize(
    ("offset", "b", "signs", "message"),
    [
        (0.0, [1.0, math.nan], [1, 1], r"b\[1\] is nan"),
        (math.inf, [1.0], [1], "offset"),
        (0.0, [[1.0]], [[1]], "one row"),
        (0.0, [1.0, 2.0], [1], "shape"),
        (0.0, [1.0, 2.0], [1, 0], "signs"),
    ],
)
def test_bad_input_is_named(offset, b, signs, message):
    with pytest.raises(Wm3dError, match=message):
        RademacherSum(offset, b).score(signs)


def test_key_of_a_seed_is_frozen():
    # golden: a mesh marked today must be found by any later release
    assert "".join("-+"[(s + 1) // 2] for s in key_signs(7, 40)) == "++-+---+-+-+--+-+-+--++++---+++++--+-+-+"
    assert (
        "".join("-+"[(s + 1) // 2] for s in key_signs(2**255 + 9, 40))
        == "-+-+-+----++--+--+-+----+----++-++-+-+-+"
    )


def test_keys_are_balanced_and_uncorrelated():
    keys = key_signs_batch(range(400), 1000).astype(float)
    assert set(np.unique(keys)) == {-1.0, 1.0}
    # 5.5 sigma: a false alarm of 4e-8 each
    assert abs(keys.mean()) < 5.5 / math.sqrt(keys.size)
    products = (keys @ keys.T)[np.triu_indices(400, 1)] / math.sqrt(1000)
    assert abs(products.mean()) < 5.5 / math.sqrt(products.size)
    assert abs(np.var(products) - 1) < 5.5 * math.sqrt(2 / products.size)


def test_batch_rows_and_longer_keys_agree_with_single_keys():
    batch = key_signs_batch([5, 2**200, 5], 130)
    assert np.array_equal(batch[1], key_signs(2**200, 130))
    assert np.array_equal(batch[0], batch[2])
    assert np.array_equal(key_signs(5, 64), batch[0, :64])
    assert key_signs_batch([], 9).shape == (0, 9)


@pytest.mark.parametrize(("seed", "n"), [(-1, 4), (1, -4)])
def test_negative_seed_or_length_is_refused(seed, n):
    with pytest.raises(Wm3dError, match="negative"):
        key_signs(seed, n)


def test_bit_error_rate_counts_wrong_signs_and_half_of_those_not_read():
    read = RademacherSum(0.0, np.array([2.0, -0.1, 3.0, 0.0]))
    assert read.decoded.tolist() == [1, -1, 1, 0]
    assert read.bit_error_rate([1, -1, 1, -1]) == 0.125
    assert read.bit_error_rate([-1, -1, 1, 1]) == 0.375
