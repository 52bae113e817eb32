"""The schemes by name."""

from wm3d.registry import Registry
from wm3d.schemes.base import Scheme
from wm3d.schemes.range_mark import RangeMark
from wm3d.schemes.song2002 import Song2002

SCHEMES: Registry[Scheme] = Registry("scheme", Scheme, Song2002, RangeMark)  # type: ignore[type-abstract]
