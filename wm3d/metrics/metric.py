"""What a metric is: a function of two meshes with a unit and what it needs."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from wm3d.mesh import Mesh

Unit = Literal["", "db", "deg", "percent", "mesh_units"]


@dataclass(frozen=True)
class Metric:
    """A distortion between an original mesh and another.

    Attributes
    ----------
    function : callable
        Takes the original and the other mesh; raises `Wm3dError` where it is not defined.
    unit : str
        "db", "deg" (of angle), "percent", "mesh_units", or "" for a number without one.
    same_vertices : bool
        Whether it compares vertex by vertex, so that both meshes must have the same vertices in one order.
    """

    function: Callable[[Mesh, Mesh], float]
    unit: Unit = ""
    same_vertices: bool = False

    def __call__(self, original: Mesh, other: Mesh) -> float:
        """Return the metric of two meshes."""
        return self.function(original, other)
