"""Whole mesh watermarks: a scheme embeds a seed into a mesh and scores a seed on a mesh."""

from wm3d.schemes.base import Scheme
from wm3d.schemes.cho2007 import Cho2007Mean, Cho2007Variance
from wm3d.schemes.key import Key
from wm3d.schemes.ohbuchi2002 import Ohbuchi2002
from wm3d.schemes.radial_area import RadialArea
from wm3d.schemes.range_dct import RangeDct
from wm3d.schemes.range_mark import RangeMark
from wm3d.schemes.registry import SCHEMES
from wm3d.schemes.song2002 import Song2002
from wm3d.schemes.vertex_ss import VertexSs
from wm3d.schemes.wang2011 import Wang2011

__all__ = [
    "SCHEMES",
    "Cho2007Mean",
    "Cho2007Variance",
    "Key",
    "Ohbuchi2002",
    "RadialArea",
    "RangeDct",
    "RangeMark",
    "Scheme",
    "Song2002",
    "VertexSs",
    "Wang2011",
]
