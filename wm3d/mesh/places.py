"""Vertices that lie in one place, as at the seams of a model and all over an unwelded (STL) one."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh import kernels
from wm3d.mesh.mesh import Mesh


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


def marks(vertices: FloatArray) -> NDArray[np.uint64]:
    """Return a hash of 64 bits for each of (n, 3) vertices; equal for equal coordinates, else by chance."""
    bits = (vertices + 0.0).view(np.uint64)  # −0.0 becomes 0.0
    hashes: NDArray[np.uint64] = kernels.row_hashes(bits)
    return hashes
