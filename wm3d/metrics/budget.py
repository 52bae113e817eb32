"""Budgets of distortion: how far a mark may change a mesh, in one metric."""

import math
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, model_validator

from wm3d.mesh import Mesh
from wm3d.metrics.perceptual import msdm2
from wm3d.metrics.snr import snr
from wm3d.metrics.surface import mrms

MOST_SNR = 300.0
"""SNR in dB at which a mark is as fine as the last digits of double precision."""

_NAMES = {"snr": ("SNR", " dB"), "mrms": ("MRMS", " %"), "msdm2": ("MSDM2", "")}


class Budget(BaseModel):
    """A wanted distortion.

    Attributes
    ----------
    metric : "snr", "mrms" or "msdm2"
    value : float
        SNR in dB, MRMS in percent of the diagonal of the original's bounding box, or MSDM2.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    metric: Literal["snr", "mrms", "msdm2"]
    value: float

    @model_validator(mode="after")
    def _attainable(self) -> Self:
        if self.metric == "snr" and not 0 < self.value <= MOST_SNR:
            raise ValueError(
                f"a mark cannot be set to {self.in_words()}; it must be above 0 and at most {MOST_SNR:g} dB"
            )
        if self.metric != "snr" and self.value <= 0:
            raise ValueError(f"{self.in_words()} leaves no room for a mark")
        return self

    def label(self) -> str:
        """Return the legend text, for example "SNR 44 dB"."""
        return self.in_words().removeprefix("an ").replace(" of ", " ")

    def in_words(self) -> str:
        """Return how a sentence says it, for example "an SNR of 44 dB"."""
        name, unit = _NAMES[self.metric]
        return f"an {name} of {self.value:g}{unit}"

    def measured(self, original: Mesh, marked: Mesh) -> float:
        """Return the distortion of a marked mesh in the unit of `value`."""
        if self.metric == "snr":
            return snr(original, marked)
        if self.metric == "mrms":
            return 100 * mrms(original, marked) / original.diagonal
        return msdm2(original, marked)

    def headroom(self, reached: float) -> float:
        """Return how much stronger a mark of this distortion may become, in dB; negative if it is too strong.

        20 log10 of wanted over reached, where SNR counts by the noise amplitude that it stands for.
        """
        if self.metric == "snr":
            return reached - self.value
        return 20 * math.log10(self.value / reached) if reached > 0 else math.inf
