"""Smooth deformations of the whole model: stretch, shear, bend, twist (Barr, SIGGRAPH 1984).

All act about the centre of the bounding box, which stays where it is.
"""

from abc import abstractmethod
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.arrays import FloatArray
from wm3d.attacks.base import Attack
from wm3d.mesh import Mesh

Axis = Literal["x", "y", "z"]
Coordinates = tuple[FloatArray, FloatArray, FloatArray]


class Deformation(Attack):
    """A map of space along one coordinate axis; what all kinds of it share.

    Attributes
    ----------
    axis : "x", "y" or "z"
        The axis that is stretched, sheared along, bent or twisted about.
    """

    random: ClassVar[bool] = False

    axis: Axis = "z"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the deformed mesh; see `Attack`."""
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        k = "xyz".index(self.axis)
        order = [(k + 1) % 3, (k + 2) % 3, k]  # right-handed, the axis last
        center = 0.5 * (low + high)
        local = mesh.vertices[:, order] - center[order]
        vertices = mesh.vertices.copy()
        vertices[:, order] += np.column_stack(self._moved(*local.T)) - local
        return mesh.with_vertices(vertices)

    @abstractmethod
    def _moved(self, u: FloatArray, v: FloatArray, w: FloatArray) -> Coordinates:
        """Map the coordinates u, v across and w along the axis of all vertices, (n,) each."""


class Stretch(Deformation):
    """Non-uniform scale: one axis made longer, or shorter by a negative share.

    Attributes
    ----------
    percent : float
        By how much the extent along the axis grows.
    """

    name: Literal["stretch"] = "stretch"
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(gt=-100)] = 10.0

    def _moved(self, u: FloatArray, v: FloatArray, w: FloatArray) -> Coordinates:
        return u, v, w + self.percent / 100 * w


class Shear(Deformation):
    """Layers across the axis slid along the next axis (x after z), in proportion to their height.

    Attributes
    ----------
    percent : float
        Slide in percent of the height.
    """

    name: Literal["shear"] = "shear"
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: float = 10.0

    def _moved(self, u: FloatArray, v: FloatArray, w: FloatArray) -> Coordinates:
        return u + self.percent / 100 * w, v, w


class _EndsTurned(Deformation):
    """A deformation that turns the two ends of the model against each other.

    Attributes
    ----------
    degrees : float
        Angle between the two ends.
    """

    legend: ClassVar[tuple[str, ...]] = ("degrees",)
    neutral: ClassVar[dict[str, float]] = {"degrees": 0}

    degrees: float = 10.0


class Twist(_EndsTurned):
    """Layers across the axis turned about it, in proportion to their height."""

    name: Literal["twist"] = "twist"

    def _moved(self, u: FloatArray, v: FloatArray, w: FloatArray) -> Coordinates:
        angle = np.radians(self.degrees) * w / (np.ptp(w) or 1.0)  # a sheet across the axis stays
        cosine, sine = np.cos(angle), np.sin(angle)
        return cosine * u - sine * v, sine * u + cosine * v, w


class Bend(_EndsTurned):
    """The axis bent into a circular arc of its length, towards the next axis (x after z)."""

    name: Literal["bend"] = "bend"

    degrees: Annotated[float, Field(ge=-180, le=180)] = 10.0

    def _moved(self, u: FloatArray, v: FloatArray, w: FloatArray) -> Coordinates:
        extent = float(np.ptp(w))
        if self.degrees == 0 or extent == 0:
            return u, v, w
        curvature = np.radians(self.degrees) / extent
        angle = curvature * w
        # 1/k − (1/k − u) cos φ, written so that nothing cancels for small k
        across = u * np.cos(angle) + 2 * np.sin(angle / 2) ** 2 / curvature
        return across, v, np.sin(angle) / curvature - u * np.sin(angle)
