"""Comparison of two surfaces by the nearest points of one to the other, whatever their connectivity."""

from wm3d.metrics.surface.distances import (
    OneWay,
    both_ways,
    check_size,
    hausdorff,
    hausdorff_error,
    mrms,
    normal_deviation,
)
from wm3d.metrics.surface.nearest import Nearest, Surface, boxes, tree_order

__all__ = [
    "Nearest",
    "OneWay",
    "Surface",
    "both_ways",
    "boxes",
    "check_size",
    "hausdorff",
    "hausdorff_error",
    "mrms",
    "normal_deviation",
    "tree_order",
]
