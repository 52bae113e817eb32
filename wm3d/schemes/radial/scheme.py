"""The base of the radial schemes: one bit in a moment of each bin of the distances from a centre."""

from abc import abstractmethod
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Field

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.schemes.base import Scheme
from wm3d.schemes.radial.histogram import Moment, Spread, exponents
from wm3d.stats import RademacherSum

Bits = Annotated[int, Field(ge=1, le=4096)]


class RadialScheme(Scheme):
    """One bit in a moment of each of N bins of distances from a centre; what all such schemes share.

    A bin that is empty, or whose few points no power map brings to the target, is left as it is: its bit is
    not carried, and its weight in the statistic is small.

    Attributes
    ----------
    bits : int
        N, the number of bins and of bits.
    """

    strength: ClassVar[str] = "alpha"
    message: ClassVar[bool] = True
    legend: ClassVar[tuple[str, ...]] = ("bits",)
    moment: ClassVar[Moment]

    bits: Bits = 64
    alpha: float

    @property
    def capacity(self) -> int:
        """One sign for each bin."""
        return self.bits

    @abstractmethod
    def spread(self, mesh: Mesh) -> Spread:
        """Return the distances of a mesh.

        Raises
        ------
        Wm3dError
            If all are equal.
        """

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        """Map the distances in each bin so that its moment is the neutral one ± α; see `Scheme.embed`."""
        spread = self.spread(mesh)
        return _moved(mesh, spread, self.moment, self._exponents(mesh, spread, seed)), self

    def _exponents(self, mesh: Mesh, spread: Spread, seed: int) -> FloatArray:
        signs = self.signs(seed)
        target: FloatArray = self.moment.neutral + self.alpha * signs.astype(np.float64)
        k = exponents(spread, self.moment, signs, target)
        carried = ~np.isnan(k)
        if carried.sum() < self.bits / 2:
            missing = int(np.flatnonzero(~carried)[0])
            raise Wm3dError(
                f"{mesh.name}: {self.label()} finds too little in {self.bits - carried.sum()} of {self.bits} "
                f"bins, the first of them bin {missing}; use fewer bits."
            )
        return np.where(carried, k, 1.0)

    def evidence(self, mesh: Mesh) -> RademacherSum:
        """Weigh what each bin is off the neutral moment by the root of its weight; see `Scheme.evidence`.

        b_n = √c_n (m_n − neutral) / deviation, of variance 1 where t is uniform in the bin. The sign of b_n
        is the bit as the paper reads it.
        """
        spread = self.spread(mesh)
        off = (spread.moments(self.moment) - self.moment.neutral) / self.moment.deviation
        return RademacherSum(0.0, np.sqrt(spread.counts) * off)


def _moved(mesh: Mesh, spread: Spread, moment: Moment, k: FloatArray) -> Mesh:
    """Move every vertex along its ray from the centre by the power map of its bin."""
    arms = mesh.vertices - spread.center
    radii = np.linalg.norm(arms, axis=1)
    index, t = spread.place(radii)
    inside = (index >= 0) & (radii > 0)
    index, t = index[inside], t[inside]
    change = spread.distance(index, moment.mapped(t, k[index])) - spread.distance(index, t)
    vertices = mesh.vertices.copy()
    vertices[inside] += arms[inside] * (change / radii[inside])[:, None]
    return mesh.with_vertices(vertices)
