"""Registration: a mesh is laid over a few points that a key holds of the marked surface."""

from wm3d.scanner.registration.fit import Fit, nearest
from wm3d.scanner.registration.landmarks import Landmarks
from wm3d.scanner.registration.register import DOUBTFUL, SURE, UNLIKELY, posed, registered
from wm3d.scanner.registration.surface import Surface
from wm3d.scanner.registration.warp import Warp

__all__ = [
    "DOUBTFUL",
    "SURE",
    "UNLIKELY",
    "Fit",
    "Landmarks",
    "Surface",
    "Warp",
    "nearest",
    "posed",
    "registered",
]
