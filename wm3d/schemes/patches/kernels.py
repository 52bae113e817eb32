"""Numba kernel of patch volumes: faces clipped to the cells of a cylindrical grid."""

import math

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray

_CORNERS = 8  # of a triangle after two slab planes and two half-planes: seven at most


@njit(cache=True, error_model="numpy")
def patch_volumes(
    posed: FloatArray, faces: IntArray, low: float, high: float, rows: int, sectors: int
) -> FloatArray:
    """Return the volume between each patch and the axis: (rows, sectors).

    The flux of the field (0, y, z)/2, of divergence 1, through the part of the surface in a cell is the
    volume between that part and the axis: through planes across the axis and half-planes along it, it is 0.

    Parameters
    ----------
    posed : (n, 3) ndarray
        Height h and the coordinates y, z across the axis.
    faces : (m, 3) ndarray
    low, high : float
        Heights that the rows divide.
    rows, sectors : int
        Cells along and around; at least three around, so that a cell is convex.
    """
    volumes = np.zeros((rows, sectors))
    row, sector = np.empty(3, dtype=np.int64), np.empty(3, dtype=np.int64)
    slab, cell = np.empty((_CORNERS, 3)), np.empty((_CORNERS, 3))
    spare = np.empty((_CORNERS, 3))
    step, turn = (high - low) / rows, 2 * math.pi / sectors
    for f in range(len(faces)):
        for k in range(3):
            h, y, z = posed[faces[f, k], 0], posed[faces[f, k], 1], posed[faces[f, k], 2]
            row[k] = min(max(math.floor((h - low) / step), 0), rows - 1)
            sector[k] = min(math.floor(math.atan2(z, y) % (2 * math.pi) / turn), sectors - 1)
        _load(posed, faces, f, slab)
        first, last = min(row[0], row[1], row[2]), max(row[0], row[1], row[2])
        start, stop = min(sector[0], sector[1], sector[2]), max(sector[0], sector[1], sector[2])
        if 2 * (stop - start + 1) > sectors:  # across the angle 0, or around the axis
            start, stop = 0, sectors - 1
        if first == last and sector[0] == sector[1] == sector[2]:
            volumes[first, sector[0]] += _flux(slab, 3)
            continue
        for i in range(first, last + 1):
            _load(posed, faces, f, slab)
            count = 3
            if i > first:
                count = _clip(slab, count, spare, 1.0, 0.0, 0.0, low + i * step)
            if i < last:
                count = _clip(slab, count, spare, -1.0, 0.0, 0.0, -(low + (i + 1) * step))
            for j in range(start, stop + 1):
                for k in range(count):
                    for axis in range(3):
                        cell[k, axis] = slab[k, axis]
                left, right = j * turn, (j + 1) * turn
                inside = _clip(cell, count, spare, 0.0, -math.sin(left), math.cos(left), 0.0)
                inside = _clip(cell, inside, spare, 0.0, math.sin(right), -math.cos(right), 0.0)
                volumes[i, j] += _flux(cell, inside)
    return volumes


@njit(cache=True, error_model="numpy")
def _load(posed: FloatArray, faces: IntArray, face: int, corners: FloatArray) -> None:
    for k in range(3):
        for axis in range(3):
            corners[k, axis] = posed[faces[face, k], axis]


@njit(cache=True, error_model="numpy")
def _clip(
    polygon: FloatArray, count: int, spare: FloatArray, nh: float, ny: float, nz: float, least: float
) -> int:
    """Keep the part of a convex polygon where n·p ≥ least, in place (Sutherland, Hodgman 1974)."""
    kept = 0
    for k in range(count):
        n = (k + 1) % count
        here = nh * polygon[k, 0] + ny * polygon[k, 1] + nz * polygon[k, 2] - least
        there = nh * polygon[n, 0] + ny * polygon[n, 1] + nz * polygon[n, 2] - least
        if here >= 0.0:
            for axis in range(3):
                spare[kept, axis] = polygon[k, axis]
            kept += 1
        if (here >= 0.0) != (there >= 0.0):
            share = here / (here - there)
            for axis in range(3):
                spare[kept, axis] = polygon[k, axis] + share * (polygon[n, axis] - polygon[k, axis])
            kept += 1
    for k in range(kept):
        for axis in range(3):
            polygon[k, axis] = spare[k, axis]
    return kept


@njit(cache=True, error_model="numpy")
def _flux(polygon: FloatArray, count: int) -> float:
    """Flux of (0, y, z)/2 through a convex polygon, by its fan of triangles."""
    total, h, y, z = 0.0, polygon[0, 0], polygon[0, 1], polygon[0, 2]
    for k in range(1, count - 1):
        e0, e1, e2 = polygon[k, 0] - h, polygon[k, 1] - y, polygon[k, 2] - z
        d0, d1, d2 = polygon[k + 1, 0] - h, polygon[k + 1, 1] - y, polygon[k + 1, 2] - z
        total += (e2 * d0 - e0 * d2) * (3 * y + e1 + d1) + (e0 * d1 - e1 * d0) * (3 * z + e2 + d2)
    return total / 12.0
