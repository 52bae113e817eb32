"""The paper's image watermark: ±α added to every AC coefficient of the 8×8 block DCT (section III-A)."""

from typing import Literal

import numpy as np

from wm3d.arrays import BoolArray, FloatArray, SignArray
from wm3d.imagemarks.base import Alpha, ImageMark
from wm3d.imagemarks.blocks import AC, BLOCK, block_all, block_dct, inverse_block_dct
from wm3d.imagemarks.detectors import Detector, GgdLrt
from wm3d.stats import RademacherSum


class DctAdditive(ImageMark):
    """c' = c + α w on the AC coefficients of 8×8 blocks, w = ±1 from the key.

    Attributes
    ----------
    alpha : float
        α, in grey levels of an image that spans [0, 255].
    detector : Detector
        How the mark is read back.
    """

    name: Literal["dct-additive"] = "dct-additive"
    alpha: Alpha = 1.3
    detector: Detector = GgdLrt()

    @staticmethod
    def capacity(shape: tuple[int, int]) -> int:
        """Return how many signs an image of this shape carries: 63 a block."""
        return (shape[0] // BLOCK) * (shape[1] // BLOCK) * AC

    def carried(self, usable: BoolArray) -> BoolArray:
        """Return which signs have a place: those of blocks whose pixels are all usable."""
        return np.repeat(block_all(usable), AC)

    def embed(self, image: FloatArray, signs: SignArray, usable: BoolArray | None = None) -> FloatArray:
        """Return the marked image.

        Parameters
        ----------
        image : (8 p, 8 q) ndarray
            Grey levels in [0, 255]; the marked image is neither clipped nor rounded.
        signs : (63 p q,) ndarray
            w, ±1.
        usable : (8 p, 8 q) ndarray of bool, optional
            Blocks with a pixel that is not usable stay as they are.
        """
        change = np.zeros((signs.size // AC, AC + 1))
        change[:, 1:] = self.alpha * signs.reshape(-1, AC)
        if usable is not None:
            change[~block_all(usable)] = 0.0
        return image + inverse_block_dct(change, image.shape)  # the DCT is linear

    def evidence(self, image: FloatArray, usable: BoolArray | None = None) -> RademacherSum:
        """Return the detection statistic as a function of the key; parameters as for `embed`."""
        received = block_dct(image)[:, 1:]
        if usable is not None:
            received = np.where(block_all(usable)[:, None], received, np.nan)
        return self.detector.evidence(received, self.alpha)
