"""Distances from a centre in equal bins, a moment of each bin, and power maps that set it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wm3d.arrays import FloatArray, IntArray, SignArray

_LARGEST_LN_K = 5.0  # k from 1/148 to 148: beyond, nearly all distances lie on one border of the bin
_HALVINGS = 40


@dataclass(frozen=True)
class Moment:
    """A moment of distances t in [0, 1] that a map t → t' moves without leaving the bin.

    Both moments are the mean of a value u(t) in [0, 1], and both maps are u → u^k.

    Attributes
    ----------
    neutral : float
        The moment where t is uniform.
    deviation : float
        Standard deviation of u where t is uniform.
    value : callable
        u(t).
    mapped : callable
        ``mapped(t, k)``: the t' with u(t') = u(t)^k.
    """

    neutral: float
    deviation: float
    value: Callable[[FloatArray], FloatArray]
    mapped: Callable[[FloatArray, FloatArray], FloatArray]


def _symmetric_power(t: FloatArray, k: FloatArray) -> FloatArray:
    """Return t' of y' = sign(y)|y|^k, where y = 2t − 1."""
    y = 2 * t - 1
    mapped: FloatArray = (1 + np.sign(y) * np.abs(y) ** k) / 2
    return mapped


MEAN = Moment(1 / 2, np.sqrt(1 / 12), lambda t: t, lambda t, k: t**k)
"""The mean of t, moved by t → t^k."""

VARIANCE = Moment(1 / 3, np.sqrt(4 / 45), lambda t: (2 * t - 1) ** 2, _symmetric_power)
"""The variance about 0 of y = 2t − 1, moved by y → sign(y)|y|^k."""


@dataclass(frozen=True, eq=False)
class Spread:
    """Distances of points from a centre, each with a weight, and the range that the bins divide.

    Attributes
    ----------
    center : (3,) ndarray
    radii, weights : (k,) ndarray
        Distances in mesh units; weights without unit.
    low, high : float
        Range of the bins; a point outside is in no bin.
    bins : int
    """

    center: FloatArray
    radii: FloatArray
    weights: FloatArray
    low: float
    high: float
    bins: int

    def place(self, radii: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the bins of distances, −1 for those outside the range, and their t in [0, 1]."""
        across = (radii - self.low) / (self.high - self.low) * self.bins
        inside = (across >= 0) & (across <= self.bins)
        index = np.where(inside, np.minimum(across, self.bins - 1), -1).astype(np.int64)
        return index, np.where(inside, across - index, 0.0)

    def distance(self, index: IntArray, t: FloatArray) -> FloatArray:
        """Return the distances at t of bins: the inverse of `place`."""
        return self.low + (index + t) * (self.high - self.low) / self.bins

    @cached_property
    def binned(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Bin, t and weight of the points inside the range."""
        index, t = self.place(self.radii)
        inside = index >= 0
        return index[inside], t[inside], self.weights[inside]

    @cached_property
    def counts(self) -> FloatArray:
        """Weight in each bin, (bins,)."""
        index, _, weights = self.binned
        return np.bincount(index, weights, self.bins).astype(np.float64)

    def means(self, values: FloatArray) -> FloatArray:
        """Return the weighted mean in each bin of values of the points `binned`; 0 where none is."""
        index, _, weights = self.binned
        sums = np.bincount(index, weights * values, self.bins)
        means: FloatArray = sums / np.where(self.counts > 0, self.counts, 1.0)
        return means

    def moments(self, moment: Moment) -> FloatArray:
        """Return a moment of each bin, (bins,)."""
        return self.means(moment.value(self.binned[1]))


def exponents(spread: Spread, moment: Moment, signs: SignArray, target: FloatArray) -> FloatArray:
    """Return the exponent k of each bin that brings its moment to the target, by bisection of ln k.

    Parameters
    ----------
    spread : Spread
    moment : Moment
    signs : (bins,) ndarray
        +1 where the moment must be at least the target, −1 where it must be at most that.
    target : (bins,) ndarray

    Returns
    -------
    (bins,) ndarray
        1 where the moment is there already; NaN where no k brings it there, as in an empty bin.
    """
    index, t, _ = spread.binned
    values, rising = moment.value(t), signs > 0
    low = np.where(rising, -_LARGEST_LN_K, 0.0)  # the moment falls as k rises
    high = low + _LARGEST_LN_K

    def short(ln_k: FloatArray) -> FloatArray:
        """By how much the moments miss their targets; ≤ 0 where they are reached."""
        return signs * (target - spread.means(values ** np.exp(ln_k)[index]))

    there = short(np.zeros(spread.bins)) <= 0
    reachable = (spread.counts > 0) & (short(np.where(rising, low, high)) <= 0)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        down = (short(middle) <= 0) != rising  # reached by a larger k: a smaller one may do
        high, low = np.where(down, middle, high), np.where(down, low, middle)
    k = np.exp(np.where(rising, low, high))
    return np.where(there & (spread.counts > 0), 1.0, np.where(reachable, k, np.nan))
