"""The tail of a Rademacher sum against enumeration, the binomial law and high-precision arithmetic."""

import math

import mpmath
import numpy as np
import pytest
from scipy.stats import binom

from wm3d.errors import Wm3dError
from wm3d.stats import hoeffding_log10, log10_tail, saddlepoint_log10, z_at
from wm3d.stats.characteristic import characteristic, characteristic_numpy
from wm3d.stats.inversion import EXCESS
from wm3d.stats.weights import unit_weights


def all_sums(b):
    sums = np.zeros(1)
    for weight in b:
        sums = np.concatenate([sums - weight, sums + weight])
    return np.sort(sums)


def enumerated(b, z):
    """Log10 of the share of all keys that reach z, from the sums of two halves of b."""
    first, second = all_sums(b[::2]), all_sums(b[1::2])
    limits = np.atleast_1d(z) * np.linalg.norm(b) - 1e-10
    counts = [(second.size - np.searchsorted(second, limit - first)).sum() for limit in limits]
    return np.log10(counts) - len(b) * math.log10(2)


def added_up(whole, z):
    """Log10 of the share of all keys that reach z, for whole weights: the law of their sum, term by term."""
    share = np.ones(1)  # of each sum, -total, -total + 2, ...
    for weight in whole:
        share = (np.append(share, np.zeros(weight)) + np.append(np.zeros(weight), share)) / 2
    limits = np.atleast_1d(z) * np.linalg.norm(whole) - 1e-10
    sums = np.arange(-whole.sum(), whole.sum() + 1, 2)
    return np.log10([share[sums >= limit].sum() for limit in limits])


def lugannani_rice(b, z):
    """Log10 of the formula in 60 digits."""
    with mpmath.workdps(60):
        size = [abs(mpmath.mpf(x)) for x in b]
        scale = mpmath.sqrt(mpmath.fsum(x * x for x in size))
        a, z = [x / scale for x in size], mpmath.mpf(z)
        theta = mpmath.findroot(
            lambda t: mpmath.fsum(x * mpmath.tanh(t * x) for x in a) - z,
            (z, 1.1 * z),
            tol=mpmath.mpf(10) ** -80,
        )
        k = mpmath.fsum(mpmath.log(mpmath.cosh(theta * x)) for x in a)
        k2 = mpmath.fsum((x * mpmath.sech(theta * x)) ** 2 for x in a)
        r, u = mpmath.sqrt(2 * (theta * z - k)), theta * mpmath.sqrt(k2)
        return mpmath.log10(mpmath.erfc(r / mpmath.sqrt(2)) / 2 + mpmath.npdf(r) * (1 / u - 1 / r))


