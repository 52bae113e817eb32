"""Small holes, as where faces are missing, and the triangles that cover them."""

import numpy as np

from wm3d.arrays import IntArray
from wm3d.mesh.repair.kernels import hole_caps
from wm3d.mesh.repair.sides import Sides

MOST_SIDES = 64
"""Sides of the largest hole that is covered; where a part was cut off, the rim is longer."""


def caps(sides: Sides) -> IntArray:
    """Return triangles that cover every small hole, wound as the surface around it: (k, 3) places.

    The rim runs along the edges that are out of balance, so it has as many ways into a place as out of it. A
    face that hangs together with no other has no rim, for its cover would be its other side.
    """
    alone = (sides.uses[sides.edges] == 1).all(axis=1)
    net = sides.turned(np.where(alone, 0, 1)).net
    rim = np.repeat(np.arange(len(net)), np.abs(net))
    start, end = np.where(net[rim] > 0, sides.ends[rim].T, sides.ends[rim, ::-1].T)
    order = np.argsort(start, kind="stable")
    places, numbers = np.unique(np.concatenate([start[order], end[order]]), return_inverse=True)
    first = np.searchsorted(numbers[: len(rim)], np.arange(len(places) + 1))
    covered: IntArray = places[hole_caps(numbers[len(rim) :], first, MOST_SIDES)]
    return covered
