"""A block-DCT mark for volume images that follows the host: amplitudes, detector, what an embedder climbs.

The image is host + A·p: the volume behind a cell grows by its surface area A times the move p of the
surface.
"""

from dataclasses import dataclass

import numpy as np

from wm3d.arrays import BoolArray, FloatArray, SignArray
from wm3d.imagemarks.blocks import AC, BLOCK, block_dct
from wm3d.stats import RademacherSum

SHAPING = 0.3
"""Amplitudes fall with this power of the host's scale over area; with 0, all moves would be equal."""

MOST_AMPLITUDE = 2.0
"""Largest amplitude, over that of the median coefficient."""

LEAST_AREA = 0.05
"""Least surface area of a block that carries a mark, over the mean of all."""

MARGIN = 2.0
"""By how much of a mark's usual amplitude an informed embedder wants a coefficient on its side."""

_ROUNDS = 20
_UNMIXINGS = 2  # a third changes z by 0.3 % at most


@dataclass(frozen=True, eq=False)
class ShapedDct:
    """What a volume image says of each AC coefficient of its 8×8 blocks.

    Attributes
    ----------
    received : (blocks, 63) ndarray
        y, the coefficients, in the unit of the volumes.
    scale : (blocks, 63) ndarray
        Mean size of the host's coefficients: activity of the block times profile of the frequency.
    area : (blocks, 1) ndarray
        Mean area of the block's cells, in squared units: how fast y grows when the surface moves.
    amplitude : (blocks, 63) ndarray
        Relative amplitude of the moves; 1 for the median coefficient, 0 where a block carries no mark.
    """

    received: FloatArray
    scale: FloatArray
    area: FloatArray
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
        return cls(received, scale, area, amplitude)

    @property
    def response(self) -> FloatArray:
        """How much y grows with a mark of unit strength: (blocks, 63)."""
        return self.amplitude * self.area

    @property
    def carries(self) -> BoolArray:
        """Which blocks carry a mark: (blocks,)."""
        return np.asarray((self.amplitude > 0).any(axis=1))

    def pattern(self, signs: SignArray) -> FloatArray:
        """Return the moves of a mark of unit strength, as DCT coefficients: (blocks, 64), no DC."""
        moves = np.zeros((len(self.amplitude), AC + 1))
        moves[:, 1:] = self.amplitude * signs.reshape(-1, AC)
        return moves

    def strength_of(self, change: FloatArray, signs: SignArray) -> float:
        """Fit the strength of a key's mark to a change of the coefficients, (blocks, 63): least squares."""
        return float((change * signs.reshape(-1, AC) * self.response).sum() / (self.response**2).sum())

    def evidence(self, strength: float) -> RademacherSum:
        """Return the agreement of a key with the likely signs of the coefficients.

        Taken as a Laplacian host of mean size σ plus or minus a, y lets expect the sign
        tanh((|y + a| − |y − a|) / 2σ); a key scores the sum over its signs. σ is the scale of what is left of
        y without the mark.

        Parameters
        ----------
        strength : float
            Of the mark that survives in the image, in the unit of length of `volumes`.
        """
        a = strength * self.response
        scale = self._unmarked_scale(a)
        return RademacherSum(0.0, _expected_sign(self.received, a, scale).reshape(-1))

    def _unmarked_scale(self, a: FloatArray) -> FloatArray:
        """Scale of the host under a mark of amplitude a whose signs are not known, by EM."""
        scale, y = self.scale, self.received
        for _ in range(_UNMIXINGS):
            plus = 0.5 * (1.0 + _expected_sign(y, a, scale))
            scale = activity_scale(plus * np.abs(y - a) + (1.0 - plus) * np.abs(y + a))
        return scale


def _expected_sign(y: FloatArray, a: FloatArray, scale: FloatArray) -> FloatArray:
    ratio = np.divide(np.abs(y + a) - np.abs(y - a), 2.0 * scale, out=np.zeros_like(y), where=scale > 0)
    expected: FloatArray = np.tanh(ratio)
    return expected


@dataclass(frozen=True, eq=False)
class Agreement:
    """How well coefficients y say the signs s of a key: Σ w m / √(1 + m²) with m = s y / τ.

    τ is `MARGIN` times the amplitude a that the pattern of the key would have: beyond it little is gained,
    and a host that is against the sign by much more is left alone. w = min(1, a/σ), for the detector listens
    little where the host is far larger than the mark.

    Attributes
    ----------
    per_margin : (blocks, 63) ndarray
        s / τ; zero where nothing is read.
    weight : (blocks, 63) ndarray
    """

    per_margin: FloatArray
    weight: FloatArray

    @classmethod
    def of(cls, mark: ShapedDct, signs: SignArray, change: FloatArray) -> "Agreement | None":
        """Measure the usual amplitude in what the pattern of a key changes; None if it comes to nothing."""
        strength = mark.strength_of(change, signs)
        if strength <= 0:
            return None
        a, read = strength * mark.response, mark.response > 0
        contrast = np.divide(a, mark.scale, out=np.zeros_like(a), where=read)
        per_margin = np.divide(signs.reshape(-1, AC), MARGIN * a, out=np.zeros_like(a), where=read)
        return cls(per_margin, np.minimum(1.0, contrast))

    def gradient(self, coefficients: FloatArray) -> FloatArray:
        """Return the slope of the agreement along each of (blocks, 63) coefficients."""
        slope: FloatArray = (
            self.weight * self.per_margin / (1.0 + (self.per_margin * coefficients) ** 2) ** 1.5
        )
        return slope

    @property
    def curvature(self) -> FloatArray:
        """Bound of the change of that slope: (blocks, 63)."""
        return self.weight * self.per_margin**2


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
