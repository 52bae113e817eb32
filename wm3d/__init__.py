"""wm3d: the open benchmark for watermarks in 3D meshes.

What `__all__` names is imported when it is first used, so that ``wm3d --help`` need not wait for numba.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from wm3d.errors import Wm3dError

if TYPE_CHECKING:
    from wm3d import attacks, schemes, stats
    from wm3d.api import detect, embed
    from wm3d.mesh import Mesh, load_mesh, save_mesh
    from wm3d.metrics import compare, snr
    from wm3d.scanner import scan
    from wm3d.schemes import Key

    __version__: str
else:
    _HOMES = {
        "Key": "wm3d.schemes",
        "Mesh": "wm3d.mesh",
        "compare": "wm3d.metrics",
        "detect": "wm3d.api",
        "embed": "wm3d.api",
        "load_mesh": "wm3d.mesh",
        "save_mesh": "wm3d.mesh",
        "scan": "wm3d.scanner",
        "snr": "wm3d.metrics",
    }
    _PACKAGES = ("attacks", "schemes", "stats")

    def __getattr__(name: str) -> Any:
        if name in _PACKAGES:
            return import_module(f"wm3d.{name}")
        if name == "__version__":
            return import_module("importlib.metadata").version("wm3d")
        if name not in _HOMES:
            raise AttributeError(f"module 'wm3d' has no attribute {name!r}")
        globals()[name] = value = getattr(import_module(_HOMES[name]), name)
        return value

    def __dir__() -> list[str]:
        return __all__


__all__ = [
    "Key",
    "Mesh",
    "Wm3dError",
    "__version__",
    "attacks",
    "compare",
    "detect",
    "embed",
    "load_mesh",
    "save_mesh",
    "scan",
    "schemes",
    "snr",
    "stats",
]
