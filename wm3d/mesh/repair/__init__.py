"""What a broken mesh means: its surface, of single faces wound alike, without flaps and small holes."""

from wm3d.mesh.repair.parts import Part, large_parts
from wm3d.mesh.repair.whole import whole_surface

__all__ = ["Part", "large_parts", "whole_surface"]
