"""The image marks by name."""

from wm3d.imagemarks.base import ImageMark
from wm3d.imagemarks.cox import Cox
from wm3d.imagemarks.dct_additive import DctAdditive
from wm3d.imagemarks.dwt_additive import DwtAdditive
from wm3d.imagemarks.qim_dct import QimDct
from wm3d.registry import Registry

IMAGEMARKS: Registry[ImageMark] = Registry("imagemark", ImageMark, DctAdditive, Cox, DwtAdditive, QimDct)  # type: ignore[type-abstract]
