"""Faces that bound nothing: flaps that stick out of a surface where a simplifier folded it flat."""

import numpy as np

from wm3d.arrays import IntArray
from wm3d.mesh.repair.sides import Sides

SIDES, SHARED = 3, 2
"""Of a face, and faces at an edge of a surface that is whole."""

LOOSE = 2
"""Sides of a face that run in the more frequent direction of their edges, from which it may be a flap."""

MOST = 0.5
"""Share of the faces from which they are not flaps but a soup."""


def flap_turns(sides: Sides) -> IntArray:
    """Return 1 for faces that stay as they are, 0 for flaps, −1 for those that are turned over: (m,).

    Where a simplifier folds a thin part flat, faces lie on each other, and one that drops repeated faces
    leaves a single one, with the solid on neither side or on the wrong one. No ray minds, but an integral
    over the surface counts the whole cone behind it. Each edge of a closed surface is run through as often in
    one direction as in the other; a flap is a face by whose removal more of its edges come into that balance
    than fall out of it. One whose edges all want a face of the other winding is turned over instead. The
    rim of an open mesh stays: a flap hangs at an edge of three faces or more, or at another flap.

    A soup of faces that hang together nowhere has no flaps.
    """
    edges, direction = sides.edges, sides.direction
    uses, net = sides.uses, sides.net
    turns = np.ones(len(edges), dtype=np.int64)
    while True:
        excess = (net[edges] * direction > 0) & (turns == 1)[:, None]
        loose, at_rim = excess.sum(axis=1), (uses[edges] == 1).any(axis=1)
        hangs = (loose == SIDES) | (loose >= LOOSE) & (excess & (uses[edges] > SHARED)).any(axis=1)
        if hangs.mean() > MOST:
            return np.ones_like(turns)
        changed, hanging = False, np.flatnonzero(hangs)
        order = np.argsort((-2 * loose - at_rim)[hanging], kind="stable")
        for face in hanging[order]:  # the likeliest first: each may bare the next
            its, way = edges[face], direction[face]
            if (net[its] * way > 0).sum() < LOOSE:
                continue  # a removal before has set it right
            changed = True
            over = (net[its] * way > 1).all()
            turns[face] = -1 if over else 0
            net[its] -= (2 if over else 1) * way
            uses[its] -= 0 if over else 1
        if not changed:
            return turns if turns.any() else np.ones_like(turns)
