"""Gaussian noise on the coordinates of the vertices (section IV of the paper)."""

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.attacks.base import Attack
from wm3d.mesh import Mesh


class GaussianNoise(Attack):
    """Independent Gaussian noise on every coordinate.

    Attributes
    ----------
    percent : float
        Amplitude in percent of the diagonal of the bounding box; 0.6 in the paper.
    amplitude : "rms-vector" or "per-axis"
        Reading of "amplitude": the root mean square length of the noise vector, or the standard deviation of
        each coordinate, √3 times as much.
    """

    name: Literal["gaussian-noise"] = "gaussian-noise"
    legend: ClassVar[tuple[str, ...]] = ("percent", "amplitude")

    percent: Annotated[float, Field(ge=0)] = 0.6
    amplitude: Literal["rms-vector", "per-axis"] = "rms-vector"

    @property
    def sigma_percent(self) -> float:
        """Standard deviation of each coordinate, in percent of the diagonal."""
        return self.percent if self.amplitude == "per-axis" else self.percent / math.sqrt(3)

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the noisy mesh; see `Attack`."""
        vertices = rng.standard_normal(mesh.vertices.shape)
        vertices *= self.sigma_percent / 100 * mesh.diagonal
        vertices += mesh.vertices
        return mesh.with_vertices(vertices)
