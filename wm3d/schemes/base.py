"""What every scheme offers: embed, score, and a strength that can be set from a wanted distortion."""

from abc import ABC, abstractmethod
from typing import ClassVar, Self

from wm3d.arrays import SignArray
from wm3d.component import Component
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import snr
from wm3d.scanner import Cylinder
from wm3d.stats import RademacherSum, Score, key_signs

SNR_TOLERANCE = 1e-6
"""How near `Scheme.at_snr` comes to the wanted SNR, in dB."""

SNR_REACH = 600.0
"""Change of SNR in dB beyond which `Scheme.at_snr` does not look: float64 coordinates span some 300 dB."""


class Scheme(Component, ABC):
    """A mesh watermark with a secret seed of ±1 signs.

    A subclass gives `embed`, `evidence` and `capacity`; a scheme whose parameters depend on the mesh returns
    the parameters that detection needs from `embed`.

    Attributes
    ----------
    strength : str
        The field that scales the distortion; SNR falls as it rises.
    blind : bool
        Whether detection does without the original mesh.
    """

    strength: ClassVar[str]
    blind: ClassVar[bool] = True

    @property
    @abstractmethod
    def capacity(self) -> int:
        """Number n of signs in a key."""

    @abstractmethod
    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        """Return the marked mesh, and the scheme with all that detection needs to know.

        Raises
        ------
        Wm3dError
            If the mesh cannot carry this mark.
        """

    @abstractmethod
    def evidence(self, mesh: Mesh) -> RademacherSum:
        """Read a mesh: the detection statistic as a function of the signs.

        Raises
        ------
        Wm3dError
            If the mesh cannot be posed.
        """

    def cylinder(self, mesh: Mesh) -> Cylinder | None:  # noqa: ARG002 (for schemes that have none)
        """Return the scanning cylinder that this scheme puts around a mesh, None if it uses none."""
        return None

    def signs(self, seed: int) -> SignArray:
        """Return the key signs w of a seed: (n,) of ±1."""
        return key_signs(seed, self.capacity)

    def score(self, mesh: Mesh, seed: int) -> Score:
        """Score one seed on one mesh; the score carries its null, so its p-value is exact for this mesh."""
        return self.evidence(mesh).score(self.signs(seed))

    def at_snr(self, mesh: Mesh, seed: int, decibels: float) -> Self:
        """Return this scheme with its strength set so that `embed` reaches an SNR (eq. 13).

        Raises
        ------
        Wm3dError
            If no strength gives that SNR.
        """
        scheme = self
        for _ in range(40):
            miss = snr(mesh, scheme.embed(mesh, seed)[0]) - decibels
            if abs(miss) <= SNR_TOLERANCE:
                return scheme
            if not abs(miss) < SNR_REACH:  # also NaN, and an SNR of ∞ where no vertex moves
                break
            value = getattr(scheme, self.strength) * 10 ** (miss / 20)  # exact where moves are proportional
            scheme = scheme.model_copy(update={self.strength: value})
        raise Wm3dError(f"{mesh.name}: {self.label()} cannot be set to an SNR of {decibels:g} dB.")
