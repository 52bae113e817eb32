"""wm3d: the open benchmark for watermarks in 3D meshes."""

from wm3d import attacks, schemes, stats
from wm3d.api import detect, embed
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, load_mesh, save_mesh
from wm3d.metrics import snr
from wm3d.scanner import scan
from wm3d.schemes import Key

__all__ = [
    "Key",
    "Mesh",
    "Wm3dError",
    "attacks",
    "detect",
    "embed",
    "load_mesh",
    "save_mesh",
    "scan",
    "schemes",
    "snr",
    "stats",
]
