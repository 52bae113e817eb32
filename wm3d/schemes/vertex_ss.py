"""Additive spread spectrum on the vertex norms, sign after sign in file order: the floor of the field."""

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from wm3d.arrays import FloatArray
from wm3d.attacks.surface import neighbour_mean
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, vertex_moments
from wm3d.schemes.base import Scheme
from wm3d.stats import RademacherSum


class VertexSs(Scheme):
    """One sign for each vertex in file order, added to its distance from the vertex mean.

    ρ_i' = ρ_i + α ρ̄ w_k with k = i mod n: vertex i of the file carries sign i mod n, so nothing but the
    order of the vertices synchronises the detector. A file that is reordered or simplified has lost the mark,
    and after a cut what follows the first vertex that is gone: that is what makes it the floor.

    Attributes
    ----------
    signs_used : int
        n, the signs of the key, each of which every n-th vertex carries.
    alpha : float
        α, in shares of the mean distance ρ̄.
    """

    name: Literal["vertex-ss"] = "vertex-ss"
    strength: ClassVar[str] = "alpha"

    signs_used: Annotated[int, Field(ge=1, le=1 << 20)] = 1024
    alpha: Annotated[float, Field(gt=0)] = 1e-3

    @property
    def capacity(self) -> int:
        """The signs in use."""
        return self.signs_used

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        """Move every vertex along its ray from the mean; see `Scheme.embed`."""
        if len(mesh.vertices) < self.capacity:
            raise Wm3dError(
                f"{mesh.name}: has {len(mesh.vertices)} vertices, too few for {self.capacity} signs; use "
                "fewer (signs_used)."
            )
        arms, norms = _norms(mesh)
        change = self.alpha * norms.mean() * self.signs(seed)[np.arange(len(norms)) % self.capacity]
        rays = arms / np.where(norms > 0, norms, 1.0)[:, None]
        return mesh.with_vertices(mesh.vertices + change[:, None] * rays), self

    def evidence(self, mesh: Mesh) -> RademacherSum:
        """Correlate the signs with the norms less the mean norm of the neighbours; see `Scheme.evidence`.

        b_k = Σ_{i mod n = k} (ρ_i − mean of ρ over the neighbours of i) / ρ̄.
        """
        _, norms = _norms(mesh)
        residual = (norms - neighbour_mean(mesh) @ norms) / norms.mean()
        sums = np.bincount(np.arange(len(norms)) % self.capacity, residual, self.capacity)
        return RademacherSum(0.0, sums.astype(np.float64))


def _norms(mesh: Mesh) -> tuple[FloatArray, FloatArray]:
    """Return the vertices relative to their mean, (n, 3), and their distances from it, (n,)."""
    arms = mesh.vertices - vertex_moments(mesh).mean
    return arms, np.linalg.norm(arms, axis=1)
