"""The schemes by name."""

from wm3d.registry import Registry
from wm3d.schemes.base import Scheme
from wm3d.schemes.cho2007 import Cho2007Mean, Cho2007Variance
from wm3d.schemes.ohbuchi2002 import Ohbuchi2002
from wm3d.schemes.radial_area import RadialArea
from wm3d.schemes.range_dct import RangeDct
from wm3d.schemes.range_mark import RangeMark
from wm3d.schemes.song2002 import Song2002
from wm3d.schemes.vertex_ss import VertexSs
from wm3d.schemes.wang2011 import Wang2011

SCHEMES: Registry[Scheme] = Registry(
    "scheme",
    Scheme,  # type: ignore[type-abstract]
    Song2002,
    RangeDct,
    RangeMark,
    Cho2007Mean,
    Cho2007Variance,
    RadialArea,
    VertexSs,
    Wang2011,
    Ohbuchi2002,
)
