"""ROC curves: hand-counted cases, the Gaussian law, and the cases that curves trip over."""

import math

import numpy as np
import pytest
from scipy.stats import norm

from wm3d.errors import Wm3dError
from wm3d.stats import (
    auc,
    clopper_pearson,
    d_prime,
    eer,
    exceedances,
    roc,
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
    fit = norm.sf(norm.isf(10**pf) - 4.0)
    assert ((curve.low < fit) & (fit < curve.high)).all()
    assert d_prime(z) == pytest.approx(4.0, abs=5.5 / math.sqrt(20_000))
    assert auc(gaussian_log10_p(z)) == pytest.approx(norm.cdf(4 / math.sqrt(2)), abs=1e-3)
    assert eer(gaussian_log10_p(z)) == pytest.approx(norm.sf(2.0), abs=0.004)  # both errors are Q(d'/2)


def test_equal_error_rate_of_few_trials_by_hand():
    assert eer(np.log10([0.5])) == pytest.approx(
        0.5
    )  # nothing is found below Pf = 0.5, and all from there on
    assert eer(np.log10([0.01, 0.3])) == pytest.approx(0.3)  # half is missed up to 0.3
    assert eer(np.log10([0.01, 0.02, 0.03, 0.9])) == 0.25  # one of four is missed, and Pf is 0.25
    assert eer([-math.inf, -math.inf]) == 0.0


def test_random_guessing_has_area_one_half(rng):
    log10_p = np.log10(rng.uniform(size=40_000))
    assert auc(log10_p) == pytest.approx(0.5, abs=5.5 / math.sqrt(12 * 40_000))  # false alarm 4e-8
    assert eer(log10_p) == pytest.approx(0.5, abs=0.02)


def test_classes_without_trials_have_no_numbers():
    curve = roc([], [-6.0])
    assert math.isnan(curve.pd[0])
    assert (curve.low[0], curve.high[0], curve.trials) == (0.0, 1.0, 0)
    for value in (auc([]), eer([]), d_prime([])):
        assert math.isnan(value)


def test_area_without_any_evidence_is_zero_and_not_less():
    assert str(auc([0.0, 0.0])) == "0.0"


def test_one_trial_makes_a_step():
    curve = roc([-7.0], [-8.0, -7.0, -6.0])
    assert curve.pd.tolist() == [0.0, 1.0, 1.0]
    assert curve.low[1] == pytest.approx(0.025)
