"""What the spectral scheme needs: the lowest modes of a mesh, and a suspect brought onto the original."""

from wm3d.schemes.spectral.modes import lowest_modes
from wm3d.schemes.spectral.registration import resampled

__all__ = ["lowest_modes", "resampled"]
