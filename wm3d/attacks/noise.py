"""Noise on the coordinates: Gaussian (section IV of the paper) and uniform (LIRIS benchmark)."""

import math
from abc import abstractmethod
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.arrays import FloatArray
from wm3d.attacks import kernels
from wm3d.attacks.base import Attack
from wm3d.attacks.surface import mean_radius
from wm3d.mesh import Mesh, sewn


class Noise(Attack):
    """Independent noise of mean 0 on every coordinate; what all kinds of it share.

    Vertices in one place move together, so noise tears no seam.
    """

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the noisy mesh; see `Attack`."""
        surface, place = sewn(mesh)
        noisy = self._noisy(surface, rng)
        if surface is not mesh:
            noisy = noisy[place]
        noisy.flags.writeable = False  # the mesh keeps it, uncopied
        return mesh.with_vertices(noisy)

    @abstractmethod
    def _noisy(self, mesh: Mesh, rng: np.random.Generator) -> FloatArray:
        """Return where the vertices go, in an array of its own."""

    @abstractmethod
    def sigma_percent(self, mesh: Mesh) -> float:
        """Return the standard deviation of each coordinate, in percent of the bounding box's diagonal.

        The one unit in which every noise can be compared.
        """


class GaussianNoise(Noise):
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
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(ge=0)] = 0.6
    amplitude: Literal["rms-vector", "per-axis"] = "rms-vector"

    def sigma_percent(self, mesh: Mesh) -> float:  # noqa: ARG002 (the same for every mesh)
        """Return the standard deviation of each coordinate, in percent of the diagonal."""
        return self.percent if self.amplitude == "per-axis" else self.percent / math.sqrt(3)

    def _noisy(self, mesh: Mesh, rng: np.random.Generator) -> FloatArray:
        noisy: FloatArray = kernels.with_noise(
            mesh.vertices, self.sigma_percent(mesh) / 100 * mesh.diagonal, rng
        )
        return noisy


class UniformNoise(Noise):
    """Each coordinate moved uniformly in ±A, as in the LIRIS benchmark (Wang et al., SMI 2010).

    Attributes
    ----------
    percent : float
        A in percent of r̄, the mean distance of the vertices from their mean; 0.05 to 0.5 in the benchmark.
    """

    name: Literal["uniform-noise"] = "uniform-noise"
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(ge=0)] = 0.5

    def sigma_percent(self, mesh: Mesh) -> float:
        """Return the standard deviation of each coordinate, A/√3, in percent of the diagonal."""
        return self.percent * mean_radius(mesh) / mesh.diagonal / math.sqrt(3)

    def _noisy(self, mesh: Mesh, rng: np.random.Generator) -> FloatArray:
        vertices = rng.uniform(-1, 1, mesh.vertices.shape)
        vertices *= self.percent / 100 * mean_radius(mesh)
        vertices += mesh.vertices
        return vertices
