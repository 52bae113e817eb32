"""Confidence intervals of a proportion, from trials or from batches of trials, of a mean, of a quantile."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import betaincinv, nctdtrit, ndtri, stdtrit

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError

DEFAULT_CONFIDENCE = 0.95
"""Confidence of every interval, unless the caller names another."""

QUOTABLE_COUNT = 10
"""An empirical probability is quoted from at least this many events, that is from 10/Pf trials."""


class Interval(NamedTuple):
    """A two-sided confidence interval; both ends have the shape of what it is about."""

    low: FloatArray
    high: FloatArray


def clopper_pearson(
    successes: ArrayLike, trials: ArrayLike, confidence: float = DEFAULT_CONFIDENCE
) -> Interval:
    """Return the exact interval of a proportion.

    Parameters
    ----------
    successes, trials : array_like of float
        Counts; fractional counts are allowed, for effective sample sizes. No trials give (0, 1).
    confidence : float
        Coverage in (0, 1).

    Returns
    -------
    Interval
        Ends in [0, 1], of the broadcast shape (Clopper and Pearson, Biometrika 26, 1934).

    Raises
    ------
    Wm3dError
        If a count is negative or above its trials, or the confidence is not in (0, 1).
    """
    k, n = np.broadcast_arrays(np.asarray(successes, float), np.asarray(trials, float))
    if not ((k >= 0) & (k <= n)).all():
        raise Wm3dError("Successes must be between 0 and the number of trials.")
    tail = _tail(confidence)
    # at the ends the beta distribution has a zero parameter; the interval is closed there by definition
    low = np.where(k > 0, betaincinv(np.where(k > 0, k, 1), n - k + 1, tail), 0.0)
    high = np.where(k < n, betaincinv(k + 1, np.where(k < n, n - k, 1), 1 - tail), 1.0)
    return Interval(low, high)


def korn_graubard(
    events: ArrayLike,
    squares: ArrayLike,
    batches: int,
    batch_size: int,
    confidence: float = DEFAULT_CONFIDENCE,
) -> Interval:
    """Return the interval of a proportion from batches that are independent while their trials are not.

    Parameters
    ----------
    events : array_like of float
        Σ c over the batches, c the number of events in one batch.
    squares : array_like of float
        Σ c² over the batches.
    batches : int
        How many independent batches.
    batch_size : int
        Trials in each.
    confidence : float
        Coverage in (0, 1).

    Returns
    -------
    Interval
        Of the shape of `events`.

    Notes
    -----
    The Clopper–Pearson interval at the effective number of trials n/deff · (t_{n−1}/t_{batches−1})²
    (Korn and Graubard, Survey Methodology 24, 1998), deff being the variance of the batch counts over the
    binomial one. deff is taken as at least 1; it is 1 where the batches cannot tell it: fewer than two
    batches, no event, or nothing but events.
    """
    k, square = np.broadcast_arrays(np.asarray(events, float), np.asarray(squares, float))
    n = float(batches * batch_size)
    known = (k > 0) & (k < n) & (batches > 1)
    deff = np.ones(k.shape)
    if known.any():
        spread = (square - k**2 / batches) / (batches - 1)
        np.divide(spread, k / batches * (1 - k / n), out=deff, where=known)
        few = (stdtrit(batches - 1, _tail(confidence)) / stdtrit(n - 1, _tail(confidence))) ** 2
        deff = np.where(known, np.maximum(deff, 1.0) * few, 1.0)
    return clopper_pearson(k / deff, n / deff, confidence)


def student_t(values: ArrayLike, confidence: float = DEFAULT_CONFIDENCE) -> Interval:
    """Return the interval of the mean of independent values, mean ± t s/√n.

    Parameters
    ----------
    values : (n,) array_like of float
        Exact for Gaussian values. Fewer than two tell nothing of their spread: NaN.
    confidence : float
        Coverage in (0, 1).

    Returns
    -------
    Interval
        t is the quantile of Student's law of n − 1 degrees of freedom, s² the variance over n − 1.
    """
    x, tail = np.asarray(values, dtype=np.float64), _tail(confidence)
    if x.size < 2:
        return Interval(np.array(np.nan), np.array(np.nan))
    reach = -stdtrit(x.size - 1, tail) * x.std(ddof=1) / np.sqrt(x.size)
    return Interval(x.mean() - reach, x.mean() + reach)


def tolerance_bound(
    mean: ArrayLike,
    std: ArrayLike,
    trials: ArrayLike,
    share: float = 0.99,
    confidence: float = DEFAULT_CONFIDENCE,
) -> FloatArray:
    """Return what at least a share of all values exceeds, for independent Gaussian values: mean − k s.

    Parameters
    ----------
    mean, std : array_like of float
        Of the values seen; the variance is that over n − 1.
    trials : array_like of int
        How many values, n. Fewer than two tell nothing: −∞.
    share : float
        In (0, 1).
    confidence : float
        In (0, 1), of the one-sided bound.

    Returns
    -------
    ndarray
        √n k is the quantile of the noncentral t law of n − 1 degrees of freedom about √n Φ⁻¹(share)
        (Wallis, Selected Techniques of Statistical Analysis, 1947).

    Raises
    ------
    Wm3dError
        If share or confidence are not in (0, 1).
    """
    _check_fraction("share", share)
    _check_fraction("confidence", confidence)
    centre, spread, n = np.broadcast_arrays(*(np.asarray(part, float) for part in (mean, std, trials)))
    enough = n > 1
    root = np.sqrt(np.where(enough, n, 2.0))
    k = nctdtrit(root**2 - 1, root * ndtri(share), confidence) / root
    bound: FloatArray = np.where(enough, centre - k * np.where(enough, spread, 0.0), -np.inf)
    return bound


def quoted(events: ArrayLike, trials: ArrayLike) -> FloatArray:
    """Return events/trials where that may be quoted: NaN below `QUOTABLE_COUNT` events.

    Parameters
    ----------
    events, trials : array_like of int
        Counts. A probability Pf has 10 events or more when it is estimated from 10/Pf trials or more.
    """
    k, n = np.broadcast_arrays(np.asarray(events, float), np.asarray(trials, float))
    share: FloatArray = np.divide(k, n, out=np.full(k.shape, np.nan), where=k >= QUOTABLE_COUNT)
    return share


def _tail(confidence: float) -> float:
    _check_fraction("confidence", confidence)
    return (1 - confidence) / 2


def _check_fraction(name: str, value: float) -> None:
    if not 0 < value < 1:
        raise Wm3dError(f"The {name} is {value}; it must be between 0 and 1, for example 0.95.")
