"""What several attacks ask of a surface: neighbours, normals, faces and vertices that count."""

import numpy as np
from scipy import sparse

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh import Mesh


def mean_radius(mesh: Mesh) -> float:
    """Return r̄, the mean distance of the vertices from their mean: the unit of the LIRIS benchmark."""
    return float(np.linalg.norm(mesh.vertices - mesh.vertices.mean(axis=0), axis=1).mean())


def neighbour_mean(mesh: Mesh) -> sparse.csr_array:
    """Return the (n, n) matrix that puts the mean of its edge neighbours in the place of every vertex.

    A vertex without neighbours keeps its place.
    """
    n = len(mesh.vertices)
    start, end = mesh.faces.ravel(), mesh.faces[:, [1, 2, 0]].ravel()
    real = start != end
    start, end = start[real], end[real]
    links = sparse.coo_array((np.ones(2 * len(start)), (np.r_[start, end], np.r_[end, start])), shape=(n, n))
    adjacency = links.tocsr()
    adjacency.data[:] = 1.0  # an edge of two faces was counted twice
    degree = np.diff(adjacency.indptr)
    alone = sparse.diags_array((degree == 0).astype(float))
    mean: sparse.csr_array = (sparse.diags_array(1 / np.maximum(degree, 1)) @ adjacency + alone).tocsr()
    return mean


def vertex_normals(mesh: Mesh) -> FloatArray:
    """Return unit normals (n, 3), the area-weighted means of those of the faces; zero where there is none."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    doubled = np.cross(b - a, c - a)
    corners, n = mesh.faces.T.ravel(), len(mesh.vertices)
    sums = np.column_stack([np.bincount(corners, np.tile(doubled[:, k], 3), n) for k in range(3)])
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    normals: FloatArray = sums / np.where(length > 0, length, 1.0)
    return normals


def without_unused(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Drop the vertices that no face names; the others keep their order."""
    used, renumbered = np.unique(faces, return_inverse=True)
    return vertices[used], renumbered.reshape(-1, 3)


def without_collapsed(faces: IntArray) -> IntArray:
    """Drop the faces (m, 3) that name a vertex twice."""
    a, b, c = faces.T
    kept: IntArray = faces[(a != b) & (b != c) & (c != a)]
    return kept
