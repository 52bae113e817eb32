"""Polygons of a file as triangles."""

import mapbox_earcut
import numpy as np

from wm3d.arrays import BoolArray, FloatArray, IntArray

MOST_CORNERS = 64
"""Corners of a polygon up to which another corner is looked for from which to split it."""

ROUNDING = 1e-12
"""Share of a polygon's area by which a triangle of none, as at a doubled corner, may face the other way."""


def triangulated(vertices: FloatArray, corners: IntArray, lengths: IntArray) -> IntArray:
    """Split polygons into fans, in their order: (m, 3).

    A fan starts at the first corner, or where its triangles would fold over each other, as in a concave
    polygon, at the first from which none does. If there is no such corner, ears are cut off one by one; what
    has none either, as a polygon that crosses itself, is the fan of its first corner.

    Parameters
    ----------
    vertices : (n, 3) ndarray
    corners : (sum of lengths,) ndarray of int
        Corners of one polygon after the other.
    lengths : (k,) ndarray of int
        Corners of each, 3 at least.
    """
    if (lengths == 3).all():
        return corners.reshape(-1, 3)
    first = np.cumsum(lengths) - lengths
    ahead = np.cumsum(lengths - 2) - (lengths - 2)
    triangles = np.empty((int((lengths - 2).sum()), 3), np.int64)
    for length in np.unique(lengths):
        alike = np.flatnonzero(lengths == length)
        polygons = corners[first[alike][:, None] + np.arange(length)]
        triangles[ahead[alike][:, None] + np.arange(length - 2)] = _fans(vertices, polygons)
    return triangles


def _fans(vertices: FloatArray, polygons: IntArray) -> IntArray:
    """Return the fans of (k, c) polygons: (k, c − 2, 3)."""
    fans = _fan(polygons)
    corners = polygons.shape[1]
    in_range = polygons.size and polygons.min() >= 0 and polygons.max() < len(vertices)  # else Mesh says so
    if not in_range or not 3 < corners <= MOST_CORNERS:
        return fans
    normal = _areas(vertices, fans).sum(axis=1)
    folded = np.flatnonzero(_folds(vertices, fans, normal))
    for start in range(1, corners):
        if not folded.size:
            break
        tried = _fan(np.roll(polygons[folded], -start, axis=1))
        folds = _folds(vertices, tried, normal[folded])
        fans[folded[~folds]] = tried[~folds]
        folded = folded[folds]
    for k in folded:
        ears = _ears(vertices[polygons[k]], normal[k])
        if len(ears) == corners - 2 and not _folds(vertices, polygons[k][ears][None], normal[k][None])[0]:
            fans[k] = polygons[k][ears]
    return fans


def _ears(polygon: FloatArray, normal: FloatArray) -> IntArray:
    """Cut (c, 3) corners into triangles, seen along the normal; fewer than c − 2 where corners coincide."""
    across = int(np.argmax(np.abs(normal)))  # the plane of the other two axes shows most of it
    one, other = ((1, 2), (2, 0), (0, 1))[across]
    flat = polygon[:, [one, other]]
    ears = mapbox_earcut.triangulate_float64(flat, np.array([len(flat)], np.uint32)).reshape(-1, 3)
    a, b, c = flat[ears].transpose(1, 2, 0)
    turns = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    backwards = turns * normal[across] < 0
    ears[backwards] = ears[backwards][:, ::-1]
    return ears.astype(np.int64)


def _fan(polygons: IntArray) -> IntArray:
    start = np.broadcast_to(polygons[:, :1], polygons[:, 2:].shape)
    return np.stack([start, polygons[:, 1:-1], polygons[:, 2:]], axis=2)


def _areas(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return twice the area vector of each of (..., 3) triangles."""
    with np.errstate(all="ignore"):  # what no mesh may hold is told by `Mesh`
        a, b, c = np.moveaxis(vertices[triangles], -2, 0)
        areas: FloatArray = np.cross(b - a, c - a)
    return areas


def _folds(vertices: FloatArray, fans: IntArray, normal: FloatArray) -> BoolArray:
    """Tell of each fan whether one of its triangles faces the other way than the polygon: (k,)."""
    with np.errstate(all="ignore"):
        facing = np.einsum("kti,ki->kt", _areas(vertices, fans), normal)
        least = -ROUNDING * np.einsum("ki,ki->k", normal, normal)
    folds: BoolArray = (facing < least[:, None]).any(axis=1)
    return folds
