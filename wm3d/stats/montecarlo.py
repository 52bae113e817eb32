"""Monte Carlo of the false-alarm probability: independent keys, and keys from fast Hadamard transforms."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wm3d.arrays import FloatArray, IntArray
from wm3d.errors import Wm3dError
from wm3d.stats.intervals import DEFAULT_CONFIDENCE, Interval, korn_graubard, quoted
from wm3d.stats.kernels import LANES, MIN_ORDER, hadamard_exceedances
from wm3d.stats.rademacher import key_signs_batch
from wm3d.stats.weights import checked_thresholds, tie_slack, unit_weights

DEFAULT_TRIALS = 10**8
"""Hadamard keys in a run, unless the caller names another number: what the paper reached, in a second."""

_TRIALS_A_TASK = 1 << 22  # 10 ms of work: short enough to balance threads, long enough to hide Python
_KEYS_AT_ONCE = 32  # 1.6 MB of float64 at n = 6300 stays in cache
_FLOAT32_SLACK = 2.0**-18  # in z; covers the rounding of 2^20 float32 terms, and costs z·4e-6 of Pf


@dataclass(frozen=True, eq=False)
class Exceedances:
    """How many random keys reached each threshold.

    Parameters
    ----------
    method : str
        How the keys were drawn.
    z : (T,) ndarray of float
        Thresholds in units of √(Σ b²).
    counts : (T,) ndarray of int
        Keys whose statistic is at least the threshold.
    squares : (T,) ndarray of int
        Sum over the batches of the squared count of the batch.
    batches, batch_size : int
        Independent batches, and the trials in each. Independent keys are batches of one.
    """

    method: str
    z: FloatArray
    counts: IntArray
    squares: IntArray
    batches: int
    batch_size: int

    @property
    def trials(self) -> int:
        """Number of keys."""
        return self.batches * self.batch_size

    @property
    def pf(self) -> FloatArray:
        """Unbiased estimate of the false-alarm probability, (T,)."""
        return self.counts / self.trials

    @property
    def quoted_pf(self) -> FloatArray:
        """The estimate where there are 10/Pf trials or more, NaN elsewhere, (T,)."""
        return quoted(self.counts, self.trials)

    def interval(self, confidence: float = DEFAULT_CONFIDENCE) -> Interval:
        """Return the interval of Pf, from the spread of the independent batches (`korn_graubard`)."""
        return korn_graubard(self.counts, self.squares, self.batches, self.batch_size, confidence)


def independent_keys(b: ArrayLike, z: ArrayLike, trials: int, seed: int = 0) -> Exceedances:
    """Score `trials` independent keys, each made by `key_signs` from a seed of its own.

    Parameters
    ----------
    b : (n,) array_like of float
        Weights of the statistic Σ b_k w_k, not all zero.
    z : float or (T,) array_like of float
        Thresholds in units of √(Σ b²). Ties count as exceedances.
    trials : int
        How many keys.
    seed : int
        Seed of the keys' 64-bit seeds.

    Returns
    -------
    Exceedances

    Raises
    ------
    Wm3dError
        If all weights are zero, a threshold is NaN or `trials` is not positive.

    Notes
    -----
    What the paper did up to 10⁸ times. Some 30 000 keys a second at n = 6300: for a check of the faster
    ways, not instead of them.
    """
    weights, thresholds = _drawn_weights(b, trials), np.atleast_1d(checked_thresholds(z))
    limits = thresholds - tie_slack(np.abs(weights))
    counts = np.zeros(thresholds.size, np.int64)
    seeds = np.random.PCG64(np.random.SeedSequence(seed))
    for done in range(0, trials, _KEYS_AT_ONCE):
        batch = seeds.random_raw(min(_KEYS_AT_ONCE, trials - done))
        signs = key_signs_batch(batch.tolist(), weights.size)
        statistic = signs.astype(np.float64) @ weights  # BLAS knows no int8
        counts += (statistic[:, None] >= limits).sum(axis=0)
    return Exceedances("independent keys", thresholds, counts, counts, trials, 1)


def hadamard_keys(
    b: ArrayLike, z: ArrayLike, trials: int = DEFAULT_TRIALS, seed: int = 0, threads: int = 1
) -> Exceedances:
    """Score keys that are rows of a randomly signed Hadamard matrix, thousands in one fast transform.

    Parameters
    ----------
    b : (n,) array_like of float
        Weights of the statistic Σ b_k w_k, not all zero.
    z : float or (T,) array_like of float
        Thresholds in units of √(Σ b²), in any order. Ties count as exceedances.
    trials : int
        Least number of keys; rounded up to whole groups of 16 transforms of N keys.
    seed : int
        Non-negative. The same seed gives the same counts, whatever `threads` is.
    threads : int
        How many threads work.

    Returns
    -------
    Exceedances
        Its batches are the transforms.

    Raises
    ------
    Wm3dError
        If all weights are zero, a threshold is NaN, or `trials` or `threads` is not positive.

    Notes
    -----
    With H the N×N Hadamard matrix, N the power of two from n up, and d uniform random signs, each row of
    H·diag(d) is a uniformly distributed key, so the share of rows that reach a threshold is an unbiased
    estimate of Pf; one fast Walsh–Hadamard transform of d∘b (b padded with zeros) gives all N statistics.
    The rows of one transform depend on each other: rows i and j have the correlation Σ b_k² h_ik h_jk / Σ b².
    Placing b at random columns makes that 0 on average and of order N^−½ in each case, whatever the order
    of b. Transforms are independent of each other given the placement, and the interval comes from them.

    The transform runs in float32: z errs by some 3·10⁻⁷, which moves Pf by less than 10⁻⁵ of itself. So
    that no tie is lost, thresholds are lowered by 4·10⁻⁶, which moves Pf by at most z·4·10⁻⁶ of itself;
    10⁹ exceedances could not tell.
    """
    if threads < 1:
        raise Wm3dError(f"threads is {threads}; at least one thread must work.")
    weights, thresholds = _drawn_weights(b, trials), np.atleast_1d(checked_thresholds(z))
    order = max(MIN_ORDER, 1 << (weights.size - 1).bit_length())
    placed = _placed(weights, order, seed)
    rank = np.argsort(thresholds, kind="stable")
    limits = (thresholds[rank] - _FLOAT32_SLACK).astype(np.float32)

    def run(task: tuple[int, int]) -> tuple[IntArray, IntArray]:
        counts = hadamard_exceedances(placed, _sign_bits(seed, *task, order), limits).astype(np.int64)
        return counts.sum(axis=(0, 2)), np.square(counts).sum(axis=(0, 2))

    groups = -(-trials // (LANES * order))
    sums = np.zeros((2, thresholds.size), np.int64)
    with ThreadPoolExecutor(threads) as pool:
        for part in pool.map(run, _tasks(groups, order)):
            sums[:, rank] += part
    return Exceedances("Hadamard keys", thresholds, sums[0], sums[1], groups * LANES, order)


def _drawn_weights(b: ArrayLike, trials: int) -> FloatArray:
    """Return the nonzero weights in units of √(Σ b²); their signs do not matter and are dropped."""
    if trials < 1:
        raise Wm3dError(f"trials is {trials}; a Monte Carlo check needs at least one.")
    weights = unit_weights(b)
    if weights.size == 0:
        raise Wm3dError("All weights are zero, so there is no statistic to simulate.")
    return weights


def _placed(weights: FloatArray, order: int, seed: int) -> NDArray[np.float32]:
    """Put the weights at distinct random positions among `order`, zeros elsewhere."""
    stream = np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(0,)))
    placed = np.zeros(order, np.float32)
    placed[np.argsort(stream.random_raw(order), kind="stable")[: weights.size]] = weights
    return placed


def _tasks(groups: int, order: int) -> Iterator[tuple[int, int]]:
    """Yield (number of the task, groups in it); the split does not depend on the threads."""
    size = max(1, _TRIALS_A_TASK // (LANES * order))
    for number, first in enumerate(range(0, groups, size)):
        yield number, min(size, groups - first)


def _sign_bits(seed: int, number: int, groups: int, order: int) -> NDArray[np.uint16]:
    """Return the (groups, order) words whose 16 bits are the signs of 16 transforms, of one task."""
    stream = np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(1, number)))
    words = stream.random_raw(groups * order * LANES // 64)
    return words.astype("<u8", copy=False).view("<u2").reshape(groups, order)
