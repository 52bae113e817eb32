"""Vertex clustering on a cubic grid (Rossignac & Borrel 1993), stopped at a wanted number of faces."""

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.attacks import kernels
from wm3d.attacks.surface import without_collapsed, without_unused

STEPS = 24
"""Bisection steps for the cell size, which they settle to 6e-8 of the mesh's extent."""

MOST_CELLS = 1 << 20
"""Cells along an edge of the grid, at most: their number in the whole grid still fits 63 bits."""


def cluster_to(vertices: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray]:
    """Return the clustered mesh whose face count comes nearest to `target`.

    Parameters
    ----------
    vertices : (n, 3) ndarray
    faces : (m, 3) ndarray
    target : int
        Wanted number of faces; the count achieved differs, for a grid does not allow every count.
    """
    coarsest = float(np.ptp(vertices, axis=0).max())
    finest = coarsest / MOST_CELLS
    best, best_miss = 0.0, abs(len(faces) - target)
    for _ in range(STEPS):
        size = 0.5 * (finest + coarsest)
        count = kernels.count_faces(vertices, faces, size)
        if abs(count - target) < best_miss and count > 0:
            best, best_miss = size, abs(count - target)
        if count == target:
            break
        finest, coarsest = (finest, size) if count < target else (size, coarsest)
    return cluster(vertices, faces, best) if best else (vertices, faces)


def cluster(vertices: FloatArray, faces: IntArray, size: float) -> tuple[FloatArray, IntArray]:
    """Merge the vertices in each cubic cell of edge `size` into their mean.

    Faces that collapse are dropped, and so are repeated faces and vertices that no face names.
    """
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    _, inverse = np.unique(kernels.cell_codes(vertices, size)[used], return_inverse=True)
    cluster_of = np.full(len(vertices), -1)
    cluster_of[used] = inverse
    count = np.bincount(inverse)
    means = np.column_stack([np.bincount(inverse, vertices[used, k]) / count for k in range(3)])
    merged = without_collapsed(cluster_of[faces])
    low, middle, high = np.sort(merged, axis=1).T
    _, first = np.unique((low * len(means) + middle) * len(means) + high, return_index=True)
    return without_unused(means, merged[np.sort(first)])
