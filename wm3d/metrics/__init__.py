"""Distortion between two meshes."""

from wm3d.metrics.snr import snr

__all__ = ["snr"]
