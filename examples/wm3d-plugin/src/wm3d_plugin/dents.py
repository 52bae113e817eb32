"""An attack: dents pressed into the surface."""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.attacks import Attack
from wm3d.mesh import Mesh, vertex_normals


class Dents(Attack):
    """Round dents around vertices chosen at random.

    Attributes
    ----------
    count : int
        Number of dents.
    percent : float
        Depth of a dent, in % of the bounding-box diagonal; its radius is ten times that.
    """

    name: Literal["dents"] = "dents"
    legend: ClassVar[tuple[str, ...]] = ("count", "percent")
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    count: Annotated[int, Field(ge=0)] = 20
    percent: Annotated[float, Field(ge=0)] = 0.5

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the dented mesh."""
        depth = self.percent / 100 * mesh.diagonal
        if depth == 0:
            return mesh
        centres = mesh.vertices[rng.integers(len(mesh.vertices), size=self.count)]
        pressed = np.zeros(len(mesh.vertices))
        for centre in centres:
            distance = np.linalg.norm(mesh.vertices - centre, axis=1) / (10 * depth)
            pressed = np.maximum(pressed, depth * (1 - np.minimum(distance, 1) ** 2) ** 2)
        return mesh.with_vertices(mesh.vertices - pressed[:, None] * vertex_normals(mesh))
