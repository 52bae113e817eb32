"""Vertices that lie in one place, as at the seams of a model and all over an unwelded (STL) one."""

from typing import NamedTuple

import numpy as np

from wm3d.arrays import FloatArray, IntArray

_DIRECTION = (0.53903214837126, 0.73184917402873, 0.41729530168439)
"""Drawn at random, to all digits: with few of them rounded coordinates meet by chance."""


class Places(NamedTuple):
    """The places of n vertices: a vertex of each, (p,), and the place of each vertex, (n,)."""

    first: IntArray
    place: IntArray


def places(vertices: FloatArray) -> Places:
    """Return which of (n, 3) vertices have the same coordinates."""
    _, first, place = np.unique(marks(vertices), return_index=True, return_inverse=True)
    return Places(first, place)


def marks(vertices: FloatArray) -> FloatArray:
    """Return a number for each of (n, 3) vertices, the same for those that have the same coordinates.

    Equal coordinates have equal dot products with any direction, and others differ for one chosen at random.
    """
    x, y, z = _DIRECTION
    along: FloatArray = vertices[:, 0] * x + vertices[:, 1] * y + vertices[:, 2] * z
    return along
