"""Whole mesh watermarks: a scheme embeds a seed into a mesh and scores a seed on a mesh."""

from wm3d.schemes.base import Scheme
from wm3d.schemes.key import Key
from wm3d.schemes.range_mark import RangeMark
from wm3d.schemes.registry import SCHEMES
from wm3d.schemes.song2002 import Song2002

__all__ = ["SCHEMES", "Key", "RangeMark", "Scheme", "Song2002"]
