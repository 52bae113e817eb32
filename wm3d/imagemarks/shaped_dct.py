"""A block-DCT mark for volume images whose strength follows the model: amplitudes, and their detector.

The image is host + A·p: the volume behind a cell grows by its surface area A times the move p of the
surface.
"""

from dataclasses import dataclass

import numpy as np

from wm3d.arrays import BoolArray, FloatArray, SignArray
from wm3d.imagemarks.blocks import AC, BLOCK, block_dct
from wm3d.stats import RademacherSum

SHAPE = 0.8
"""c of the generalized Gaussian of the scaled coefficients, as for the paper's detector."""

SHAPING = 0.5
"""Amplitudes fall with this power of the host's scale: between equal moves (0) and equal contrast (−1)."""

MOST_AMPLITUDE = 2.0
"""Largest amplitude, over that of the median coefficient."""

LEAST_AREA = 0.05
"""Least surface area of a block that carries a mark, over the mean of all."""

_ROUNDS = 20


@dataclass(frozen=True, eq=False)
class ShapedDct:
    """What a volume image says of each AC coefficient of its 8×8 blocks.

    Attributes
    ----------
    received : (blocks, 63) ndarray
        y, the coefficients, in the unit of the volumes.
    scale : (blocks, 63) ndarray
        Mean size of the host's coefficients: activity of the block times profile of the frequency.
    response : (blocks, 63) ndarray
        How much y grows with a mark of unit strength: amplitude times mean area of the block's cells.
    amplitude : (blocks, 63) ndarray
        Relative amplitude of the moves; 1 for the median coefficient, 0 where a block carries no mark.
    """

    received: FloatArray
    scale: FloatArray
    response: FloatArray
    amplitude: FloatArray

    @classmethod
    def of(cls, volumes: FloatArray, areas: FloatArray) -> "ShapedDct":
        """Read a volume image: two arrays of shape (8 p, 8 q)."""
        received = block_dct(volumes)[:, 1:]
        scale = activity_scale(received)
        rows, columns = areas.shape
        area = areas.reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK).mean(axis=(1, 3)).reshape(-1, 1)
        carries = (area > LEAST_AREA * area.mean()) & (scale > 0)
        contrast = np.divide(scale, area, out=np.ones_like(scale), where=carries)
        amplitude = _amplitude(contrast, carries)
        return cls(received, scale, amplitude * area, amplitude)

    @property
    def carries(self) -> BoolArray:
        """Which blocks carry a mark: (blocks,)."""
        return np.asarray((self.amplitude > 0).any(axis=1))

    def pattern(self, signs: SignArray) -> FloatArray:
        """Return the moves of a mark of unit strength, as DCT coefficients: (blocks, 64), no DC."""
        moves = np.zeros((len(self.amplitude), AC + 1))
        moves[:, 1:] = self.amplitude * signs.reshape(-1, AC)
        return moves

    def evidence(self, strength: float) -> RademacherSum:
        """Return the log-likelihood ratio as a function of the key.

        That of `GgdLrt`, with a scale and an amplitude of its own for every coefficient.

        Parameters
        ----------
        strength : float
            Of the mark that survives in the image, in the unit of length of `volumes`.
        """
        known = self.amplitude > 0
        y = np.divide(self.received, self.scale, out=np.zeros_like(self.scale), where=known)
        alpha = np.divide(strength * self.response, self.scale, out=np.zeros_like(self.scale), where=known)
        with_plus, with_minus = np.abs(y + alpha) ** SHAPE, np.abs(y - alpha) ** SHAPE
        offset = (np.abs(y) ** SHAPE - 0.5 * (with_plus + with_minus)).sum()
        return RademacherSum(float(offset), (0.5 * (with_plus - with_minus)).reshape(-1))


def activity_scale(received: FloatArray) -> FloatArray:
    """Fit |y| ≈ activity of the block × profile of the frequency, by alternate means.

    Parameters
    ----------
    received : (blocks, frequencies) ndarray

    Returns
    -------
    (blocks, frequencies) ndarray
        The product; zero for blocks and frequencies that are zero throughout.
    """
    size = np.abs(received)
    activity, profile = size.mean(axis=1, keepdims=True), np.ones((1, size.shape[1]))
    for _ in range(_ROUNDS):
        live = activity > 0
        profile = np.divide(size, activity, out=np.zeros_like(size), where=live).sum(axis=0, keepdims=True)
        profile = profile / max(live.sum(), 1)
        heard = profile > 0
        activity = np.divide(size, profile, out=np.zeros_like(size), where=heard).sum(axis=1, keepdims=True)
        activity = activity / max(heard.sum(), 1)
    scale: FloatArray = activity * profile
    return scale


def _amplitude(contrast: FloatArray, carries: BoolArray) -> FloatArray:
    if not carries.any():
        return np.zeros_like(contrast)
    relative = (np.median(contrast[carries]) / contrast) ** SHAPING
    return np.where(carries, np.minimum(relative, MOST_AMPLITUDE), 0.0)
