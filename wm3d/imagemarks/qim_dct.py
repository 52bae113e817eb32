"""Quantization index modulation of block-DCT coefficients (Chen & Wornell, IEEE Trans. IT 47(4), 2001)."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from wm3d.arrays import BoolArray, FloatArray, IntArray, SignArray
from wm3d.imagemarks.base import Alpha, ImageMark
from wm3d.imagemarks.blocks import AC, BLOCK, block_all, block_dct, inverse_block_dct
from wm3d.imagemarks.zigzag import zigzag
from wm3d.stats import RademacherSum

GOLDEN = (5**0.5 - 1) / 2
"""Multiples of the golden ratio, modulo 1, are spread evenly: the dither of consecutive coefficients."""


class QimDct(ImageMark):
    """Each marked coefficient moves to the nearest point of the lattice of its sign.

    The two lattices are Δ(ℤ + d_k ± ¼), with the dither d_k = k φ modulo 1 from the coefficient's place. What
    is read is b_k = (distance² to the lattice of −1 less distance² to that of +1) / Δ², so Σ b_k w_k is large
    for the embedded signs. The secret is in the signs, not in the lattices. The host does not disturb the
    detector, but the grey scale must come back to within a fraction of Δ: what moves the nearest or the
    farthest point of the region, or turns the pose, moves all coefficients off their lattices.

    Attributes
    ----------
    step : float
        Δ, the distance of neighbouring points of one lattice, in grey levels of an image that spans [0, 255].
    frequencies : int
        Marked AC coefficients of each 8×8 block, from the lowest in zig-zag order.
    """

    name: Literal["qim-dct"] = "qim-dct"
    strength = "step"

    step: Alpha = 12.0
    frequencies: Annotated[int, Field(ge=1, le=AC)] = 10

    def capacity(self, shape: tuple[int, int]) -> int:
        """Return how many signs an image of this shape carries: `frequencies` a block."""
        return (shape[0] // BLOCK) * (shape[1] // BLOCK) * self.frequencies

    def carried(self, usable: BoolArray) -> BoolArray:
        """Return which signs have a place: those of blocks whose pixels are all usable."""
        return np.repeat(block_all(usable), self.frequencies)

    def embed(self, image: FloatArray, signs: SignArray, usable: BoolArray | None = None) -> FloatArray:
        """Return the marked image; see `ImageMark.embed`."""
        coefficients = block_dct(image)
        move = -self._miss(coefficients[:, self._places].ravel(), signs)
        if usable is not None:
            move[~self.carried(usable)] = 0.0
        change = np.zeros_like(coefficients)
        change[:, self._places] = move.reshape(-1, self.frequencies)
        return image + inverse_block_dct(change, image.shape)

    def evidence(self, image: FloatArray, usable: BoolArray | None = None) -> RademacherSum:
        """Return the detection statistic as a function of the key; see `ImageMark.evidence`."""
        received = block_dct(image)[:, self._places].ravel()
        minus, plus = (self._miss(received, sign) / self.step for sign in (-1, 1))
        b = minus**2 - plus**2
        if usable is not None:
            b[~self.carried(usable)] = 0.0
        return RademacherSum(0.0, b)

    @property
    def _places(self) -> IntArray:
        return zigzag((BLOCK, BLOCK))[1 : 1 + self.frequencies]

    def _miss(self, values: FloatArray, signs: SignArray | int) -> FloatArray:
        """Return how far each value lies above the nearest point of the lattice of its sign."""
        dither = GOLDEN * np.arange(values.size) % 1
        phase = values / self.step - dither - 0.25 * signs
        miss: FloatArray = self.step * (phase - np.rint(phase))
        return miss
