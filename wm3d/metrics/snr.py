"""Signal-to-noise ratio between two meshes with the same vertices (eq. 13 of the paper)."""

import math

import numpy as np

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, kernels, vertex_moments


def snr(original: Mesh, marked: Mesh) -> float:
    """Return 10 log10(var{v − m} / var{v' − v}) in dB, variances summed over x, y, z (eq. 13).

    Infinite if no vertex moved.

    Raises
    ------
    Wm3dError
        If the meshes do not have the same number of vertices.
    """
    check_same_vertices("SNR", original, marked)
    moves = marked.vertices - original.vertices
    signal = np.trace(vertex_moments(original).covariance)
    noise = np.trace(kernels.vertex_covariance(moves, kernels.vertex_mean(moves)))
    return math.inf if noise == 0 else 10 * math.log10(signal / noise)


def check_same_vertices(metric: str, original: Mesh, marked: Mesh) -> None:
    """Raise `Wm3dError` unless both meshes have the same number of vertices."""
    if original.vertices.shape != marked.vertices.shape:
        raise Wm3dError(
            f"{metric} compares vertex by vertex, but {original.name} has {len(original.vertices)} vertices "
            f"and {marked.name} has {len(marked.vertices)}."
        )
