"""Numba kernel of the renderer; its plain numpy twin is `wm3d.bench.render.rasterize_reference`."""

import math

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray


@njit(cache=True, error_model="numpy")
def rasterize(
    points: FloatArray, faces: IntArray, height: int, width: int
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Find the nearest face at the centre of each pixel.

    Parameters
    ----------
    points : (n, 3) ndarray
        Vertices on the picture: x to the right and y downwards in pixels, depth towards the viewer.
    faces : (m, 3) ndarray
    height, width : int
        Pixels.

    Returns
    -------
    face : (height, width) ndarray of int
        −1 where there is none.
    depth : (height, width) ndarray
        −inf where there is no face.
    weights : (height, width, 3) ndarray
        Barycentric coordinates of the pixel's centre in its face.
    """
    face = np.full((height, width), -1, np.int64)
    depth = np.full((height, width), -math.inf)
    weights = np.zeros((height, width, 3))
    for f in range(len(faces)):
        a, b, c = points[faces[f, 0]], points[faces[f, 1]], points[faces[f, 2]]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        if area == 0.0:
            continue
        left, right = min(a[0], b[0], c[0]), max(a[0], b[0], c[0])
        top, bottom = min(a[1], b[1], c[1]), max(a[1], b[1], c[1])
        for y in range(max(math.ceil(top - 0.5), 0), min(math.floor(bottom - 0.5) + 1, height)):
            for x in range(max(math.ceil(left - 0.5), 0), min(math.floor(right - 0.5) + 1, width)):
                px, py = x + 0.5, y + 0.5
                wa = ((b[0] - px) * (c[1] - py) - (c[0] - px) * (b[1] - py)) / area
                wb = ((c[0] - px) * (a[1] - py) - (a[0] - px) * (c[1] - py)) / area
                wc = 1.0 - wa - wb
                if wa < 0.0 or wb < 0.0 or wc < 0.0:
                    continue
                z = wa * a[2] + wb * b[2] + wc * c[2]
                if z > depth[y, x]:
                    face[y, x], depth[y, x] = f, z
                    weights[y, x, 0], weights[y, x, 1], weights[y, x, 2] = wa, wb, wc
    return face, depth, weights
