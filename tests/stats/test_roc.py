"""ROC curves: hand-counted cases, the Gaussian law, and the cases that curves trip over."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.stats import mannwhitneyu, norm

from wm3d.errors import Wm3dError
from wm3d.stats import (
    auc,
    auc_two_sample,
    clopper_pearson,
    d_prime,
    eer,
    eer_two_sample,
    exceedances,
    gaussian_pd,
    roc,
    swept_roc,
)


def gaussian_log10_p(z):
    return norm.logsf(z) / math.log(10)


def test_exceedances_count_ties_and_infinities():
    scores = [1.0, 2.0, 2.0, math.inf, -math.inf]
    assert exceedances(scores, [2.0, 2.5, math.inf, -math.inf, 0.0]).tolist() == [3, 1, 1, 5, 4]
    assert exceedances([], [0.0]).tolist() == [0]
    with pytest.raises(Wm3dError, match="NaN"):
        exceedances([math.nan], [0.0])


def test_constant_false_alarm_roc_counts_p_values_at_most_pf():
    curve = roc([-math.inf, -400.0, -6.0, -2.0], [-math.inf, -1000.0, -6.0, -5.999, 0.0])
    assert curve.pd.tolist() == [0.25, 0.25, 0.75, 0.75, 1.0]
    assert curve.trials == 4
    low, high = clopper_pearson([1, 1, 3, 3, 4], 4)
    np.testing.assert_array_equal(curve.low, low)
    np.testing.assert_array_equal(curve.high, high)


def test_roc_of_gaussian_scores_follows_the_gaussian_fit(rng):
    z = rng.normal(4.0, 1.0, 20_000)
    pf = np.array([-1.0, -2.0, -3.0, -4.0])
    curve = roc(gaussian_log10_p(z), pf, confidence=1 - 1e-6)  # false alarm 4e-6
    fit = gaussian_pd(4.0, pf)
    assert ((curve.low < fit) & (fit < curve.high)).all()
    assert d_prime(z) == pytest.approx(4.0, abs=5.5 / math.sqrt(20_000))
    assert auc(gaussian_log10_p(z)) == pytest.approx(norm.cdf(4 / math.sqrt(2)), abs=1e-3)
    assert eer(gaussian_log10_p(z)) == pytest.approx(norm.sf(2.0), abs=0.004)  # both errors are Q(d'/2)


def test_gaussian_fit_works_in_logarithms():
    pf = -1000.0
    threshold = gaussian_quantile(pf)
    assert gaussian_pd(threshold, pf) == pytest.approx(0.5, abs=1e-9)
    assert gaussian_pd(3.0, [-math.inf, 0.0]).tolist() == [0.0, 1.0]
    assert gaussian_pd(0.0, -2.0) == pytest.approx(0.01)


def gaussian_quantile(log10_pf):
    return brentq(lambda z: gaussian_log10_p(z) - log10_pf, 0, 100, xtol=1e-12)


def test_swept_roc_quotes_pf_from_ten_null_scores():
    h0 = np.arange(100.0)
    curve = swept_roc([95.0, 85.0, 90.0], h0)
    assert curve.threshold[0] == math.inf
    assert curve.pd[0] == 0.0
    known = ~np.isnan(curve.log10_pf)
    assert curve.threshold[known].max() == 90.0  # 90..99: ten null scores
    at_90 = np.flatnonzero(curve.threshold == 90.0)[0]
    assert 10 ** curve.log10_pf[at_90] == pytest.approx(0.1)
    assert curve.pd[at_90] == pytest.approx(2 / 3)
    assert curve.pd[-1] == 1.0
    assert (np.diff(curve.pd) >= 0).all()


def test_two_ways_to_a_curve_agree_on_gaussian_scores(rng):
    h1, h0 = rng.normal(2, 1, 4000), rng.normal(0, 1, 200_000)
    swept = swept_roc(h1, h0)
    known = ~np.isnan(swept.log10_pf) & (swept.log10_pf > -3)
    exact = roc(gaussian_log10_p(h1), swept.log10_pf[known])
    # 1e-3·200000 = 200 null scores leave the threshold uncertain by a fifth of a percent of Pd and more
    assert np.abs(exact.pd - swept.pd[known]).max() < 0.05
    assert auc_two_sample(h1, h0) == pytest.approx(auc(gaussian_log10_p(h1)), abs=0.01)
    assert eer_two_sample(h1, h0) == pytest.approx(eer(gaussian_log10_p(h1)), abs=0.02)
    assert d_prime(h1, h0) == pytest.approx(d_prime(h1), abs=0.05)


def test_auc_counts_ties_half(rng):
    h1, h0 = rng.integers(0, 6, 70), rng.integers(0, 5, 90)
    expected = mannwhitneyu(h1, h0).statistic / (70 * 90)
    assert auc_two_sample(h1, h0) == pytest.approx(expected, rel=1e-12)
    assert auc_two_sample([1.0, 1.0], [1.0]) == 0.5
    assert auc_two_sample([math.inf], [-math.inf]) == 1.0


def test_equal_error_rate_of_few_trials_by_hand():
    assert eer(np.log10([0.5])) == pytest.approx(
        0.5
    )  # nothing is found below Pf = 0.5, and all from there on
    assert eer(np.log10([0.01, 0.3])) == pytest.approx(0.3)  # half is missed up to 0.3
    assert eer(np.log10([0.01, 0.02, 0.03, 0.9])) == 0.25  # one of four is missed, and Pf is 0.25
    assert eer([-math.inf, -math.inf]) == 0.0
    assert eer_two_sample([3.0, 4.0], [1.0, 2.0]) == 0.0
    assert eer_two_sample([1.0, 2.0], [1.0, 2.0]) == 0.5


def test_random_guessing_has_area_one_half(rng):
    log10_p = np.log10(rng.uniform(size=40_000))
    assert auc(log10_p) == pytest.approx(0.5, abs=5.5 / math.sqrt(12 * 40_000))  # false alarm 4e-8
    assert eer(log10_p) == pytest.approx(0.5, abs=0.02)


def test_classes_without_trials_have_no_numbers():
    curve = roc([], [-6.0])
    assert math.isnan(curve.pd[0])
    assert (curve.low[0], curve.high[0], curve.trials) == (0.0, 1.0, 0)
    for value in (auc([]), eer([]), d_prime([]), auc_two_sample([], [1.0]), eer_two_sample([1.0], [])):
        assert math.isnan(value)
    assert math.isnan(d_prime([1.0], h0=[2.0]))  # one null score has no spread
    assert np.isnan(swept_roc([1.0, 2.0], []).log10_pf).all()


def test_one_trial_makes_a_step():
    curve = roc([-7.0], [-8.0, -7.0, -6.0])
    assert curve.pd.tolist() == [0.0, 1.0, 1.0]
    assert curve.low[1] == pytest.approx(0.025)
