"""The false alarms of one statistic at one threshold: the exact tail, its bound, its Monte Carlo checks."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from wm3d.arrays import FloatArray
from wm3d.stats.importance import DEFAULT_RELATIVE_ERROR, ImportanceEstimate, importance_sampling
from wm3d.stats.montecarlo import DEFAULT_TRIALS, Exceedances, hadamard_keys, independent_keys
from wm3d.stats.tail import hoeffding_log10, log10_tail
from wm3d.stats.weights import checked_weights


@dataclass(frozen=True, eq=False)
class FalseAlarm:
    """P(Σ b_k w_k ≥ z √(Σ b²)) over uniform keys, and on request the ways to check it.

    Parameters
    ----------
    b : (n,) ndarray of float
        Weights.
    z : float
        Threshold in units of √(Σ b²).
    log10_p : float
        log10 of the probability, from `log10_tail`.
    hoeffding_log10 : float
        log10 of Hoeffding's upper bound.
    """

    b: FloatArray = field(repr=False)
    z: float
    log10_p: float
    hoeffding_log10: float

    @property
    def p_value(self) -> float:
        """The probability 10**log10_p; underflows to 0 below 10^−323."""
        return float(10.0**self.log10_p)

    def independent_keys(self, trials: int, seed: int = 0) -> Exceedances:
        """Check by independent keys from seeds (`wm3d.stats.independent_keys`)."""
        return independent_keys(self.b, self.z, trials, seed)

    def hadamard_keys(self, trials: int = DEFAULT_TRIALS, seed: int = 0, threads: int = 1) -> Exceedances:
        """Check by Hadamard keys (`wm3d.stats.hadamard_keys`)."""
        return hadamard_keys(self.b, self.z, trials, seed, threads)

    def importance_sampling(
        self, relative_error: float = DEFAULT_RELATIVE_ERROR, seed: int = 0
    ) -> ImportanceEstimate:
        """Check by importance sampling (`wm3d.stats.importance_sampling`)."""
        return importance_sampling(self.b, self.z, relative_error, seed)


def false_alarm(b: ArrayLike, z: float) -> FalseAlarm:
    """Return how often a uniform key scores z or more: exactly, bounded, and checkable by Monte Carlo.

    Parameters
    ----------
    b : (n,) array_like of float
        Weights of the statistic Σ b_k w_k, as in ``score.null.b``.
    z : float
        Threshold in units of √(Σ b²), as in ``score.z``.

    Returns
    -------
    FalseAlarm

    Examples
    --------
    >>> alarm = false_alarm([1.0, 1.0, 1.0], z=3**0.5)  # all three signs must be up
    >>> round(alarm.p_value, 6)
    0.125
    """
    weights = checked_weights(b)
    return FalseAlarm(
        weights,
        float(z),
        log10_tail(weights, float(z)),
        float(np.asarray(hoeffding_log10(weights, float(z)))),
    )
