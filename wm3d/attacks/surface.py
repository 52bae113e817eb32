"""What several attacks ask of a surface: neighbours, faces and vertices that count."""

import numpy as np
from scipy import sparse

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh import Mesh, adjacency


def mean_radius(mesh: Mesh) -> float:
    """Return r̄, the mean distance of the vertices from their mean: the unit of the LIRIS benchmark."""
    return float(np.linalg.norm(mesh.vertices - mesh.vertices.mean(axis=0), axis=1).mean())


def neighbour_mean(mesh: Mesh) -> sparse.csr_array:
    """Return the (n, n) matrix that puts the mean of its edge neighbours in the place of every vertex.

    A vertex without neighbours keeps its place.
    """
    joined = adjacency(mesh)
    degree = np.diff(joined.indptr)
    alone = sparse.diags_array((degree == 0).astype(float))
    mean: sparse.csr_array = (sparse.diags_array(1 / np.maximum(degree, 1)) @ joined + alone).tocsr()
    return mean


def without_unused(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Drop the vertices that no face names; the others keep their order."""
    used, renumbered = np.unique(faces, return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3)


def without_collapsed(faces: IntArray) -> IntArray:
    """Drop the faces (m, 3) that name a vertex twice."""
    a, b, c = faces.T
    kept: IntArray = faces[(a != b) & (b != c) & (c != a)]
    return kept
