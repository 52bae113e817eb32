"""Normals of the vertices of a mesh."""

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.mesh import kernels
from wm3d.mesh.mesh import Mesh
from wm3d.mesh.moments import orientation


def vertex_normals(mesh: Mesh) -> FloatArray:
    """Return the outward unit normals (n, 3), the area-weighted means of those of the faces.

    Outward as `orientation` tells it, whichever way the faces are wound; zero where a vertex has no face.
    """
    sums = orientation(mesh) * kernels.normal_sums(mesh.vertices, mesh.faces)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    normals: FloatArray = sums / np.where(length > 0, length, 1.0)
    return normals
