"""Reordering: the same surface in another order of vertices and faces (LIRIS benchmark)."""

from typing import Literal

import numpy as np

from wm3d.attacks.base import Attack
from wm3d.mesh import Mesh


class Reorder(Attack):
    """Vertices and faces in a random order, the "file attack" of the LIRIS benchmark (SMI 2010)."""

    name: Literal["reorder"] = "reorder"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the reordered mesh; see `Attack`."""
        order = rng.permutation(len(mesh.vertices))
        new_number = np.empty(len(order), np.int64)
        new_number[order] = np.arange(len(order))
        faces = new_number[mesh.faces][rng.permutation(len(mesh.faces))]
        return Mesh(mesh.vertices[order], faces, mesh.name)
