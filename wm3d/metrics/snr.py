"""Signal-to-noise ratio between two meshes with the same vertices (eq. 13 of the paper)."""

import math

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, kernels


def snr(original: Mesh, marked: Mesh) -> float:
    """Return 10 log10(var{v − m} / var{v' − v}) in dB, variances summed over x, y, z (eq. 13).

    Over the vertices that a face of the original uses: others are no part of the surface. Infinite if none of
    them moved.

    Raises
    ------
    Wm3dError
        If the meshes do not have the same number of vertices.
    """
    check_same_vertices("SNR", original, marked)
    used = original.used
    signal = _variance(original.vertices[used])
    noise = _variance(marked.vertices[used] - original.vertices[used])
    return math.inf if noise == 0 else 10 * math.log10(signal / noise)


def _variance(vectors: FloatArray) -> float:
    return float(np.trace(kernels.vertex_covariance(vectors, kernels.vertex_mean(vectors))))


def check_same_vertices(metric: str, original: Mesh, marked: Mesh) -> None:
    """Raise `Wm3dError` unless both meshes have the same number of vertices."""
    if original.vertices.shape != marked.vertices.shape:
        raise Wm3dError(
            f"{metric} compares vertex by vertex, but {original.name} has {len(original.vertices)} vertices "
            f"and {marked.name} has {len(marked.vertices)}."
        )
