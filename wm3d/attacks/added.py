"""Parts added: a base glued on, as models get for printing and for display, or another object beside."""

from abc import abstractmethod
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.arrays import FloatArray, IntArray
from wm3d.attacks.base import Attack
from wm3d.attacks.deformation import Axis
from wm3d.mesh import Mesh, orientation

MARGIN = 0.05
"""How far the base stands out on each side, and how deep the model sinks into it, in shares of its height or
of the model's extent."""

_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
_QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


class Added(Attack):
    """A part of its own in the same mesh, wound as the model is; what all kinds of it share."""

    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(ge=0)]
    axis: Axis

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the model and the part; see `Attack`."""
        if self.percent == 0:
            return mesh
        vertices, faces = self._part(mesh)
        faces = len(mesh.vertices) + faces[:, :: orientation(mesh)]
        return Mesh(np.vstack([mesh.vertices, vertices]), np.vstack([mesh.faces, faces]), mesh.name)

    @abstractmethod
    def _part(self, mesh: Mesh) -> tuple[FloatArray, IntArray]:
        """Return vertices (k, 3) and faces (j, 3), wound outwards, of what is added to a mesh."""


class Pedestal(Added):
    """A box under the whole model, which sinks into it a little.

    Attributes
    ----------
    percent : float
        Height of the box in percent of the extent of the model along the axis.
    axis : "x", "y" or "z"
        The way up.
    """

    name: Literal["pedestal"] = "pedestal"
    percent: Annotated[float, Field(ge=0)] = 10.0
    axis: Axis = "z"

    def _part(self, mesh: Mesh) -> tuple[FloatArray, IntArray]:
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        extent, up = high - low, "xyz".index(self.axis)
        height = self.percent / 100 * extent[up]
        least, greatest = low - MARGIN * extent, high + MARGIN * extent
        greatest[up] = low[up] + MARGIN * height
        least[up] = greatest[up] - height
        faces = np.vstack([_QUADS[:, [0, 1, 2]], _QUADS[:, [0, 2, 3]]])
        return least + _CORNERS * (greatest - least), faces


class Companion(Added):
    """A ball of 20,480 faces beside the model, as another object of a scene.

    Attributes
    ----------
    percent : float
        Diameter of the ball in percent of the diagonal of the bounding box.
    axis : "x", "y" or "z"
        Along which it lies behind the model, a twentieth of the diagonal away.
    """

    name: Literal["companion"] = "companion"
    percent: Annotated[float, Field(ge=0)] = 50.0
    axis: Axis = "x"

    def _part(self, mesh: Mesh) -> tuple[FloatArray, IntArray]:
        from trimesh.creation import icosphere

        ball, radius = icosphere(subdivisions=5), self.percent / 200 * mesh.diagonal
        low, high = mesh.vertices[mesh.used].min(axis=0), mesh.vertices[mesh.used].max(axis=0)
        middle, along = (low + high) / 2, "xyz".index(self.axis)
        middle[along] = high[along] + MARGIN * mesh.diagonal + radius
        return middle + radius * np.asarray(ball.vertices), np.asarray(ball.faces)
