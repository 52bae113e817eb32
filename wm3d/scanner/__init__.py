"""The virtual cylindrical scanner: pose, scanning cylinder, range image."""

from wm3d.scanner.cylinder import Cylinder
from wm3d.scanner.pose import VertexPca
from wm3d.scanner.scan import RangeImage, scan

POSES = {"vertex-pca": VertexPca}

__all__ = ["POSES", "Cylinder", "RangeImage", "VertexPca", "scan"]
