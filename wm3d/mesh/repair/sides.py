"""The sides of faces and the edges between places that they lie along."""

from typing import NamedTuple

import numpy as np

from wm3d.arrays import IntArray


class Sides(NamedTuple):
    """Along which edge each side of each face lies, and which way the face runs through it.

    Attributes
    ----------
    edges : (m, 3) ndarray
        The edge.
    direction : (m, 3) ndarray
        1 from the lower to the higher place, −1 the other way, 0 for a side that is a point.
    ends : (e, 2) ndarray
        The lower and the higher place of each edge.
    """

    edges: IntArray
    direction: IntArray
    ends: IntArray

    @classmethod
    def of(cls, corners: IntArray) -> "Sides":
        """Return the sides of faces whose corners lie in given places: (m, 3)."""
        after = corners[:, [1, 2, 0]]
        low, high = np.minimum(corners, after), np.maximum(corners, after)
        places = int(corners.max()) + 1
        codes, edges = np.unique(low * places + high, return_inverse=True)
        return cls(edges.reshape(-1, 3), np.sign(after - corners), np.column_stack(np.divmod(codes, places)))

    @property
    def uses(self) -> IntArray:
        """How many sides lie along each edge: (e,)."""
        return np.bincount(self.edges.ravel(), minlength=len(self.ends))

    @property
    def net(self) -> IntArray:
        """How much more often faces run up each edge than down: (e,); 0 throughout on a closed surface."""
        return np.bincount(self.edges.ravel(), self.direction.ravel(), len(self.ends)).astype(np.int64)

    @property
    def at_variance(self) -> bool:
        """Whether two faces that are alone at an edge run through it in one direction."""
        return bool(((self.uses == 2) & (np.abs(self.net) == 2)).any())

    def turned(self, turns: IntArray) -> "Sides":
        """Return the sides without the faces where ``turns`` (m,) is 0, and with those turned where −1."""
        kept = turns != 0
        return Sides(self.edges[kept], (self.direction * turns[:, None])[kept], self.ends)
