"""Faces wound alike: the side of the surface that each of them shows, from those next to it."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from wm3d.arrays import BoolArray, FloatArray, IntArray
from wm3d.mesh.repair.sides import Sides

MIXED = 0.1
"""Share of the edges between two faces that both run through in one direction, from which the winding means
nothing; what clustering leaves has up to 0.07, from folds, which are flaps."""

CLEAR = 0.6
"""Share of the faces of a part that must be wound alike for the part to stay as most of it is."""


def winding_turns(sides: Sides, cones: FloatArray) -> IntArray:
    """Return 1 for the faces that stay as they are and −1 for those that must be turned over: (m,).

    Two faces must run through the edge between them in opposite directions. So every part that hangs
    together by such edges has two windings; it gets that of most of its faces, or the one that bounds a
    positive volume where neither has a clear majority. A Möbius band has none and stays as it is.

    Parameters
    ----------
    sides : Sides
    cones : (m,) ndarray
        Signed volumes of the tetrahedra from one point to the faces.
    """
    faces = len(sides.edges)
    one, other, against = _neighbours(sides)
    if np.count_nonzero(against) <= MIXED * len(against):
        return np.ones(faces, dtype=np.int64)
    # a node for each side of each face: front k, back faces + k
    across = np.where(against, faces, 0)
    rows = np.concatenate([one, one + faces])
    columns = np.concatenate([other + across, other + faces - across])
    links = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(2 * faces, 2 * faces))
    front, back = connected_components(links, directed=False)[1].reshape(2, faces)
    turns = np.sign(back - front).astype(np.int64)  # one of the two windings of each part; 0 if it has none
    part = np.minimum(front, back)
    majority = np.bincount(part, turns)
    outward = np.bincount(part, turns * cones)
    clear = np.abs(majority) >= (2 * CLEAR - 1) * np.bincount(part)
    turned = np.where(clear, majority, outward) < 0
    return np.where(turns == 0, 1, np.where(turned[part], -turns, turns))


def _neighbours(sides: Sides) -> tuple[IntArray, IntArray, BoolArray]:
    """Return the two faces at each edge that has two, and whether both run through it in one direction."""
    edge, way = sides.edges.ravel(), sides.direction.ravel()
    between = (sides.uses[edge] == 2) & (way != 0)
    order = np.argsort(edge[between], kind="stable")
    side = np.flatnonzero(between)[order].reshape(-1, 2)
    one, other = side.T // 3
    return one, other, way[side[:, 0]] == way[side[:, 1]]
