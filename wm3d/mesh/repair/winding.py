"""Faces wound alike: the side of the surface that each of them shows, from those next to it."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from wm3d.arrays import BoolArray, FloatArray, IntArray
from wm3d.mesh.repair.sides import Sides

MIXED = 0.1
"""Share of the edges between two faces that both run through in one direction, from which the winding of a
face means nothing; what clustering leaves has up to 0.07, from folds, which are flaps."""

PATCH = 20
"""Faces wound alike, below which they are a fold and no patch that someone wound the other way."""

BORDER = 0.5
"""Share of the edges around a patch, but for open ones, beyond which the faces are wound the other way; with
folds of clustering and noise it is below 0.15."""

CLEAR = 0.6
"""Share of the faces of a part that must be wound alike for the part to stay as most of it is."""


def winding_turns(sides: Sides, cones: FloatArray) -> IntArray:
    """Return 1 for the faces that stay as they are and −1 for those that must be turned over: (m,).

    Two faces must run through the edge between them in opposite directions. So every part that hangs
    together by such edges has two windings; it gets that of most of its faces, or the one that bounds a
    positive volume where neither has a clear majority. A Möbius band has none and stays as it is. Where few
    edges say otherwise, only borders of whole patches count, and folds stay.

    Parameters
    ----------
    sides : Sides
    cones : (m,) ndarray
        Signed volumes of the tetrahedra from one point to the faces.
    """
    faces = len(sides.edges)
    one, other, against = _neighbours(sides)
    if np.count_nonzero(against) <= MIXED * len(against):
        patch = _components(one[~against], other[~against], faces)
        linked = ~against | _between_patches(sides, patch, one, other, against)
        if not (linked & against).any():
            return np.ones(faces, dtype=np.int64)
        one, other, against = one[linked], other[linked], against[linked]
    # a node for each side of each face: front k, back faces + k
    across = np.where(against, faces, 0)
    rows = np.concatenate([one, one + faces])
    columns = np.concatenate([other + across, other + faces - across])
    front, back = _components(rows, columns, 2 * faces).reshape(2, faces)
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


def _components(one: IntArray, other: IntArray, nodes: int) -> IntArray:
    links = coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(nodes, nodes))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def _between_patches(
    sides: Sides, patch: IntArray, one: IntArray, other: IntArray, against: BoolArray
) -> BoolArray:
    """Tell which pairs of faces lie on either side of the border of a patch wound the other way: (pairs,)."""
    patches = int(patch.max()) + 1
    large = np.bincount(patch, minlength=patches) >= PATCH
    shared = (sides.uses[sides.edges] > 1) & (sides.direction != 0)
    rim = np.bincount(patch, shared.sum(axis=1), patches) - 2 * np.bincount(
        patch[one[~against]], minlength=patches
    )
    one, other = patch[one], patch[other]
    apart = one != other
    border = np.bincount(np.concatenate([one[apart], other[apart]]), minlength=patches)
    enclosed: BoolArray = border > BORDER * rim
    between: BoolArray = apart & large[one] & large[other] & (enclosed[one] | enclosed[other])
    return between
