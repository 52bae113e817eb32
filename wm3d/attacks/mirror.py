"""The mirror image: left and right exchanged, as for a left shoe made of a right one."""

from typing import ClassVar, Literal

import numpy as np

from wm3d.attacks.base import Attack
from wm3d.mesh import Mesh


class Mirror(Attack):
    """The mirror image across the middle of the bounding box; faces still look outwards.

    Attributes
    ----------
    axis : "x", "y" or "z"
        The axis that is turned round.
    """

    name: Literal["mirror"] = "mirror"
    random: ClassVar[bool] = False

    axis: Literal["x", "y", "z"] = "x"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the mirror image; see `Attack`."""
        vertices = mesh.vertices.copy()
        along = vertices[:, "xyz".index(self.axis)]
        along[:] = along.min() + along.max() - along
        return Mesh(vertices, mesh.faces[:, ::-1], mesh.name)
