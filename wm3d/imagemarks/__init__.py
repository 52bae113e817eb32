"""2-D watermarks of a range image: embed(image, signs) and evidence(image), and the detectors they use."""

from wm3d.imagemarks.base import ImageMark
from wm3d.imagemarks.cox import Cox
from wm3d.imagemarks.dct_additive import DctAdditive
from wm3d.imagemarks.detectors import DETECTORS, Detector, GgdLrt, Linear
from wm3d.imagemarks.dwt_additive import DwtAdditive
from wm3d.imagemarks.qim_dct import QimDct
from wm3d.imagemarks.registry import IMAGEMARKS

__all__ = [
    "DETECTORS",
    "IMAGEMARKS",
    "Cox",
    "DctAdditive",
    "Detector",
    "DwtAdditive",
    "GgdLrt",
    "ImageMark",
    "Linear",
    "QimDct",
]