@pytest.mark.parametrize("n", [1, 2, 7, 12, 20])
@pytest.mark.parametrize("law", ["continuous", "heavy", "three values", "equal"])
def test_tail_matches_full_enumeration(n, law, rng):
    b = {
        "continuous": rng.uniform(0.5, 1, n),
        "heavy": rng.standard_cauchy(n),
        "three values": rng.integers(1, 4, n).astype(float),
        "equal": np.full(n, 0.1),
    }[law]
    sums = all_sums(b) / np.linalg.norm(b)
    z = np.concatenate([np.linspace(sums[0], sums[-1], 60), sums[:: max(1, sums.size // 60)]])
    np.testing.assert_allclose(log10_tail(b, z), enumerated(b, z), atol=1e-12)


@pytest.mark.parametrize("law", ["continuous", "exponential", "two heavy", "three values", "all but equal"])
def test_tail_of_32_signs_is_never_below_the_truth_and_hardly_above(law, rng):
    b = {
        "continuous": rng.uniform(0.5, 1, 32),
        "exponential": rng.exponential(1, 32),
        "two heavy": np.append(rng.uniform(0.5, 1, 30), [8.0, 5.0]),
        "three values": rng.integers(1, 4, 32).astype(float),
        "all but equal": rng.uniform(0.99, 1, 32),
    }[law]
    z = np.linspace(-0.9, 0.9, 80) * unit_weights(b).sum()
    above = log10_tail(b, z) - enumerated(b, z)
    assert above.min() > -1e-9
    # within a cluster of sums the smoothing shows
    assert above.max() < math.log10(1.1 if law == "all but equal" else 1.01)


@pytest.mark.parametrize("n", [60, 300])
def test_tail_keeps_the_atoms_of_a_lattice(n, rng):
    whole = rng.integers(1, 5, n)
    z = (whole.sum() - 2 * np.arange(0, whole.sum(), 11)) / np.linalg.norm(whole)
    z = z[z < 11]
    np.testing.assert_allclose(log10_tail(whole, z), added_up(whole, z), rtol=0, atol=1e-9)


@pytest.mark.parametrize("heavy", [[], [60000, 100000]])
def test_tail_is_never_below_the_truth_and_at_most_a_five_hundredth_above(heavy, rng):
    whole = np.append(rng.integers(1000, 3000, 300), heavy).astype(int)  # sums lie evenly, 2 apart
    z = np.linspace(-6, 11.3, 80)
    z = z[np.abs(z) < 0.9 * unit_weights(whole).sum()]
    above = log10_tail(whole, z) - added_up(whole, z)
    assert above.min() > -1e-9
    assert above.max() < math.log10(1 + 1.25 * EXCESS)  # tilts lie apart by 1.2


def test_smallest_weights_do_not_hide_the_atoms_of_the_others():
    b = np.append(np.ones(30), np.full(300, 1e-5))
    down = np.arange(0, 15)  # of the thirty
    z = (30 - 2 * down - 0.01) / np.linalg.norm(b)
    exact = binom.logcdf(down, 30, 0.5) / math.log(10)
    np.testing.assert_allclose(log10_tail(b, z), exact, rtol=0, atol=1e-9)


@pytest.mark.parametrize("n", [3, 40, 700])
def test_characteristic_function_matches_its_numpy_twin(n, rng):
    a = unit_weights(rng.exponential(1, n))
    tilt = np.tanh(2 * a)
    np.testing.assert_allclose(
        characteristic(a, tilt, 0.03, 1000), characteristic_numpy(a, tilt, 0.03, 1000), rtol=0, atol=2e-14
    )


def test_equal_weights_are_binomial_at_any_length():
    n, down = 6300, np.array([6300, 3500, 3150, 3000, 2800, 2500])
    z = (n - 2 * down) / math.sqrt(n)
    np.testing.assert_allclose(
        log10_tail(np.full(n, 0.3), z), binom.logcdf(down, n, 0.5) / math.log(10), rtol=1e-9, atol=1e-12
    )


@pytest.mark.parametrize(
    ("n", "z"),
    [
        (400, 1e-5),
        (400, 1.1e-4),
        (400, 0.01),
        (400, 1.0),
        (400, 4.753),
        (400, 17.0),
        (1600, 37.0),
        (6300, 60.0),
    ],
)
def test_saddlepoint_matches_60_digits_down_to_1e_minus_900(n, z, rng):
    b = rng.uniform(0.3, 1, n) * rng.choice([-1, 1], n)
    exact = lugannani_rice(b.tolist(), z)
    assert saddlepoint_log10(b, z) == pytest.approx(float(exact), rel=1e-10)
    if z > 12:
        assert log10_tail(b, z) == saddlepoint_log10(b, z)
    else:
        assert log10_tail(b, z) == pytest.approx(saddlepoint_log10(b, z), abs=math.log10(1 + 2 * EXCESS))


def test_all_signs_agree_with_probability_two_to_the_minus_n(rng):
    b = np.append(rng.uniform(0.5, 1, 6300), np.zeros(100))
    a = unit_weights(b)
    one_key = -6300 * math.log10(2)
    assert log10_tail(b, a.sum()) == pytest.approx(one_key, rel=1e-12)
    assert log10_tail(b, a.sum() - 1.9 * a.min()) == pytest.approx(one_key, rel=1e-12)
    two_keys = a.sum() - 2.0001 * a.min()
    assert log10_tail(b, two_keys) == pytest.approx(one_key + math.log10(2), rel=1e-12)
    assert log10_tail(b, a.sum() * 1.001) == -math.inf


def test_lower_half_is_the_complement_of_the_upper(rng):
    z = np.linspace(0.1, 5, 20)
    b = rng.exponential(1, 500)
    both = 10 ** log10_tail(b, z) + 10 ** log10_tail(b, -z)
    assert both.min() >= 1  # neither is below the truth
    assert both.max() < 1 + EXCESS
    assert math.log10(0.5) < log10_tail(b, 0.0) < math.log10(0.5 * (1 + EXCESS))
    assert log10_tail(b, -math.inf) == 0.0
    assert log10_tail(b, math.inf) == -math.inf


def test_tail_falls_with_z_and_stays_below_hoeffding(rng):
    b = rng.gamma(0.7, 1, 6300)
    z = np.concatenate([np.linspace(-8, 8, 400), np.linspace(8, 50, 100), 10.0 ** -np.arange(12)])
    z.sort()
    tail = log10_tail(b, z)
    assert (np.diff(tail) <= 0).all()
    assert (tail <= hoeffding_log10(b, z)).all()
    assert hoeffding_log10(b, 3.0) == pytest.approx(math.log10(math.exp(-4.5)))
    assert hoeffding_log10(b, -3.0) == 0.0


def test_tail_depends_only_on_the_shape_of_b(rng):
    b = rng.exponential(1, 300)
    z = np.array([[-1.0, 0.5], [3.0, 9.0]])
    tail = log10_tail(b, z)
    assert tail.shape == (2, 2)
    for other in (-b, b * 1e-250, b * 1e250, b[::-1], np.append(b, np.zeros(50))):
        np.testing.assert_allclose(log10_tail(other, z), tail, rtol=1e-11)
    assert log10_tail(b, 3.0) == pytest.approx(tail[1, 0], rel=1e-13)


@pytest.mark.parametrize("log10_pf", [-0.1, -6.0, -12.0, -400.0])
def test_threshold_inverts_the_tail(log10_pf, rng):
    b = rng.exponential(1, 6300)
    assert log10_tail(b, z_at(b, log10_pf)) == pytest.approx(log10_pf, abs=1e-8)


def test_threshold_of_a_discrete_sum_keeps_pf():
    ones = np.ones(10)
    z = z_at(ones, math.log10(0.02))  # 11 of 1024 keys have at least 9 signs up, 56 at least 8
    assert 6 / math.sqrt(10) < z < 6.001 / math.sqrt(10)
    assert 10 ** log10_tail(ones, z) == pytest.approx(11 / 1024)
    assert 10 ** log10_tail(ones, z_at(ones, -10 * math.log10(2))) == pytest.approx(2**-10)  # the least Pf
    assert z_at(ones, -3.0104) == math.inf
    assert z_at(np.zeros(4), -1.0) == math.inf


def test_ties_of_equal_weights_are_those_of_all_others():
    beside = np.array([1 + 1e-12, 1 + 5e-10])  # of four ones, half of whose sum is 2
    assert 10 ** log10_tail(np.ones(4), beside) == pytest.approx([5 / 16, 1 / 16])


def test_threshold_is_infinite_where_only_dust_would_tell_more_keys_apart():
    assert z_at(np.append(np.ones(30), np.full(30, 1e-15)), -12.0) == math.inf


def test_long_sums_near_their_largest_are_not_inverted(monkeypatch, rng):
    b = np.sort(rng.exponential(1, 2000))  # and the 30 smallest signs are down: P is 1e-580
    z = (b.sum() - 2 * b[:30].sum()) / np.linalg.norm(b)
    with monkeypatch.context() as context:
        context.setattr("wm3d.stats.inversion._contour", None)
        assert log10_tail(b, z) == saddlepoint_log10(b, z) < -500


def test_bad_thresholds_are_named():
    with pytest.raises(Wm3dError, match="NaN"):
        log10_tail(np.ones(3), math.nan)
    with pytest.raises(Wm3dError, match="below 1"):
        z_at(np.ones(3), 0.0)
    with pytest.raises(Wm3dError, match="saddlepoint"):
        saddlepoint_log10(np.ones(4), 2.0)
