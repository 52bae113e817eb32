"""Spread spectrum in the DCT of the whole image (Cox, Kilian, Leighton, Shamoon, IEEE TIP 6(12), 1997)."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy.fft import dctn, idctn

from wm3d.arrays import BoolArray, FloatArray, IntArray, SignArray
from wm3d.imagemarks.base import Alpha, ImageMark
from wm3d.imagemarks.detectors import Detector, GgdLrt, grouped_evidence
from wm3d.imagemarks.zigzag import zigzag
from wm3d.stats import RademacherSum


class Cox(ImageMark):
    """c' = c + α w on the lowest AC coefficients of the DCT of the whole image, in zig-zag order.

    Cox et al. mark the n largest coefficients by c' = c (1 + α w) and subtract the original before they
    detect. Here detection is blind: the coefficients are chosen by place, because an attack changes which are
    the largest, and the mark is additive, because without the original the coefficients themselves drown a
    multiplicative mark: its z is near α √n, 3 for their α = 0.1 and n = 1000. A step in the image, such as an
    ear in front of a back, disturbs every coefficient here, and only its own block in `dct-additive`: the
    bundled bunny reads z 0.3 to 5.1 just marked (20 seeds, default α), where 1e-6 asks for 4.75.

    Attributes
    ----------
    alpha : float
        α, in grey levels of an image that spans [0, 255]. The default has the energy of `dct-additive`.
    count : int
        n, the number of marked coefficients; an image with fewer AC coefficients has all of them marked.
    detector : Detector
        How the mark is read back; coefficients of one anti-diagonal share their scale.
    """

    name: Literal["cox"] = "cox"

    alpha: Alpha = 3.3
    count: Annotated[int, Field(ge=1)] = 1000
    detector: Detector = GgdLrt()

    def capacity(self, shape: tuple[int, int]) -> int:
        """Return how many signs an image of this shape carries: n at most."""
        return min(self.count, shape[0] * shape[1] - 1)

    def carried(self, usable: BoolArray) -> BoolArray:
        """Return which signs have a place: all of them, unless no pixel is usable."""
        return np.full(self.capacity(_shape(usable)), usable.any())

    def embed(self, image: FloatArray, signs: SignArray, usable: BoolArray | None = None) -> FloatArray:
        """Return the marked image; see `ImageMark.embed`.

        Where pixels are not usable, the part of the mark that falls on them is lost to every coefficient.
        """
        change = np.zeros(image.size)
        change[self._places(_shape(image))] = self.alpha * signs
        added = idctn(change.reshape(image.shape), norm="ortho")
        marked: FloatArray = image + (added if usable is None else np.where(usable, added, 0.0))
        return marked

    def evidence(self, image: FloatArray, usable: BoolArray | None = None) -> RademacherSum:
        """Return the detection statistic as a function of the key; see `ImageMark.evidence`.

        Pixels that are not usable are read as the mean of the others.
        """
        shape = _shape(image)
        if usable is not None:
            if not usable.any():
                return RademacherSum(0.0, np.zeros(self.capacity(shape)))
            image = np.where(usable, image, image[usable].mean())
        places = self._places(shape)
        received = dctn(image, norm="ortho").ravel()[places]
        diagonal = places // shape[1] + places % shape[1]
        return grouped_evidence(self.detector, received, diagonal, self.alpha)

    def _places(self, shape: tuple[int, int]) -> IntArray:
        return zigzag(shape)[1 : 1 + self.capacity(shape)]


def _shape(array: FloatArray | BoolArray) -> tuple[int, int]:
    rows, columns = array.shape
    return rows, columns
