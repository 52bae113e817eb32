"""What the patch scheme needs: the frame of volume moments, patches in it, and their smooth deformation."""

from wm3d.schemes.patches.deformation import deformed
from wm3d.schemes.patches.frame import Frame, volume_frame
from wm3d.schemes.patches.grid import Patches

__all__ = ["Frame", "Patches", "deformed", "volume_frame"]
