"""Which vertices an edge joins."""

import numpy as np
from scipy import sparse

from wm3d.mesh.mesh import Mesh


def adjacency(mesh: Mesh) -> sparse.csr_array:
    """Return the (n, n) matrix with 1 where an edge of a face joins two vertices, 0 elsewhere."""
    n = len(mesh.vertices)
    start, end = mesh.faces.ravel(), mesh.faces[:, [1, 2, 0]].ravel()
    real = start != end
    start, end = start[real], end[real]
    links = sparse.coo_array((np.ones(2 * len(start)), (np.r_[start, end], np.r_[end, start])), shape=(n, n))
    joined: sparse.csr_array = links.tocsr()
    joined.data[:] = 1.0  # an edge of two faces was counted twice
    return joined
