"""A surface that can be asked for its nearest point: triangles in a balanced tree of boxes."""

from typing import NamedTuple

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.metrics.surface.tree import kernels

LEAF = 8
"""Most triangles in a leaf of the tree."""


class Nearest(NamedTuple):
    """Nearest points: `distance` (k,), `face` (k,), its `vertices` (k, 3) and their `weights` (k, 3)."""

    distance: FloatArray
    face: IntArray
    vertices: IntArray
    weights: FloatArray


class Surface:
    """The triangles of a mesh, for exact nearest-point queries.

    Parameters
    ----------
    vertices : (n, 3) ndarray
        Of the order of 1 in size: products of four lengths must neither overflow nor vanish.
    faces : (m, 3) ndarray

    Attributes
    ----------
    faces : (m, 3) ndarray
        The faces, neighbours near each other. `Nearest.face` counts in this order.
    corners : (m, 3, 3) ndarray
        Their corners.
    normals : (m, 3) ndarray
        Twice their vector areas.
    points : (k, 3) ndarray
        The vertices that a face uses, neighbours near each other.
    """

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        corners = vertices[faces]
        order = tree_order(corners.mean(axis=1))
        self.faces, self.corners = faces[order], corners[order]
        self._boxes, self._frames = boxes(self.corners), kernels.frames(self.corners)
        a, b, c = self.corners[:, 0], self.corners[:, 1], self.corners[:, 2]
        self.normals = np.cross(b - a, c - a)
        self.points = vertices[_by_first_use(self.faces, len(vertices))]

    def nearest(self, points: FloatArray) -> Nearest:
        """Return the nearest points to (k, 3) points; fast where points follow their neighbours."""
        square, face, weights = kernels.nearest(points, self.corners, self._frames, self._boxes)
        return Nearest(np.sqrt(square), face, self.faces[face], weights)


def _by_first_use(faces: IntArray, count: int) -> IntArray:
    """Return the vertices that a face uses in the order of the faces; np.unique would sort all corners."""
    corners = faces.ravel()
    first = np.full(count, -1)
    first[corners[::-1]] = np.arange(len(corners))[::-1]  # of equal places the last one written stays
    order: IntArray = corners[np.sort(first[first >= 0])]
    return order


def tree_order(points: FloatArray) -> IntArray:
    """Order (n, 3) points by repeated median splits along the longest axis, neighbours near each other."""
    order: IntArray = kernels.tree_order(np.ascontiguousarray(points.T), _depth(len(points)))
    return order


def _depth(count: int) -> int:
    """Return the number of splits until no part has more than `LEAF` points."""
    depth = 0
    while (count - 1) >> depth >= LEAF:
        depth += 1
    return depth


def boxes(corners: FloatArray) -> FloatArray:
    """Return the boxes (2^(depth+1) − 1, 6), low corner then high, of a tree over triangles (m, 3, 3).

    Points, as (m, 1, 3), have one too. Node k of level l holds the triangles from ⌊m k / 2^l⌋ to
    ⌊m (k+1) / 2^l⌋. Its place is 2^l − 1 + k, so that the children of place i are 2i + 1 and 2i + 2.
    """
    depth = _depth(len(corners))
    starts = len(corners) * np.arange(1 << depth) >> depth
    low = np.minimum.reduceat(corners.min(axis=1), starts)
    high = np.maximum.reduceat(corners.max(axis=1), starts)
    levels = [np.column_stack([low, high])]
    while len(low) > 1:
        low, high = np.minimum(low[::2], low[1::2]), np.maximum(high[::2], high[1::2])
        levels.append(np.column_stack([low, high]))
    return np.vstack(levels[::-1])
