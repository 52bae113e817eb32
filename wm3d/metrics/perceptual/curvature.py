"""Curvature of a triangle mesh at its vertices, averaged over balls of a given radius."""

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.metrics.perceptual import kernels
from wm3d.metrics.perceptual.connectivity import Connectivity


def mean_absolute_curvature(
    vertices: FloatArray, faces: IntArray, connectivity: Connectivity, radius: float
) -> FloatArray:
    """Return K = (|k1| + |k2|) / 2 at each vertex, in one over the unit of the vertices.

    k1 and k2 are the two eigenvalues of largest magnitude of the curvature tensor of Cohen-Steiner and Morvan
    (2003), as Alliez et al. (ACM TOG 22(3), 2003) and MSDM use it: (1/|B|) Σ β(e) ‖e ∩ B‖ ē ēᵀ over the edges
    e in a ball B about the vertex, β(e) the signed angle between the normals at the edge, ē its direction,
    and |B| = πr².

    Parameters
    ----------
    vertices : (n, 3) ndarray
    faces : (m, 3) ndarray
    connectivity : Connectivity
        Of the same faces.
    radius : float
        r, in the unit of the vertices.

    Returns
    -------
    (n,) ndarray
        0 at vertices that no face uses.
    """
    first, vertex, edge = connectivity.neighbours
    angles = connectivity.dihedral_angles(vertices, faces)[edge]
    tensors = kernels.curvature_tensors(vertices, first, vertex, angles, radius)
    magnitudes = np.sort(np.abs(np.linalg.eigvalsh(tensors)), axis=1)
    curvature: FloatArray = magnitudes[:, 1:].mean(axis=1)
    return curvature
