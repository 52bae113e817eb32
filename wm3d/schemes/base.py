"""What every scheme offers: embed, score, and a strength that can be set from a wanted distortion."""

import math
from abc import ABC, abstractmethod
from typing import ClassVar, Self

from scipy.optimize import brentq

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

SNR_BRACKETED = 1e-3
"""How near it comes where moves are far from proportional to the strength, in dB."""

SNR_JUMP = 0.05
"""What it accepts where the distortion jumps with the strength, in dB."""

_STEPS = 40
_XTOL = 1e-6  # of ln strength: a narrower bracket holds a jump
_NEPERS = math.log(10) / 20  # ln strength a decibel, where moves are proportional to the strength


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
    message : bool
        Whether the signs are the bits of a message, each decided on its own, so that a bit error rate has a
        meaning; otherwise they are one mark, found or not.
    """

    strength: ClassVar[str]
    blind: ClassVar[bool] = True
    message: ClassVar[bool] = False

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

    def with_original(self, original: Mesh) -> Self:  # noqa: ARG002 (a blind scheme does not need it)
        """Return the scheme with the original at hand, which schemes that are not `blind` read against.

        Raises
        ------
        Wm3dError
            If the mark was embedded into another mesh.
        """
        return self

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
        limit, value = math.log(self._strength_limit()), math.log(getattr(self, self.strength))
        bracket: dict[bool, float] = {}  # ln strength by whether it is too weak
        last = math.inf
        for _ in range(_STEPS):
            miss = self._miss(mesh, seed, decibels, value)
            if abs(miss) <= SNR_TOLERANCE:
                return self._of_strength(value)
            if not abs(miss) < SNR_REACH:  # also NaN, and an SNR of ∞ where no vertex moves
                break
            bracket[miss > 0] = value
            if len(bracket) == 2 and abs(miss) > abs(last) / 2:
                value = self._bracketed(mesh, seed, decibels, bracket)
                if abs(self._miss(mesh, seed, decibels, value)) <= SNR_JUMP:
                    return self._of_strength(value)
                break
            proposed = value + miss * _NEPERS  # exact where moves are proportional
            value, last = proposed if proposed < limit else (value + limit) / 2, miss
        raise Wm3dError(f"{mesh.name}: {self.label()} cannot be set to an SNR of {decibels:g} dB.")

    def _bracketed(self, mesh: Mesh, seed: int, decibels: float, bracket: dict[bool, float]) -> float:
        def miss(log_strength: float) -> float:
            value = self._miss(mesh, seed, decibels, log_strength)
            return value if abs(value) > SNR_BRACKETED else 0.0  # near enough to stop

        return float(brentq(miss, bracket[True], bracket[False], xtol=_XTOL))

    def _of_strength(self, log_strength: float) -> Self:
        return self.model_copy(update={self.strength: math.exp(log_strength)})

    def _miss(self, mesh: Mesh, seed: int, decibels: float, log_strength: float) -> float:
        return snr(mesh, self._of_strength(log_strength).embed(mesh, seed)[0]) - decibels

    def _strength_limit(self) -> float:
        """Return the bound that the field of the strength declares, ∞ if none."""
        metadata = type(self).model_fields[self.strength].metadata
        return min((m.lt for m in metadata if hasattr(m, "lt")), default=math.inf)
