"""The paper's scheme: Song, Cho, Kim, "Robust Watermarking of 3D Mesh Models", IEEE MMSP 2002."""

from typing import Literal

from wm3d.imagemarks import DctAdditive, Detector, GgdLrt
from wm3d.imagemarks.base import Alpha
from wm3d.schemes.range_scheme import RangeScheme


class Song2002(RangeScheme):
    """Block-DCT spread spectrum in the range image of a virtual cylindrical scanner.

    Attributes
    ----------
    alpha : float
        α, in grey levels of a range image stretched to [0, 255].
    miss : "far-wall" or "exclude"
        Reading of a ray that meets no face: its range is 2r, the opposite wall; or its 8×8 block carries no
        mark and is not read.
    detector : Detector
        Statistic of the blind detector.
    """

    name: Literal["song2002"] = "song2002"

    alpha: Alpha = 1.3
    detector: Detector = GgdLrt()

    @property
    def image_mark(self) -> DctAdditive:
        """±α on the AC coefficients of 8×8 blocks: 63 signs a block."""
        return DctAdditive(alpha=self.alpha, detector=self.detector)
