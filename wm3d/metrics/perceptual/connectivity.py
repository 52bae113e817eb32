"""Who is whose neighbour on a surface, and the angle between the faces at each edge."""

from typing import NamedTuple

import numpy as np

from wm3d.arrays import BoolArray, FloatArray, IntArray

FOLD = 1e-8
"""Tangent of an angle between planes, below which they count as one."""


class Neighbours(NamedTuple):
    """The neighbours of vertex i are `vertex`[`first`[i]:`first`[i+1]]; `edge` numbers the edges to them.

    `first` (n + 1,), `vertex` (2 k,), `edge` (2 k,) for k edges.
    """

    first: IntArray
    vertex: IntArray
    edge: IntArray


class Connectivity:
    """The edges of a mesh.

    Parameters
    ----------
    faces : (m, 3) ndarray
    count : int
        Number of vertices, n.

    Attributes
    ----------
    neighbours : Neighbours
    used : (n,) ndarray of bool
        Whether a face uses the vertex.
    """

    def __init__(self, faces: IntArray, count: int) -> None:
        start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
        proper = start != end
        start, end = start[proper], end[proper]
        face = np.repeat(np.arange(len(faces)), 3)[proper]
        low, high = np.minimum(start, end), np.maximum(start, end)
        keys, edge = np.unique(low * count + high, return_inverse=True)
        self._ends = np.column_stack([keys // count, keys % count])
        self._left, self._right = _sides(edge, face, start == low, len(keys))
        self.neighbours = _neighbours(self._ends, count)
        self.used = np.zeros(count, np.bool_)
        self.used[faces] = True

    def dihedral_angles(self, vertices: FloatArray, faces: IntArray) -> FloatArray:
        """Return the angle (k,) in radians from the normal of one face to that of the other at each edge.

        Positive where the surface is convex; 0 at edges without exactly two faces of one winding.
        """
        angles = np.zeros(len(self._ends))
        pairs = np.flatnonzero((self._left >= 0) & (self._right >= 0))
        a, b, c = vertices[faces.T]
        normals = np.cross(b - a, c - a)
        left, right = normals[self._left[pairs]], normals[self._right[pairs]]
        along = vertices[self._ends[pairs, 1]] - vertices[self._ends[pairs, 0]]
        length = np.linalg.norm(along, axis=1)
        cosine = np.einsum("kx,kx->k", left, right)
        sine = np.einsum("kx,kx->k", np.cross(left, right), along) / np.where(length > 0, length, 1.0)
        # of a face folded back onto its neighbour only rounding would tell the sign
        sine = np.where(np.abs(sine) < FOLD * np.abs(cosine), np.abs(sine), sine)
        angles[pairs] = np.arctan2(sine, cosine)
        return angles


def _sides(edge: IntArray, face: IntArray, forward: BoolArray, count: int) -> tuple[IntArray, IntArray]:
    """Face on the left and on the right of each edge; −1 where there is none, or more than one."""
    sides = []
    for which in (forward, ~forward):
        side = np.full(count, -1)
        side[edge[which]] = face[which]
        side[np.bincount(edge[which], minlength=count) != 1] = -1
        sides.append(side)
    return sides[0], sides[1]


def _neighbours(ends: IntArray, count: int) -> Neighbours:
    start, end = np.concatenate([ends[:, 0], ends[:, 1]]), np.concatenate([ends[:, 1], ends[:, 0]])
    order = np.argsort(start, kind="stable")
    first = np.concatenate([[0], np.cumsum(np.bincount(start, minlength=count))])
    return Neighbours(first, end[order], order % len(ends))
