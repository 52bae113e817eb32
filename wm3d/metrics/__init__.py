"""Distortion between two meshes."""

from wm3d.metrics.snr import snr

METRICS = {"snr": snr}

__all__ = ["METRICS", "snr"]
