"""Monte Carlo false alarms: unbiased, reproducible, with honest intervals."""

import math

import numpy as np
import pytest
from scipy.linalg import hadamard

from wm3d.errors import Wm3dError
from wm3d.stats import hadamard_keys, independent_keys, key_signs_batch, log10_tail, z_at
from wm3d.stats.kernels import LANES, hadamard_exceedances
from wm3d.stats.montecarlo import _placed, _sign_bits


def test_keys_of_all_sign_patterns_are_exactly_uniform():
    weights = np.zeros(16, np.float32)
    weights[[1, 6, 7, 12]] = 1, 2, 4, 8  # so that the statistic, an odd number in ±15, spells the key
    bits = np.zeros((1, 16), np.uint16)
    for k, column in enumerate([1, 6, 7, 12]):  # lane l gets the k-th bit of l: every pattern once
        bits[0, column] = sum(1 << lane for lane in range(LANES) if lane >> k & 1)
    statistics = np.arange(-15, 16, 2, dtype=np.float32)
    counts = hadamard_exceedances(weights, bits, statistics)[0].sum(axis=1)
    np.testing.assert_array_equal(counts, 16 * np.arange(16, 0, -1))  # each key 16 times, once a row


def test_rows_of_one_transform_are_uncorrelated_over_placements():
    weights, order = np.array([5.0, 2.0, 1.0, 1.0, 1.0]), 16
    square = np.array([_placed(weights, order, seed) ** 2 for seed in range(4000)])
    # given the placement, rows i and j of H·diag(d) have the covariance Σ b_k² h_ik h_jk
    correlation = square @ hadamard(order)[1:].T / (weights**2).sum()
    deviation = correlation.mean(axis=0) / (correlation.std(axis=0) / math.sqrt(4000))
    assert np.abs(deviation).max() < 5.5  # false alarm 6e-7 over the 15 differences of rows
    assert np.abs(correlation).max() > 0.5  # which no single placement of so few weights would give


def test_sign_bits_are_fair_and_differ_between_tasks():
    bits = np.stack([_sign_bits(3, task, 8, 1024) for task in range(4)])
    ones = np.unpackbits(bits.view(np.uint8)).astype(float)
    assert abs(ones.mean() - 0.5) < 5.5 * 0.5 / math.sqrt(ones.size)  # false alarm 4e-8
    assert len(np.unique(bits.reshape(-1, 16), axis=0)) == bits.size // 16


def test_hadamard_keys_are_unbiased_from_1e_minus_2_to_1e_minus_7(rng):
    b = rng.gamma(0.7, 1, 900)
    z = np.array([z_at(b, -k) for k in range(2, 8)])
    run = hadamard_keys(b, z, trials=2 * 10**8, seed=1)
    # Interval of coverage 1 - 1e-6 at each of 6 thresholds: false alarm 6e-6
    low, high = run.interval(confidence=1 - 1e-6)
    pf = 10.0 ** log10_tail(b, z)
    assert ((low <= pf) & (pf <= high)).all()
    assert run.counts[-1] > 0
    assert (high[:4] / low[:4] < 1.3).all()  # so the interval is not vacuous


def test_independent_keys_are_unbiased_and_agree_with_direct_scores(rng):
    b, z = rng.exponential(1, 50), np.array([0.0, 1.0, 2.0])
    run = independent_keys(b, z, trials=20_000, seed=4)
    low, high = run.interval(confidence=1 - 1e-6)  # false alarm 3e-6
    pf = 10.0 ** log10_tail(b, z)
    assert ((low < pf) & (pf < high)).all()
    seeds = np.random.PCG64(np.random.SeedSequence(4)).random_raw(300)
    scores = key_signs_batch(seeds.tolist(), 50) @ b / np.linalg.norm(b)
    np.testing.assert_array_equal(
        independent_keys(b, z, trials=300, seed=4).counts, (scores[:, None] >= z).sum(axis=0)
    )


@pytest.mark.parametrize("n", [1, 3, 16, 17, 600])
def test_ties_count_as_in_the_exact_tail(n):
    # z = 0 and z = 2/sqrt(n)·k lie on atoms of a sum of equal weights, where a lost tie shows at once
    z = np.array([(n % 2) / math.sqrt(n), ((n % 2) - 2) / math.sqrt(n)])
    run = hadamard_keys(np.full(n, 0.1), z, trials=10**6, seed=2)
    low, high = run.interval(confidence=1 - 1e-6)  # false alarm 1e-5 over the five cases
    pf = 10.0 ** log10_tail(np.ones(n), z)
    assert ((low <= pf) & (pf <= high)).all()


def test_counts_depend_on_the_seed_and_not_on_the_threads(rng):
    b = rng.exponential(1, 100)
    z = [2.0, 0.5, 1.0]
    one = hadamard_keys(b, z, trials=10**7, seed=9, threads=1)
    three = hadamard_keys(b, z, trials=10**7, seed=9, threads=3)
    np.testing.assert_array_equal(one.counts, three.counts)
    np.testing.assert_array_equal(one.squares, three.squares)
    assert (hadamard_keys(b, z, trials=10**7, seed=10).counts != one.counts).all()
    assert one.counts[1] > one.counts[2] > one.counts[0]  # in the order asked for
    assert one.trials == one.batches * one.batch_size >= 10**7
    assert one.trials - 10**7 < LANES * one.batch_size


def test_estimate_is_quoted_only_from_ten_over_pf_trials():
    run = hadamard_keys(np.ones(64), [1.0, 8.0], trials=10**5)  # the second is one key in 2^64
    assert run.counts[1] == 0
    assert run.quoted_pf[0] == run.pf[0] > 0
    assert math.isnan(run.quoted_pf[1])
    low, high = run.interval()
    assert low[1] == 0.0
    assert 0 < high[1] < 1e-4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"b": np.zeros(4)}, "zero"),
        ({"trials": 0}, "trials"),
        ({"threads": 0}, "threads"),
        ({"z": math.nan}, "NaN"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises(Wm3dError, match=message):
        hadamard_keys(**{"b": np.ones(4), "z": 1.0, **arguments})
