"""Points that lie evenly on the surface of a mesh."""

from typing import NamedTuple

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh import kernels

#: Fractions of the R2 sequence (Roberts, 2018): points of a face that follow each other lie far apart.
_R2 = (0.7548776662466927, 0.5698402909980532)


class SurfacePoints(NamedTuple):
    """Points (count, 3) of a surface and the unit normals (count, 3) of their faces, by the winding."""

    points: FloatArray
    normals: FloatArray


def surface_points(vertices: FloatArray, faces: IntArray, count: int) -> SurfacePoints:
    """Return points that stand for equal areas, face after face; no chance is in it.

    Parameters
    ----------
    vertices : (n, 3) ndarray
    faces : (m, 3) ndarray
        Not all of area zero.
    count : int
    """
    reached = kernels.cumulated_area(vertices, faces)
    index = np.arange(count)
    face = np.searchsorted(reached, (index + 0.5) / count * reached[-1])
    s, t = ((0.5 + index * fraction) % 1 for fraction in _R2)
    outside = s + t > 1  # of the triangle, in the other half of the parallelogram
    s, t = np.where(outside, 1 - s, s)[:, None], np.where(outside, 1 - t, t)[:, None]
    a, b, c = np.moveaxis(vertices[faces[face]], 1, 0)
    cross = np.cross(b - a, c - a)
    return SurfacePoints(a + s * (b - a) + t * (c - a), cross / np.linalg.norm(cross, axis=1, keepdims=True))
