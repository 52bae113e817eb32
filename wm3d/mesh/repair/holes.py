"""Small holes, as where faces are missing, and the triangles that cover them."""

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh.repair.kernels import hole_caps
from wm3d.mesh.repair.sides import Sides

MOST_SIDES, LONGEST = 64, 1.0
"""Sides of the largest hole that is covered, and its length over the diagonal of the mesh; the rim where a
part was cut off has more."""


def caps(sides: Sides, points: FloatArray) -> IntArray:
    """Return triangles that cover every small hole, wound as the surface around it: (k, 3) places.

    The rim runs along the edges that are out of balance, so it has as many ways into a place as out of it. A
    face that hangs together with no other has no rim, for its cover would be its other side.

    Parameters
    ----------
    sides : Sides
    points : (p, 3) ndarray
        The places.
    """
    alone = (sides.uses[sides.edges] == 1).all(axis=1)
    net = sides.turned(np.where(alone, 0, 1)).net
    rim = np.repeat(np.arange(len(net)), np.abs(net))
    start, end = np.where(net[rim] > 0, sides.ends[rim].T, sides.ends[rim, ::-1].T)
    order = np.argsort(start, kind="stable")
    start, end = start[order], end[order]
    length = np.linalg.norm(points[start] - points[end], axis=1)
    longest = LONGEST * float(np.linalg.norm(np.ptp(points, axis=0)))
    places, numbers = np.unique(np.concatenate([start, end]), return_inverse=True)
    first = np.searchsorted(numbers[: len(rim)], np.arange(len(places) + 1))
    covered: IntArray = places[hole_caps(numbers[len(rim) :], length, first, MOST_SIDES, longest)]
    return covered
