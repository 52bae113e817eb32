"""Additive mark in the discrete wavelet transform: ±α on the details of chosen levels."""

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
import pywt
from pydantic import AfterValidator, Field

from wm3d.arrays import BoolArray, FloatArray, IntArray, SignArray
from wm3d.imagemarks.base import Alpha, ImageMark
from wm3d.imagemarks.detectors import Detector, GgdLrt, grouped_evidence
from wm3d.stats import RademacherSum

MAX_LEVEL = 3
"""Deepest level: images have sides that are multiples of 8 = 2³."""

MODE = "periodization"
"""Border of the transform: the image repeats, so that it stays orthonormal at its own size."""

Levels = Annotated[
    tuple[Annotated[int, Field(ge=1, le=MAX_LEVEL)], ...],
    Field(min_length=1),
    AfterValidator(lambda levels: tuple(sorted(set(levels)))),
]


class DwtAdditive(ImageMark):
    """c' = c + α w on the detail coefficients of an orthonormal wavelet transform.

    Signs run from the finest chosen level to the coarsest, in each level over the horizontal, vertical and
    diagonal details, in each of these subbands in row-major order.

    Attributes
    ----------
    alpha : float
        α, in grey levels of an image that spans [0, 255]. The default has the energy of `dct-additive`.
    levels : tuple of int
        Levels whose details are marked; 1 is the finest.
    wavelet : "haar", "db2", "db4" or "sym4"
        Orthonormal wavelet, by its name in PyWavelets.
    detector : Detector
        How the mark is read back; coefficients of one subband share their scale.
    """

    name: Literal["dwt-additive"] = "dwt-additive"

    alpha: Alpha = 2.7
    levels: Levels = (2, 3)
    wavelet: Literal["haar", "db2", "db4", "sym4"] = "db2"
    detector: Detector = GgdLrt()

    @property
    def engines(self) -> tuple[str, ...]:
        """PyWavelets."""
        return ("PyWavelets",)

    def capacity(self, shape: tuple[int, int]) -> int:
        """Return how many signs an image of this shape carries: 3 · 4^−level a pixel."""
        return sum(self._sizes(shape))

    def carried(self, usable: BoolArray) -> BoolArray:
        """Return which signs have a place: those whose wavelet touches usable pixels only."""
        bank = [np.abs(taps) for taps in pywt.Wavelet(self.wavelet).filter_bank]
        touched = self._details(np.where(usable, 0.0, 1.0), pywt.Wavelet(f"|{self.wavelet}|", bank))
        free: BoolArray = touched == 0
        return free

    def embed(self, image: FloatArray, signs: SignArray, usable: BoolArray | None = None) -> FloatArray:
        """Return the marked image; see `ImageMark.embed`."""
        change = self.alpha * signs.astype(np.float64)
        if usable is not None:
            change[~self.carried(usable)] = 0.0
        return image + self._from_details(change, image.shape)

    def evidence(self, image: FloatArray, usable: BoolArray | None = None) -> RademacherSum:
        """Return the detection statistic as a function of the key; see `ImageMark.evidence`."""
        received = self._details(image, pywt.Wavelet(self.wavelet))
        if usable is not None:
            received = np.where(self.carried(usable), received, np.nan)
        return grouped_evidence(self.detector, received, self._subbands(image.shape), self.alpha)

    def _sizes(self, shape: tuple[int, ...]) -> Iterator[int]:
        """Yield the number of coefficients of each marked subband."""
        for level in self.levels:
            yield from 3 * [(shape[0] >> level) * (shape[1] >> level)]

    def _subbands(self, shape: tuple[int, ...]) -> IntArray:
        """Return the number of each coefficient's subband."""
        return np.repeat(np.arange(3 * len(self.levels)), list(self._sizes(shape)))

    def _details(self, image: FloatArray, wavelet: pywt.Wavelet) -> FloatArray:
        found = []
        smooth = image
        for level in range(1, self.levels[-1] + 1):
            smooth, details = pywt.dwt2(smooth, wavelet, mode=MODE)
            if level in self.levels:
                found += [subband.ravel() for subband in details]
        return np.concatenate(found)

    def _from_details(self, details: FloatArray, shape: tuple[int, ...]) -> FloatArray:
        """Return the image whose marked details are given and whose other coefficients are 0."""
        ends = np.cumsum(list(self._sizes(shape)))[:-1]
        subbands = np.split(details, ends)
        smooth: FloatArray = np.zeros((shape[0] >> self.levels[-1], shape[1] >> self.levels[-1]))
        for level in range(self.levels[-1], 0, -1):
            size = (shape[0] >> level, shape[1] >> level)
            first = 3 * self.levels.index(level) if level in self.levels else None
            own = [np.zeros(size)] * 3 if first is None else subbands[first : first + 3]
            smooth = pywt.idwt2((smooth, tuple(band.reshape(size) for band in own)), self.wavelet, mode=MODE)
        return smooth
