"""Distortion between two meshes."""

from wm3d.metrics.budget import Budget
from wm3d.metrics.compare import METRICS, Measurement, compare, measure
from wm3d.metrics.metric import Metric
from wm3d.metrics.perceptual import msdm, msdm2
from wm3d.metrics.psnr import psnr
from wm3d.metrics.snr import snr
from wm3d.metrics.surface import hausdorff, hausdorff_error, mrms, normal_deviation
from wm3d.metrics.volume import volume_change

__all__ = [
    "METRICS",
    "Budget",
    "Measurement",
    "Metric",
    "compare",
    "hausdorff",
    "hausdorff_error",
    "measure",
    "mrms",
    "msdm",
    "msdm2",
    "normal_deviation",
    "psnr",
    "snr",
    "volume_change",
]
