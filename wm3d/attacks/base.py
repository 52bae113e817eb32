"""What every attack is: a frozen value that turns a mesh and a random generator into a mesh."""

from abc import ABC, abstractmethod
from typing import Literal

import numpy as np

from wm3d.component import Component
from wm3d.mesh import Mesh


class Attack(Component, ABC):
    """A distortion of a mesh.

    Calling it draws all randomness from the generator that is passed in; the same generator state gives the
    same mesh. The input is never changed.
    """

    @abstractmethod
    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the attacked mesh.

        Raises
        ------
        Wm3dError
            If the mesh cannot be attacked this way.
        """


class Clean(Attack):
    """No attack: the mesh as it is."""

    name: Literal["clean"] = "clean"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (one signature)
        """Return the mesh itself."""
        return mesh
