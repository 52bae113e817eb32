"""Vertices that lie in one place, as at the seams of a model and all over an unwelded (STL) one."""

from typing import NamedTuple

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh.mesh import Mesh

_DIRECTION = (0.53903214837126, 0.73184917402873, 0.41729530168439)
"""Drawn at random, to all digits: with few of them rounded coordinates meet by chance."""


class Sewn(NamedTuple):
    """A mesh with one vertex in each place, and which of them stands for each vertex it had, (n,)."""

    mesh: Mesh
    place: IntArray


class Places(NamedTuple):
    """The places of n vertices: a vertex of each, (p,), and the place of each vertex, (n,)."""

    first: IntArray
    place: IntArray


def places(vertices: FloatArray) -> Places:
    """Return which of (n, 3) vertices have the same coordinates."""
    _, first, place = np.unique(marks(vertices), return_index=True, return_inverse=True)
    return Places(first, place)


def sewn(mesh: Mesh) -> Sewn:
    """Return a mesh whose faces hang together at seams; the mesh itself if no two vertices share a place.

    To its faces, each vertex is the first one in its place; the places are in the order of the file.
    """
    first, place = places(mesh.vertices)
    if len(first) == len(mesh.vertices):
        return Sewn(mesh, np.arange(len(first)))
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    place = rank[place]
    return Sewn(Mesh(mesh.vertices[first[order]], place[mesh.faces], mesh.name), place)


def marks(vertices: FloatArray) -> FloatArray:
    """Return a number for each of (n, 3) vertices, the same for those that have the same coordinates.

    Equal coordinates have equal dot products with any direction, and others differ for one chosen at random.
    Taken from a corner of the mesh, also where it lies far from the origin.
    """
    along: FloatArray = np.zeros(len(vertices))
    for axis, share in enumerate(_DIRECTION):
        column = vertices[:, axis]
        along += (column - column.min()) * share
    return along
