"""Intervals of proportions and means against their definitions, and their coverage."""

import math

import numpy as np
import pytest
from scipy.stats import binom, binomtest, ttest_1samp

from wm3d.errors import Wm3dError
from wm3d.stats import clopper_pearson, korn_graubard, quoted, student_t, tolerance_bound


@pytest.mark.parametrize(("k", "n"), [(0, 1), (1, 1), (0, 30), (30, 30), (7, 30), (3, 10**8)])
def test_clopper_pearson_is_the_exact_interval_of_scipy(k, n):
    expected = binomtest(k, n).proportion_ci(0.95, method="exact")
    low, high = clopper_pearson(k, n)
    assert low == pytest.approx(expected.low, rel=1e-10)
    assert high == pytest.approx(expected.high, rel=1e-10)


def test_clopper_pearson_covers_at_least_as_often_as_it_says():
    n = 25
    low, high = clopper_pearson(np.arange(n + 1), n, confidence=0.9)
    for p in np.linspace(0.01, 0.99, 33):
        inside = (low <= p) & (p <= high)
        assert binom.pmf(np.arange(n + 1), n, p)[inside].sum() >= 0.9


def test_no_trials_leave_everything_possible():
    assert clopper_pearson(0, 0) == (0.0, 1.0)
    low, high = clopper_pearson([0, 1], [0, 2])
    assert (low[0], high[0]) == (0.0, 1.0)
    assert 0 < low[1] < high[1] < 1


def test_batches_that_move_as_one_count_as_one_trial_each():
    # 100 batches of 1000 equal trials, 30 of them events: as good as 30 of 100, less what the t law takes
    low, high = korn_graubard(30_000, 30 * 1000**2, batches=100, batch_size=1000)
    exact_low, exact_high = clopper_pearson(30, 100)
    assert low == pytest.approx(exact_low, abs=0.005)
    assert high == pytest.approx(exact_high, abs=0.005)
    assert low < exact_low
    assert high > exact_high


def test_independent_trials_give_the_clopper_pearson_interval():
    k = binom(1000, 0.01).rvs(400, random_state=1)
    low, high = korn_graubard(k.sum(), (k**2).sum(), batches=400, batch_size=1000)
    exact_low, exact_high = clopper_pearson(k.sum(), 400_000)
    assert high - low == pytest.approx(exact_high - exact_low, rel=0.2)
    assert high - low >= exact_high - exact_low  # never narrower than the trials allow


def test_batches_without_events_fall_back_on_the_trials():
    assert korn_graubard(0, 0, 10, 100) == clopper_pearson(0, 1000)
    assert korn_graubard(1000, 10 * 100**2, 10, 100) == clopper_pearson(1000, 1000)
    assert korn_graubard(7, 49, 1, 100) == clopper_pearson(7, 100)


def test_interval_of_a_mean_is_that_of_the_t_test():
    values = [3.0, 4.5, 2.0, 7.25]
    expected = ttest_1samp(values, 0).confidence_interval(0.9)
    assert student_t(values, 0.9) == pytest.approx((expected.low, expected.high), rel=1e-12)
    assert np.isnan(student_t([3.0])).all()


def test_probability_is_quoted_from_ten_events():
    shares = quoted([9, 10, 0], [100, 100, 0])
    assert math.isnan(shares[0])
    assert shares[1] == 0.1
    assert math.isnan(shares[2])


@pytest.mark.parametrize(("k", "n", "confidence"), [(3, 2, 0.95), (-1, 2, 0.95), (1, 2, 1.0), (1, 2, 0.0)])
def test_impossible_counts_are_refused(k, n, confidence):
    with pytest.raises(Wm3dError):
        clopper_pearson(k, n, confidence)


@pytest.mark.parametrize(("n", "k"), [(2, 37.094), (5, 5.741), (10, 3.981), (20, 3.295), (100, 2.684)])
def test_tolerance_bound_has_the_factors_of_the_tables(n, k):
    # Natrella, Experimental Statistics, NBS Handbook 91, table A-7: 99 % of the values with confidence 0.95
    assert tolerance_bound(10.0, 2.0, n) == pytest.approx(10 - 2 * k, rel=1e-3)


def test_tolerance_bound_lies_below_the_quantile_as_often_as_it_says():
    values = np.random.default_rng(1).normal(3.0, 0.5, (4000, 8))
    bound = tolerance_bound(values.mean(axis=1), values.std(axis=1, ddof=1), 8, share=0.9, confidence=0.8)
    below = (bound < 3.0 - 0.5 * 1.2815515655446004).sum()
    assert binomtest(int(below), 4000, 0.8).pvalue > 1e-3


def test_one_value_bounds_nothing():
    np.testing.assert_array_equal(tolerance_bound([50.0, 50.0], [np.nan, 0.0], [1, 5]), [-np.inf, 50.0])
