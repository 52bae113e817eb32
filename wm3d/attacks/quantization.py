"""Coordinates on a grid: quantization to bits (LIRIS benchmark, Draco, glTF) and rounding to float32."""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.attacks.base import Attack
from wm3d.mesh import Mesh


class Quantize(Attack):
    """Coordinates rounded to R bits over the bounding box; the faces stay.

    Attributes
    ----------
    bits : int
        R; 11 to 7 in the LIRIS benchmark, 14 and 11 in Draco.
    grid : "per-axis" or "cubic"
        "per-axis": steps of the extent of each axis / 2^R, as in the LIRIS benchmark (Wang et al., SMI 2010);
        the highest coordinate is the level 2^R. "cubic": one step on all axes, the largest extent
        / (2^R − 1), as in Draco.
    """

    name: Literal["quantize"] = "quantize"
    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("bits", "grid")

    bits: Annotated[int, Field(ge=1, le=30)] = 11
    grid: Literal["per-axis", "cubic"] = "per-axis"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the mesh of rounded coordinates; see `Attack`."""
        low, extent = mesh.vertices.min(axis=0), np.ptp(mesh.vertices, axis=0)
        step = extent / 2**self.bits if self.grid == "per-axis" else extent.max() / (2**self.bits - 1)
        step = np.where(step > 0, step, 1.0)  # a flat axis has one level
        return mesh.with_vertices(low + step * np.round((mesh.vertices - low) / step))


class Float32(Attack):
    """Coordinates rounded to float32, as nearly every file and graphics card holds them."""

    name: Literal["float32"] = "float32"
    random: ClassVar[bool] = False

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the mesh of rounded coordinates; see `Attack`."""
        with np.errstate(over="ignore"):  # beyond float32: the check of `Mesh` says so
            return mesh.with_vertices(mesh.vertices.astype(np.float32))
