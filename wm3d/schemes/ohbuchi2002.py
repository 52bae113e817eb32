"""Ohbuchi, Mukaiyama, Takahashi, "A Frequency-Domain Approach to Watermarking 3D Shapes".

Computer Graphics Forum 21(3), 2002, after Ohbuchi, Takahashi, Miyazawa, Mukaiyama, Graphics Interface 2001.
The detector needs the original mesh.
"""

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.schemes.base import Scheme
from wm3d.schemes.spectral import lowest_modes, resampled
from wm3d.stats import RademacherSum


class Ohbuchi2002(Scheme):
    """Spread spectrum in the lowest modes of the mesh Laplacian K = D − A; needs the original.

    Each sign is added to one coordinate of one spectral coefficient, R' = R + α p. For detection the suspect
    is registered onto the original and resampled at its vertices; R' − R is correlated with p. The papers
    spread a message over the coefficients; here p is the key itself: one mark, as strong as it can be. Modes
    of eigenvalue 0, the positions of the components, carry nothing. Where eigenvalues are equal, as on a mesh
    of symmetric connectivity, the modes are those that the solver finds first.

    Attributes
    ----------
    modes : int
        Lowest modes in use; each carries three signs.
    alpha : float
        Root mean square move of a coordinate, in percent of the diagonal of the bounding box; the papers' α
        is this times √(vertices / modes).
    original : str
        sha256 of the mesh that was marked, set by embedding; detection refuses another.
    """

    name: Literal["ohbuchi2002"] = "ohbuchi2002"
    strength: ClassVar[str] = "alpha"
    blind: ClassVar[bool] = False

    modes: Annotated[int, Field(ge=1, le=1000)] = 100
    alpha: Annotated[float, Field(gt=0)] = 0.05
    original: Annotated[str, Field(pattern=r"^([0-9a-f]{64})?$", repr=False)] = ""

    _mesh: Mesh | None = PrivateAttr(default=None)

    def __eq__(self, other: Any) -> bool:
        """Compare the parameters; whether the original is at hand does not count."""
        return isinstance(other, Ohbuchi2002) and self.model_dump() == other.model_dump()

    @property
    def capacity(self) -> int:
        """Three signs a mode."""
        return 3 * self.modes

    @property
    def engines(self) -> tuple[str, ...]:
        """The packages that find the modes and register."""
        return ("scipy", "trimesh")

    def label(self) -> str:
        """Return the legend text, without the hash of the original."""
        named: str = super(Ohbuchi2002, self.model_copy(update={"original": ""})).label()
        return named

    def with_original(self, original: Mesh) -> Self:
        """Return the scheme with the original at hand; see `Scheme.with_original`."""
        digest = original.digest()
        if self.original not in ("", digest):
            raise Wm3dError(
                f"{original.name}: is not the mesh that was marked (sha256 {digest[:12]}…, the key says "
                f"{self.original[:12]}…)."
            )
        scheme = self.model_copy(update={"original": digest})
        scheme._mesh = original
        return scheme

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        """Add the signs to the spectrum; see `Scheme.embed`."""
        signs = self.signs(seed).reshape(-1, 3)
        moves = self._amplitude(mesh) * (lowest_modes(mesh, self.modes) @ signs)
        fresh = self.model_copy(update={"original": ""})
        return mesh.with_vertices(mesh.vertices + moves), fresh.with_original(mesh)

    def evidence(self, mesh: Mesh) -> RademacherSum:
        """Register, resample and transform: b_k is R' − R in units of α; see `Scheme.evidence`."""
        if self._mesh is None:
            raise Wm3dError(
                f"{mesh.name}: ohbuchi2002 is not blind and needs the original mesh (--original FILE, or "
                "original= in Python)."
            )
        difference = resampled(self._mesh, mesh) - self._mesh.vertices
        spectrum = lowest_modes(self._mesh, self.modes).T @ difference
        return RademacherSum(0.0, (spectrum / self._amplitude(self._mesh)).ravel())

    def _amplitude(self, mesh: Mesh) -> float:
        used = int(mesh.used.sum())
        return float(self.alpha / 100 * mesh.diagonal * np.sqrt(used / self.modes))
