"""The plan of an experiment: cells, which are data, named by a digest of all that their numbers depend on."""

import hashlib
import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Literal

from wm3d.attacks import Attack, Clean
from wm3d.bench.config import Experiment
from wm3d.mesh import Mesh
from wm3d.metrics import Budget
from wm3d.schemes import Scheme

ROWS_VERSION = 3
"""Raised when the columns of a row or the way a trial is made change."""

CALIBRATION_DB = 0.2
"""How near the distortion comes to a budget: where it jumps with the strength it gets no nearer, and between
the keys of such schemes it varies by as much and more."""

Hypothesis = Literal["H1", "H0-unmarked", "H0-other-mesh"]


@dataclass(frozen=True)
class Cell:
    """What one file holds: numbers of one scheme and one attack on one mesh.

    Attributes
    ----------
    start, stop : int
        Trials start ≤ t < stop; a trial's key and noise follow from its number.
    budget : Budget, optional
        The distortion to which the strength of the scheme was set.
    """

    kind: ClassVar[str]

    seed: int
    mesh: str
    mesh_digest: str
    scheme: Scheme
    attack: Attack
    start: int
    stop: int
    budget: Budget | None = field(default=None, kw_only=True)

    @cached_property
    def digest(self) -> str:
        """Name of the cell: 20 hex digits of the sha256 of its identity."""
        canonical = json.dumps(self.identity(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()[:20]

    @property
    def label(self) -> str:
        """Legend text of the scheme; a budget stands in place of the strength that meets it."""
        if self.budget is None:
            return self.scheme.label()
        return f"{uncalibrated(self.scheme).label()} at {self.budget.label()}"

    @property
    def trials(self) -> int:
        """Number of attacked meshes."""
        return self.stop - self.start

    @property
    def subject(self) -> tuple[str, str]:
        """Name and digest of the mesh that is attacked, with the mark or without."""
        return self.mesh, self.mesh_digest

    @property
    def marked(self) -> bool:
        """Whether it is attacked with the mark."""
        return True

    def identity(self) -> dict[str, Any]:
        """Return all that the numbers of this cell depend on, as plain JSON values."""
        budget = {"budget": self.budget.model_dump()} if self.budget else {}
        return budget | {
            "rows": ROWS_VERSION,
            "kind": self.kind,
            "seed": self.seed,
            "mesh": [self.mesh, self.mesh_digest],
            "scheme": self.scheme.identity(),
            "attack": self.attack.identity(),
            "engines": self.scheme.engine_versions() | self.attack.engine_versions(),
            "trials": [self.start, self.stop],
        }


@dataclass(frozen=True)
class TrialCell(Cell):
    """Consecutive trials: a mesh is attacked and read, a key is scored, one row a score.

    Attributes
    ----------
    hypothesis : "H1", "H0-unmarked" or "H0-other-mesh"
        H1: the trial's key was embedded in the mesh. H0-unmarked: the mesh is attacked as it is.
        H0-other-mesh: another mesh, `other`, is attacked as it is.
    wrong_keys : int
        Under H1, keys never embedded that are scored on the same attacked mesh (H0-wrong-key).
    other : (str, str), optional
        Name and digest of the mesh that H0-other-mesh reads.
    """

    kind: ClassVar[str] = "trials"

    hypothesis: Hypothesis
    wrong_keys: int = 0
    other: tuple[str, str] | None = None

    @property
    def subject(self) -> tuple[str, str]:
        """Name and digest of the mesh that is attacked, with the mark or without."""
        return self.other or super().subject

    @property
    def marked(self) -> bool:
        """Whether it is attacked with the mark."""
        return self.hypothesis == "H1"

    def identity(self) -> dict[str, Any]:
        """Return all that the numbers of this cell depend on, as plain JSON values."""
        own = {"hypothesis": self.hypothesis, "wrong_keys": self.wrong_keys, "other": self.other}
        return super().identity() | own


@dataclass(frozen=True)
class FalseAlarmCell(Cell):
    """The Monte Carlo false-alarm curve: random keys scored on the marked, attacked mesh of one trial.

    Attributes
    ----------
    keys : int
        How many, at least (`wm3d.stats.hadamard_keys`).
    """

    kind: ClassVar[str] = "false-alarms"

    keys: int

    def identity(self) -> dict[str, Any]:
        """Return all that the numbers of this cell depend on, as plain JSON values."""
        return super().identity() | {"keys": self.keys}


@dataclass(frozen=True)
class CalibrationCell(Cell):
    """The strength at which a scheme meets its budget on a mesh, found with one key; nothing is attacked."""

    kind: ClassVar[str] = "calibration"

    def identity(self) -> dict[str, Any]:
        """Return all that the numbers of this cell depend on, as plain JSON values."""
        return super().identity() | {"tolerance": CALIBRATION_DB}


@dataclass(frozen=True)
class Task:
    """What one worker does at a time: cells with the same marked meshes, so each mark is embedded once."""

    cells: tuple[Cell, ...]

    @property
    def meshes(self) -> set[str]:
        """Names of the meshes that are needed."""
        return {name for cell in self.cells for name in (cell.mesh, cell.subject[0])}

    @property
    def trials(self) -> int:
        """Number of attacked meshes."""
        return sum(cell.trials for cell in self.cells)

    def split(self) -> "list[Task]":
        """Return a task for each cell."""
        return [Task((cell,)) for cell in self.cells]


def plan(
    experiment: Experiment, meshes: Mapping[str, Mesh], strengths: Mapping[str, float] | None = None
) -> list[Cell]:
    """Expand an experiment into its cells.

    Parameters
    ----------
    experiment : Experiment
    meshes : mapping of str to Mesh
        Every mesh that the experiment names.
    strengths : mapping of str to float, optional
        Strengths by the digests of `calibrations`; those that are NaN have no cells, those that are not
        there yet are planned at the strength at which the calibration starts.
    """
    digests = {name: mesh.digest() for name, mesh in meshes.items()}
    if experiment.budgets:
        settings: list[tuple[str, Scheme, Budget | None]] = [
            (cell.mesh, _of_strength(cell.scheme, strength), cell.budget)
            for cell in calibrations(experiment, meshes)
            if (strength := (strengths or {}).get(cell.digest)) is None or not math.isnan(strength)
        ]
    else:
        settings = [
            (mesh, scheme, None)
            for case in experiment.cases
            for mesh in case.meshes
            for scheme in case.schemes
        ]
    return _unique(cell for setting in settings for cell in _cells_of(experiment, digests, *setting))


def calibrations(experiment: Experiment, meshes: Mapping[str, Mesh]) -> list[Cell]:
    """Return a cell for each mesh, scheme and budget of an experiment; none without budgets."""
    return _unique(
        CalibrationCell(
            experiment.seed, mesh, meshes[mesh].digest(), uncalibrated(scheme), Clean(), 0, 1, budget=budget
        )
        for budget in experiment.budgets
        for case in experiment.cases
        for mesh in case.meshes
        for scheme in case.schemes
    )


def uncalibrated(scheme: Scheme) -> Scheme:
    """Return a scheme with the default of its strength, where it has one."""
    strength = scheme.strength_field()
    return scheme if strength.is_required() else _of_strength(scheme, strength.default)


def _of_strength(scheme: Scheme, strength: float | None) -> Scheme:
    return scheme if strength is None else scheme.model_copy(update={scheme.strength: strength})


def _unique(cells: Iterable[Cell]) -> list[Cell]:
    """Keep each cell once: a mesh or attack named twice is run once."""
    return list({cell.digest: cell for cell in cells}.values())


def _cells_of(
    experiment: Experiment, digests: Mapping[str, str], mesh: str, scheme: Scheme, budget: Budget | None
) -> Iterator[Cell]:
    for start in range(0, experiment.trials, experiment.block):
        stop = min(start + experiment.block, experiment.trials)
        for attack in experiment.attacks:
            block = (experiment.seed, mesh, digests[mesh], scheme, attack, start, stop)
            yield TrialCell(*block, "H1", experiment.wrong_keys, budget=budget)
            if experiment.unmarked:
                yield TrialCell(*block, "H0-unmarked", budget=budget)
            for other in experiment.cross_meshes:
                if digests[other] != digests[mesh]:
                    crossed = (other, digests[other])
                    yield TrialCell(*block, "H0-other-mesh", other=crossed, budget=budget)
    if experiment.false_alarm_trials:
        for attack in experiment.attacks:
            first = (experiment.seed, mesh, digests[mesh], scheme, attack, 0, 1)
            yield FalseAlarmCell(*first, experiment.false_alarm_trials, budget=budget)


def tasks(cells: list[Cell]) -> list[Task]:
    """Group cells that share mesh, scheme and trials."""
    groups: dict[tuple[str, str, str, int, int], list[Cell]] = {}
    for cell in cells:
        scheme = json.dumps(cell.scheme.identity(), sort_keys=True)
        key = (cell.label, scheme, cell.mesh_digest, cell.start, cell.stop)
        groups.setdefault(key, []).append(cell)
    return [Task(tuple(group)) for group in groups.values()]
