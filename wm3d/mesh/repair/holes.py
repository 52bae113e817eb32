"""Small holes, as where faces are missing, and the triangles that cover them."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh.moments import face_areas
from wm3d.mesh.repair.kernels import hole_caps
from wm3d.mesh.repair.sides import Sides

MOST_SIDES, LONGEST = 64, 1.0
"""Sides of the largest hole that is covered, and its length over the diagonal of the mesh. The rim where a
part was cut off has more, of a mesh that is not coarse."""

LARGEST = 0.3
"""Area of the largest cover over that of the part that it closes: a patch that hangs together with no other
would be given its own other side."""

ALONG = (0.53903214837126, 0.73184917402873, 0.41729530168439)
"""Direction in which rims are gone through: where holes touch, a walk that leaps about cuts off longer loops.
Drawn at random, to all digits, so that hardly two places lie level."""


def caps(corners: IntArray, sides: Sides, points: FloatArray) -> IntArray:
    """Return triangles that cover every small hole, wound as the surface around it: (k, 3) places.

    The rim runs along the edges that are out of balance, so it has as many ways into a place as out of it.

    Parameters
    ----------
    corners : (m, 3) ndarray
        The places of the faces.
    sides : Sides
        Of those faces.
    points : (p, 3) ndarray
        Where the places lie.
    """
    net = sides.net
    rim = np.repeat(np.arange(len(net)), np.abs(net))
    if len(rim) == 0:
        return np.empty((0, 3), dtype=np.int64)
    ends = np.where(net[rim] > 0, sides.ends[rim].T, sides.ends[rim, ::-1].T)
    along = np.unique(ends)
    along = along[np.argsort(points[along] @ ALONG, kind="stable")]
    rank = np.empty(len(points), dtype=np.int64)
    rank[along] = np.arange(len(along))
    start, end = rank[ends]
    order = np.lexsort((end, start))
    start, end = start[order], end[order]
    length = np.linalg.norm(points[along[start]] - points[along[end]], axis=1)
    first = np.searchsorted(start, np.arange(len(along) + 1))
    covers, loop = hole_caps(end, length, first, MOST_SIDES, LONGEST * _diagonal(points, corners))
    if len(covers) == 0:
        return np.empty((0, 3), dtype=np.int64)

    covers = along[covers]
    part = _parts(corners, len(points))
    whole = np.bincount(part[corners[:, 0]], face_areas(points, corners), part.max() + 1)
    cover = np.bincount(loop, face_areas(points, covers))
    small: IntArray = covers[cover[loop] <= LARGEST * whole[part[covers[:, 0]]]]
    return small


def _diagonal(points: FloatArray, corners: IntArray) -> float:
    """Return the diagonal of the box around the places that faces use."""
    used = np.zeros(len(points), dtype=bool)
    used[corners] = True
    return float(np.linalg.norm(np.ptp(points[used], axis=0)))


def _parts(corners: IntArray, places: int) -> IntArray:
    """Return the part of the surface that hangs together to which each place belongs: (p,)."""
    start, end = corners.ravel(), corners[:, [1, 2, 0]].ravel()
    links = coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=(places, places))
    part: IntArray = connected_components(links, directed=False)[1].astype(np.int64)
    return part
