"""Peak signal-to-noise ratio between two meshes with the same vertices."""

import math

from wm3d.mesh import Mesh
from wm3d.metrics.snr import check_same_vertices


def psnr(original: Mesh, marked: Mesh) -> float:
    """Peak SNR of the vertices, 20 log10(D / RMS of ‖v' − v‖) in dB, D the diagonal of the original's box.

    Over the vertices that a face of the original uses; infinite if none of them moved. Unlike `snr` it counts
    a shift of the whole mesh as noise.

    Raises
    ------
    Wm3dError
        If the meshes do not have the same number of vertices.
    """
    check_same_vertices("PSNR", original, marked)
    used = original.used
    moves = (marked.vertices[used] - original.vertices[used]) / original.diagonal
    noise = float((moves**2).sum(axis=1).mean())
    return math.inf if noise == 0 else -10 * math.log10(noise)
