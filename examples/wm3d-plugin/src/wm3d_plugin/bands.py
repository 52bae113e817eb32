"""A scheme: bands of latitude that move outward or inward."""

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field
from scipy.sparse import coo_array, csr_array

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh import Mesh
from wm3d.scanner import VertexPca
from wm3d.schemes import Scheme
from wm3d.stats import RademacherSum


class LatitudeBands(Scheme):
    """The distance ρ of a vertex from the centre becomes ρ (1 + α w_k), k the band of its latitude.

    The latitude, the sine of the angle to the first principal axis, does not change when ρ does. To see a
    small move on a large surface, both ρ and the bands are compared with their means over neighbouring
    vertices: with H this difference and P the bands of the vertices, Σ b_k w_k = (Hρ)·(HPw).

    Attributes
    ----------
    bands : int
        Number of bands, each a sign.
    alpha : float
        α, as a part of the distance from the centre.
    """

    name: Literal["latitude-bands"] = "latitude-bands"
    strength: ClassVar[str] = "alpha"

    bands: Annotated[int, Field(ge=2)] = 400
    alpha: Annotated[float, Field(gt=0, lt=1)] = 0.002

    @property
    def capacity(self) -> int:
        """One sign a band."""
        return self.bands

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        """Scale the vertices about the centre, band by band; see `Scheme.embed`."""
        centre = VertexPca()(mesh).center
        _, band = self._polar(mesh)
        scale = 1 + self.alpha * self.signs(seed)[band]
        return mesh.with_vertices(centre + scale[:, None] * (mesh.vertices - centre)), self

    def evidence(self, mesh: Mesh) -> RademacherSum:
        """Correlate what stands out of the surface with what each band would; see `Scheme.evidence`."""
        distance, band = self._polar(mesh)
        sharpen = _less_neighbours(mesh)
        outstanding = sharpen.T @ (sharpen @ distance)
        return RademacherSum(0.0, np.bincount(band, outstanding / mesh.diagonal, minlength=self.bands))

    def _polar(self, mesh: Mesh) -> tuple[FloatArray, IntArray]:
        """Return each vertex's distance from the centre and the number of its band."""
        posed = VertexPca()(mesh).posed(mesh)
        distance = np.linalg.norm(posed, axis=1)
        latitude = np.divide(posed[:, 0], distance, out=np.zeros_like(distance), where=distance > 0)
        band = ((latitude + 1) / 2 * self.bands).astype(np.int64)
        return distance, np.minimum(band, self.bands - 1)


def _less_neighbours(mesh: Mesh) -> csr_array:
    """Return H (n, n): a value at each vertex, less its mean over the vertices that share an edge."""
    n, faces = len(mesh.vertices), mesh.faces
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    rows, columns = np.concatenate([start, end]), np.concatenate([end, start])
    beside = coo_array((np.ones(rows.size), (rows, columns)), shape=(n, n)).tocsr()
    total = np.maximum(beside.sum(axis=1), 1)
    own = np.arange(n)
    unit = coo_array((np.ones(n), (own, own)), shape=(n, n)).tocsr()
    return unit - beside.multiply(1 / total[:, None]).tocsr()
