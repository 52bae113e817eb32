"""Metrics made to agree with what observers see: structural differences of curvature."""

from wm3d.metrics.perceptual.msdm import msdm, msdm2

__all__ = ["msdm", "msdm2"]
