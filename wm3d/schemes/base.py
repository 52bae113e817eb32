"""What every scheme offers: embed, score, and a strength that can be set from a wanted distortion."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Self

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from scipy.optimize import brentq

from wm3d.arrays import SignArray
from wm3d.component import Component
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import Budget
from wm3d.scanner import Cylinder
from wm3d.stats import RademacherSum, Score, key_signs

TOLERANCE = 1e-6
"""How near `Scheme.at_distortion` comes to a budget unless told otherwise, in dB (`Budget.headroom`)."""

REACH = 600.0
"""Change in dB beyond which it does not look: float64 coordinates span some 300 dB."""

BRACKETED = 1e-3
"""How near it comes where moves are far from proportional to the strength, in dB."""

JUMP = 0.05
"""What it accepts where the distortion jumps with the strength, or the strength has a bound, in dB."""

_STEPS = 40
_XTOL = 1e-6  # of ln strength: a narrower bracket holds a jump
_LEAST_GAIN = 0.01  # dB a dB of strength, below which more of it does nothing
_SLOWEST = 0.2  # dB a dB of strength that a step reckons with: MSDM2 grows by about half
_STEEPEST = 300.0  # dB a dB of strength, which no scheme gains
_STEEPER = 1.5  # times the last gain, or times 1: more is not hoped for where much is missing
_MUCH = 1.0  # dB that are much
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
        try:
            budget = Budget(metric="snr", value=decibels)
        except ValidationError as error:
            raise Wm3dError(f"{mesh.name}: {_words(error.errors()[0])}.") from None
        return self.at_distortion(mesh, seed, budget)

    def at_distortion(self, mesh: Mesh, seed: int, budget: Budget, tolerance: float = TOLERANCE) -> Self:
        """Return this scheme with its strength set so that `embed` distorts the mesh as a budget allows.

        Parameters
        ----------
        mesh : Mesh
        seed : int
        budget : Budget
        tolerance : float
            How near to come, in dB of `Budget.headroom`.

        Raises
        ------
        Wm3dError
            If no strength gives that distortion.
        """

        def headroom(log_strength: float) -> float:
            marked, _ = self._of_log_strength(log_strength).embed(mesh, seed)
            rooms[log_strength] = budget.headroom(budget.measured(mesh, marked))
            return rooms[log_strength]

        rooms: dict[float, float] = {}
        limit, value = math.log(self._strength_limit()), math.log(getattr(self, self.strength))
        bracket: dict[bool, float] = {}  # ln strength by whether it is too weak
        last = None  # ln strength
        for _ in range(_STEPS):
            room = headroom(value)
            if abs(room) <= tolerance:
                return self._of_log_strength(value)
            if not abs(room) < REACH:  # also NaN, and an SNR of ∞ where no vertex moves
                break
            bracket[room > 0] = value
            gain = 1.0  # dB that a dB of strength wins; 1 where moves are proportional to it
            if last is not None:
                gain = (rooms[last] - room) * _NEPERS / (value - last)
                if len(bracket) == 1 and (gain < _LEAST_GAIN or abs(value - last) < _XTOL):
                    break  # where more of it does nothing, or at a bound of the strength
                if len(bracket) == 2 and abs(room) > abs(rooms[last]) / 2:
                    _bracketed(headroom, bracket, max(tolerance, BRACKETED))
                    break
            proposed = value + room * _NEPERS / min(max(gain, _SLOWEST), 1.0)
            far = last is not None and len(bracket) == 1 and room > _MUCH
            hoped = _STEEPER * max(gain, 1.0) if far else _STEEPEST
            if room * _NEPERS > hoped * (limit - value):
                break  # out of reach
            value, last = proposed if proposed < limit else (value + limit) / 2, value
        nearest = min(rooms, key=lambda tried: abs(rooms[tried]))
        room = rooms[nearest]
        if abs(room) <= max(tolerance, JUMP):
            return self._of_log_strength(nearest)
        way = f"; the nearest is {abs(room):.3g} dB too {'weak' if room > 0 else 'strong'}"
        raise Wm3dError(
            f"{mesh.name}: {self.label()} cannot be set to {budget.in_words()}"
            f"{way if abs(room) < REACH else ''}."
        )

    def _of_log_strength(self, log_strength: float) -> Self:
        return self.model_copy(update={self.strength: math.exp(log_strength)})

    @classmethod
    def strength_field(cls) -> FieldInfo:
        """Return the field that `strength` names.

        Raises
        ------
        Wm3dError
            If it names none.
        """
        named = getattr(cls, "strength", None)
        if named not in cls.model_fields:
            raise Wm3dError(
                f"{cls.__name__}: `strength` is {named!r}, which is none of its parameters, so no distortion "
                "can be asked for; name the parameter that scales it."
            )
        return cls.model_fields[named]

    def _strength_limit(self) -> float:
        """Return the bound that the field of the strength declares, ∞ if none."""
        bounds = (getattr(m, end, None) for m in self.strength_field().metadata for end in ("lt", "le"))
        return min((float(bound) for bound in bounds if bound is not None), default=math.inf)


def _words(fault: Mapping[str, Any]) -> str:
    """Return what a validation found, in the words of the model where it has any."""
    return str(fault.get("ctx", {}).get("error", fault["msg"]))


def _bracketed(headroom: Callable[[float], float], bracket: Mapping[bool, float], tolerance: float) -> None:
    """Try strengths in a bracket until the headroom is as good as 0, or the bracket as narrow as can be."""

    def room(log_strength: float) -> float:
        value = headroom(log_strength)
        return value if abs(value) > tolerance else 0.0  # near enough to stop

    brentq(room, bracket[True], bracket[False], xtol=_XTOL)
