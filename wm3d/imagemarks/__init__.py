"""2-D watermarks of a range image: embed(image, signs) and evidence(image), and the detectors they use."""

from wm3d.imagemarks.base import ImageMark
from wm3d.imagemarks.dct_additive import DctAdditive
from wm3d.imagemarks.detectors import DETECTORS, Detector, GgdLrt, Linear

__all__ = ["DETECTORS", "DctAdditive", "Detector", "GgdLrt", "ImageMark", "Linear"]
