"""Fine signs: further signs of a key in the phase of each coefficient, for attacks that change it little.

The sign of a coefficient survives rough attacks, and that is all that it can say. Where an attack changes
coefficients by less than the mark did, they can say more: quantization index modulation (Chen and Wornell,
IEEE Transactions on Information Theory 47(4), 2001) moves each to the nearest of those values, one every step
Δ, that say the signs of its layers. That costs moves of about Δ/√12, however strong the host is.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq
from scipy.special import ive

from wm3d.arrays import FloatArray, SignArray
from wm3d.imagemarks.blocks import AC
from wm3d.imagemarks.shaped_dct import ShapedDct

LAYERS = 3
"""Fine signs of a coefficient; each layer has a fourth of the step of the one before."""

STEP = 0.75
"""Step of the first layer, over the root mean square amplitude of the mark in its block: larger ones outlive
more, and cost the plain signs more."""

_RATIO = 4.0  # a quarter of a step is a whole one of the next layer, which so knows nothing of it

LEAST_MEAN, CLEARLY = 0.05, 4.0
"""Least mean of −cos 2θ of a layer that is read, and by how many of its standard deviations it must be above
zero: what an attack has taken would add noise to what is left."""

_SHARPEST = 500.0


@dataclass(frozen=True, eq=False)
class FineSigns:
    """The values that say fine signs w_j = ±1: y = Δ m + Σ_j w_j Δ_j / 4 with Δ_j = Δ / 4^j, m an integer.

    Attributes
    ----------
    step : (blocks, 1) ndarray
        Δ of each block, in the unit of the coefficients; 0 where a block carries none.
    """

    step: FloatArray

    @classmethod
    def beside(cls, mark: ShapedDct, strength: float) -> "FineSigns":
        """Make steps in proportion to a mark of some strength, block by block."""
        amplitude = strength * mark.response
        step = STEP * np.sqrt((amplitude**2).mean(axis=1, keepdims=True))
        return cls(step.astype(np.float32).astype(float))  # as a key file holds them

    @property
    def capacity(self) -> int:
        """Number of fine signs."""
        return LAYERS * AC * len(self.step)

    def nearest(self, coefficients: FloatArray, signs: SignArray) -> FloatArray:
        """Return the nearest values that say fine signs.

        Parameters
        ----------
        coefficients : (blocks, 63) ndarray
        signs : (capacity,) array of ±1
            Layer by layer.

        Returns
        -------
        (blocks, 63) ndarray
            At most half a step away; the coefficients themselves where a block carries no fine signs.
        """
        layers = signs.reshape(LAYERS, -1, AC)
        quarters = sum(layers[j] * (0.25 / _RATIO**j) for j in range(LAYERS))
        turns = quarters - coefficients / self._divisor
        nearest: FloatArray = coefficients + (turns - np.round(turns)) * self.step
        return nearest

    def expected(self, mark: ShapedDct) -> FloatArray:
        """Return the fine sign to expect of each coefficient that was received.

        A phase θ = 2π y / Δ_j is taken as von Mises distributed around w π/2 with a concentration κ, so the
        sign to expect is tanh(κ sin θ). Both signs have the same −cos 2θ, of mean I₂(κ)/I₀(κ): so κ is found
        without knowing them, one for each layer, from those coefficients that reach over half a step.

        Returns
        -------
        (capacity,) ndarray
            Layer by layer, all 0 for a layer that is not clearly there.
        """
        reach = (mark.scale > 0.5 * self.step) & (self.step > 0)
        expected = np.zeros((LAYERS, *mark.received.shape))
        for j in range(LAYERS):
            phase = (2.0 * np.pi * _RATIO**j) * mark.received / self._divisor
            kappa = _kappa(-np.cos(2.0 * phase[reach]))
            expected[j] = np.where(self.step > 0, np.tanh(kappa * np.sin(phase)), 0.0)
        return expected.reshape(-1)

    @cached_property
    def _divisor(self) -> FloatArray:
        return np.where(self.step > 0, self.step, np.inf)


def _kappa(doubled: FloatArray) -> float:
    """Concentration κ of which I₂(κ)/I₀(κ) is the mean of −cos 2θ; 0 where that is not clearly above 0."""
    if doubled.size == 0:
        return 0.0
    mean = float(doubled.mean())
    if mean < max(LEAST_MEAN, CLEARLY / np.sqrt(2 * doubled.size)):
        return 0.0

    def excess(kappa: float) -> float:
        return float(ive(2, kappa) / ive(0, kappa)) - mean

    return float(brentq(excess, 0.0, _SHARPEST)) if excess(_SHARPEST) > 0 else _SHARPEST
