"""Smoothing: Laplacian (LIRIS benchmark) and Taubin's, which does not shrink."""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.attacks.base import Attack
from wm3d.attacks.surface import neighbour_mean
from wm3d.mesh import Mesh, sewn

LIRIS_WEIGHT = 0.1
"""λ of the steps of the LIRIS benchmark."""


class LaplacianSmoothing(Attack):
    """Steps of every vertex towards the mean of its neighbours, all at once.

    v ← v + λ (mean of the neighbours of v − v), as in the LIRIS benchmark (Wang et al., SMI 2010).

    Attributes
    ----------
    iterations : int
        5, 10, 30 and 50 in the benchmark.
    weight : float
        λ; 0.1 in the benchmark.
    """

    name: Literal["laplacian-smoothing"] = "laplacian-smoothing"
    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("iterations",)
    neutral: ClassVar[dict[str, float]] = {"iterations": 0}

    iterations: Annotated[int, Field(ge=0)] = 50
    weight: Annotated[float, Field(ge=0, le=1)] = LIRIS_WEIGHT

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the smoothed mesh; see `Attack`."""
        return smoothed(mesh, (self.weight,) * self.iterations)


class TaubinSmoothing(Attack):
    """Laplacian steps of λ, each followed by one of μ < −λ that blows the mesh up again (Taubin 1995).

    Attributes
    ----------
    iterations : int
        Pairs of steps. The defaults of all three are those of MeshLab.
    weight, inflation : float
        λ and −μ.
    """

    name: Literal["taubin-smoothing"] = "taubin-smoothing"
    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("iterations",)
    neutral: ClassVar[dict[str, float]] = {"iterations": 0}

    iterations: Annotated[int, Field(ge=0)] = 10
    weight: Annotated[float, Field(ge=0, le=1)] = 0.5
    inflation: Annotated[float, Field(ge=0, le=1)] = 0.53

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the smoothed mesh; see `Attack`."""
        return smoothed(mesh, (self.weight, -self.inflation) * self.iterations)


def smoothed(mesh: Mesh, weights: tuple[float, ...]) -> Mesh:
    """Return the mesh after one Laplacian step for each weight; vertices in one place count as one."""
    surface, place = sewn(mesh)
    mean, vertices = neighbour_mean(surface), surface.vertices
    for weight in weights:
        vertices = vertices + weight * (mean @ vertices - vertices)
    return mesh.with_vertices(vertices[place])
