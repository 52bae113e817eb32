"""Remeshing from a signed distance on a grid, by marching cubes."""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.arrays import FloatArray
from wm3d.attacks import kernels
from wm3d.attacks.base import Attack
from wm3d.attacks.surface import without_unused
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, is_balanced, orientation, sewn

MARGIN = 1.5
"""Cells between the bounding box and the grid's border: all border nodes are outside."""


class MarchingCubes(Attack):
    """The zero level of a signed distance, sampled on a cubic grid (Lorensen & Cline 1987, Lewiner 2003).

    Inside is where the winding number is not 0. The distance is exact at both ends of every grid edge that
    the surface crosses.

    Attributes
    ----------
    cells : int
        The grid has cells of 1/cells of the diagonal of the bounding box.
    """

    version: ClassVar[int] = 2

    name: Literal["marching-cubes"] = "marching-cubes"
    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("cells",)

    cells: Annotated[int, Field(ge=8, le=512)] = 128

    @property
    def engines(self) -> tuple[str, ...]:
        """The package that triangulates the zero level."""
        return ("scikit-image",)

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the new mesh; see `Attack`."""
        from skimage.measure import marching_cubes  # slow to import

        mesh = sewn(mesh).mesh
        if not is_balanced(mesh):
            raise Wm3dError(
                f"{mesh.name}: {self.label()} needs a closed surface, to tell inside from outside; close its "
                "holes, or use screened-poisson."
            )
        cell = mesh.diagonal / self.cells
        origin = mesh.vertices.min(axis=0) - MARGIN * cell
        distance = signed_distance(mesh, origin, cell)
        if not (distance < 0).any():
            raise Wm3dError(f"{mesh.name}: {self.label()} finds no node inside; use more cells.")
        vertices, faces, _, _ = marching_cubes(distance, 0.0, gradient_direction="descent")
        faces = faces.astype(np.int64)
        vertices, faces = without_unused(origin + cell * vertices.astype(np.float64), faces)
        return Mesh(vertices, faces[:, ::-1] if orientation(mesh) < 0 else faces, mesh.name)


def signed_distance(mesh: Mesh, origin: FloatArray, cell: float) -> FloatArray:
    """Return the distance to a closed surface at the nodes of a grid over its bounding box.

    Parameters
    ----------
    mesh : Mesh
    origin : (3,) ndarray
        The first node.
    cell : float
        Spacing of the nodes, in mesh units.

    Returns
    -------
    (l, m, n) ndarray
        In cells, at most 1 from 0; negative inside.
    """
    local = (mesh.vertices - origin) / cell
    x, y, z = (int(count) for count in np.ceil(local.max(axis=0) + MARGIN) + 1)
    distance: FloatArray = np.sqrt(kernels.squared_distance(local, mesh.faces, (x, y, z)))
    exits = kernels.exits(local, mesh.faces, (x, y, z))
    winding = np.cumsum(exits[::-1], axis=0)[::-1]
    return np.where(winding != 0, -distance, distance)
