"""Random similarity transforms: rotation, translation, uniform scale."""

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from scipy.spatial.transform import Rotation

from wm3d.attacks.base import Attack
from wm3d.attacks.surface import mean_radius
from wm3d.mesh import Mesh


class Similarity(Attack):
    """A random rotation, then a scale, then a translation.

    The default ranges are those of the LIRIS benchmark (Wang et al., SMI 2010).

    Attributes
    ----------
    min_scale, max_scale : float
        The scale is uniform between them.
    translation : float
        Each component of the translation is uniform in ± this many r̄, the mean distance of the vertices from
        their mean.
    """

    name: Literal["similarity"] = "similarity"
    turns: ClassVar[bool] = True

    min_scale: Annotated[float, Field(gt=0)] = 0.1
    max_scale: Annotated[float, Field(gt=0)] = 10.0
    translation: Annotated[float, Field(ge=0)] = 5.0

    @model_validator(mode="after")
    def _scales_in_order(self) -> Self:
        if self.min_scale > self.max_scale:
            raise ValueError(f"min_scale = {self.min_scale:g} is above max_scale = {self.max_scale:g}")
        return self

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the transformed mesh; see `Attack`."""
        rotation = Rotation.random(rng=rng).as_matrix()
        scale = rng.uniform(self.min_scale, self.max_scale)
        shift = rng.uniform(-1, 1, 3) * self.translation * mean_radius(mesh)
        turned = np.einsum(
            "ij,nj->ni", rotation, mesh.vertices
        )  # not BLAS: the same bits on any thread count
        return mesh.with_vertices(scale * turned + shift)
