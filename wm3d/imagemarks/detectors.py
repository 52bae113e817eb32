"""Detectors for additive ±1 marks: each turns received coefficients into a Rademacher sum over the key.

With y_k = x_k + α w_k and w_k = ±1, every detector here is offset + Σ b_k w_k exactly; a detector is its b.
"""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy.special import digamma, gammaln

from wm3d.arrays import FloatArray, IntArray
from wm3d.component import Component
from wm3d.stats import RademacherSum

MIN_SHAPE, MAX_SHAPE = 0.1, 4.0
"""Search range of the generalized Gaussian shape under maximum likelihood."""


class GgdLrt(Component):
    """Log-likelihood ratio for generalized Gaussian coefficients (Hernández & Pérez-González 1999).

    l(y) = Σ_k β_k^c (|y_k|^c − |y_k − α w_k|^c). Each DCT frequency has its own scale, estimated from the
    blocks of the image under test.

    Attributes
    ----------
    shape : float or "ml"
        c, the same for all frequencies: 2 is Gaussian, 1 Laplacian. "ml" estimates shape and scale of each
        frequency by maximum likelihood; a fixed shape takes the scale from the root mean square.
    """

    name: Literal["ggd-lrt"] = "ggd-lrt"
    shape: Annotated[float, Field(ge=MIN_SHAPE, le=MAX_SHAPE)] | Literal["ml"] = 0.8

    def evidence(self, received: FloatArray, alpha: float) -> RademacherSum:
        """Return the statistic as a function of the key.

        Parameters
        ----------
        received : (blocks, frequencies) ndarray
            y; rows of NaN are blocks that are not read and get b = 0.
        alpha : float
            Amplitude α of the mark.

        Returns
        -------
        RademacherSum
            Over blocks × frequencies signs, in row-major order.
        """
        y = np.abs(received)
        if self.shape == "ml":
            c, power_scale = _maximum_likelihood(y)
        else:
            c = np.full(y.shape[1], self.shape)
            power_scale = _scale_from_rms(y, c)
        with_plus, with_minus = (y + alpha) ** c, np.abs(y - alpha) ** c
        b = 0.5 * power_scale * (with_plus - with_minus)
        offset = power_scale * (y**c - 0.5 * (with_plus + with_minus))
        return RademacherSum(float(np.nansum(offset)), _flat(np.copysign(b, received)))


class Linear(Component):
    """Linear correlator Σ w_k y_k / σ_k², optimal for Gaussian coefficients; σ_k² as in `GgdLrt`."""

    name: Literal["linear"] = "linear"

    def evidence(self, received: FloatArray, alpha: float) -> RademacherSum:  # noqa: ARG002 (one signature)
        """Return the statistic as a function of the key; see `GgdLrt.evidence`. α does not matter here."""
        power = _mean_over_blocks(received**2)
        return RademacherSum(0.0, _flat(received * _reciprocal(power)))


Detector = Annotated[GgdLrt | Linear, Field(discriminator="name")]
DETECTORS: dict[str, type[GgdLrt] | type[Linear]] = {"ggd-lrt": GgdLrt, "linear": Linear}


def grouped_evidence(
    detector: Detector, received: FloatArray, group: IntArray, alpha: float
) -> RademacherSum:
    """Return the statistic of coefficients that share their scale within groups of any size.

    Parameters
    ----------
    detector : Detector
    received : (n,) ndarray
        y; NaN where a coefficient is not read.
    group : (n,) ndarray of int
        Number of the group of each coefficient; does not fall.
    alpha : float
        Amplitude α of the mark.
    """
    _, group = np.unique(group, return_inverse=True)
    rank = np.arange(group.size) - np.searchsorted(group, group)
    table = np.full((rank.max() + 1, group[-1] + 1), np.nan)
    table[rank, group] = received
    evidence = detector.evidence(table, alpha)
    return RademacherSum(evidence.offset, evidence.b.reshape(table.shape)[rank, group])


def _flat(b: FloatArray) -> FloatArray:
    return np.where(np.isnan(b), 0.0, b).reshape(-1)


def _mean_over_blocks(values: FloatArray) -> FloatArray:
    """Mean of each frequency over the blocks that are read; 0 where none is."""
    read = ~np.isnan(values)
    total: FloatArray = np.where(read, values, 0.0).sum(axis=0)
    mean: FloatArray = total / np.maximum(read.sum(axis=0), 1)
    return mean


def _reciprocal(values: FloatArray) -> FloatArray:
    """1/x, and 0 for x = 0: a frequency without any energy tells nothing."""
    return np.divide(1.0, values, out=np.zeros_like(values), where=values > 0)


def _scale_from_rms(y: FloatArray, c: FloatArray) -> FloatArray:
    """β^c with β = √(Γ(3/c)/Γ(1/c)) / σ and σ the root mean square of each frequency."""
    sigma = np.sqrt(_mean_over_blocks(y**2))
    ratio = np.exp(0.5 * (gammaln(3.0 / c) - gammaln(1.0 / c)))
    scale: FloatArray = (ratio * _reciprocal(sigma)) ** c
    return scale


def _maximum_likelihood(y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shape c and β^c of each frequency, by bisecting the derivative of the profile likelihood in c.

    For a given c the likelihood peaks at β^−c = c · mean |y|^c; what remains falls through zero once at
    1 + (ψ(1/c) + ln β^−c)/c − mean(|y|^c ln |y|)/mean |y|^c.
    """
    low, high = np.full(y.shape[1], MIN_SHAPE), np.full(y.shape[1], MAX_SHAPE)
    log_y = np.log(np.where(y > 0, y, 1.0))
    for _ in range(40):
        c = 0.5 * (low + high)
        power = y**c
        mean = _mean_over_blocks(power)
        slope = (
            1.0
            + (digamma(1.0 / c) + np.log(np.where(mean > 0, c * mean, 1.0))) / c
            - _mean_over_blocks(power * log_y) * _reciprocal(mean)
        )
        low, high = np.where(slope > 0, c, low), np.where(slope > 0, high, c)
    c = 0.5 * (low + high)
    return c, _reciprocal(c * _mean_over_blocks(y**c))
