"""Importance sampling far below what counting can reach."""

import math

import numpy as np
import pytest

from wm3d.errors import Wm3dError
from wm3d.stats import false_alarm, importance_sampling, log10_tail, z_at


def test_1e_minus_12_with_two_percent_error(rng):
    b = rng.gamma(0.7, 1, 1000)
    estimate = importance_sampling(b, z_at(b, -12.0), seed=1)
    assert estimate.relative_error <= 0.0205  # the error aimed at, itself estimated to about 1 %
    low, high = estimate.log10_interval(confidence=1 - 1e-6)
    assert low < -12 < high


def test_enumerated_probability_is_inside_a_narrow_interval(rng):
    b, z = rng.uniform(0.5, 1, 18), 3.2  # log10_tail counts the keys of 18 signs
    estimate = importance_sampling(b, z, relative_error=0.005, seed=1)
    low, high = estimate.log10_interval(confidence=1 - 1e-6)
    assert low < log10_tail(b, z) < high
    assert high - low < 0.03


def test_estimate_is_unbiased_and_its_error_honest(rng):
    b = rng.exponential(1, 100)
    pf = 10 ** log10_tail(b, 5.0)
    runs = [importance_sampling(b, 5.0, trials=500, seed=seed) for seed in range(200)]
    ratios = np.array([10**run.log10_pf / pf for run in runs])
    claimed = np.sqrt(np.mean([run.relative_error**2 for run in runs]))
    # 5 sigma: false alarm 6e-7; the saddlepoint's own error here is some 1e-3 of pf
    assert abs(ratios.mean() - 1) < 5 * claimed / math.sqrt(200) + 2e-3
    assert ratios.std() / claimed == pytest.approx(1, abs=5 / math.sqrt(2 * 200))


def test_logarithms_carry_the_estimate_below_the_least_float(rng):
    b = rng.exponential(1, 3000)
    estimate = importance_sampling(b, 36.0, relative_error=0.05, seed=2)
    assert estimate.log10_pf < -400
    assert estimate.log10_pf == pytest.approx(log10_tail(b, 36.0), abs=0.12)  # 5 sigma


@pytest.mark.parametrize("z", [-1.0, 0.0, 0.5])
def test_likely_events_need_no_tilt(z, rng):
    b = rng.exponential(1, 200)
    low, high = importance_sampling(b, z, seed=3).log10_interval(confidence=1 - 1e-6)
    assert low < log10_tail(b, z) < high
    assert high - low < 0.1


def test_false_alarm_bundles_the_tail_its_bound_and_its_checks(rng):
    b = rng.exponential(1, 300)
    alarm = false_alarm(b, 3.0)
    assert alarm.log10_p == log10_tail(b, 3.0)
    assert alarm.p_value == pytest.approx(10**alarm.log10_p)
    assert alarm.hoeffding_log10 > alarm.log10_p
    for run in (alarm.hadamard_keys(trials=10**6, seed=1), alarm.independent_keys(trials=10_000, seed=1)):
        low, high = run.interval(confidence=1 - 1e-6)
        assert low[0] < alarm.p_value < high[0]
    low, high = alarm.importance_sampling(seed=1).log10_interval(confidence=1 - 1e-6)
    assert low < alarm.log10_p < high


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"z": 2.0}, "not below"),
        ({"z": math.nan}, "NaN"),
        ({"relative_error": 0.0}, "relative_error"),
        ({"trials": 0}, "trials"),
        ({"b": np.zeros(4)}, "not below"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises(Wm3dError, match=message):
        importance_sampling(**{"b": np.ones(4), "z": 1.0, **arguments})
