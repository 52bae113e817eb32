"""The plan of an experiment: cells, which are data, named by a digest of all that their numbers depend on."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from typing import Any, ClassVar, Literal

from wm3d.attacks import Attack
from wm3d.bench.config import Experiment
from wm3d.component import Component
from wm3d.mesh import Mesh
from wm3d.schemes import Scheme

ROWS_VERSION = 1
"""Raised when the columns of a row or the way a trial is made change."""

Hypothesis = Literal["H1", "H0-unmarked", "H0-other-mesh"]


@dataclass(frozen=True)
class Cell:
    """What one file holds: numbers of one scheme and one attack on one mesh.

    Attributes
    ----------
    start, stop : int
        Trials start ≤ t < stop; a trial's key and noise follow from its number.
    """

    kind: ClassVar[str]

    seed: int
    mesh: str
    mesh_digest: str
    scheme: Scheme
    attack: Attack
    start: int
    stop: int

    @cached_property
    def digest(self) -> str:
        """Name of the cell: 20 hex digits of the sha256 of its identity."""
        canonical = json.dumps(self.identity(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()[:20]

    @property
    def trials(self) -> int:
        """Number of attacked meshes."""
        return self.stop - self.start

    @property
    def unmarked(self) -> str | None:
        """Name of the mesh that is attacked as it is, None where the marked mesh is attacked."""
        return None

    def identity(self) -> dict[str, Any]:
        """Return all that the numbers of this cell depend on, as plain JSON values."""
        return {
            "rows": ROWS_VERSION,
            "kind": self.kind,
            "seed": self.seed,
            "mesh": [self.mesh, self.mesh_digest],
            "scheme": self.scheme.identity(),
            "attack": self.attack.identity(),
            "engines": _engine_versions(self.scheme, self.attack),
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
    def unmarked(self) -> str | None:
        """Name of the mesh that is attacked as it is, None where the marked mesh is attacked."""
        if self.hypothesis == "H1":
            return None
        return self.other[0] if self.other else self.mesh

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
class Task:
    """What one worker does at a time: cells with the same marked meshes, so each mark is embedded once."""

    cells: tuple[Cell, ...]

    @property
    def meshes(self) -> set[str]:
        """Names of the meshes that are needed."""
        return {name for cell in self.cells for name in (cell.mesh, cell.unmarked or cell.mesh)}

    @property
    def trials(self) -> int:
        """Number of attacked meshes."""
        return sum(cell.trials for cell in self.cells)

    def split(self) -> "list[Task]":
        """Return a task for each cell."""
        return [Task((cell,)) for cell in self.cells]


def plan(experiment: Experiment, meshes: Mapping[str, Mesh]) -> list[Cell]:
    """Expand an experiment into its cells.

    Parameters
    ----------
    experiment : Experiment
    meshes : mapping of str to Mesh
        Every mesh that the experiment names.
    """
    digests = {name: mesh.digest() for name, mesh in meshes.items()}
    cells = [
        cell
        for case in experiment.cases
        for mesh in case.meshes
        for scheme in case.schemes
        for cell in _cells_of(experiment, mesh, digests, scheme)
    ]
    return list({cell.digest: cell for cell in cells}.values())  # a mesh or attack named twice is run once


def _cells_of(
    experiment: Experiment, mesh: str, digests: Mapping[str, str], scheme: Scheme
) -> Iterator[Cell]:
    for start in range(0, experiment.trials, experiment.block):
        stop = min(start + experiment.block, experiment.trials)
        for attack in experiment.attacks:
            block = (experiment.seed, mesh, digests[mesh], scheme, attack, start, stop)
            yield TrialCell(*block, "H1", experiment.wrong_keys)
            if experiment.unmarked:
                yield TrialCell(*block, "H0-unmarked")
            for other in experiment.cross_meshes:
                if digests[other] != digests[mesh]:
                    yield TrialCell(*block, "H0-other-mesh", other=(other, digests[other]))
    if experiment.false_alarm_trials:
        for attack in experiment.attacks:
            first = (experiment.seed, mesh, digests[mesh], scheme, attack, 0, 1)
            yield FalseAlarmCell(*first, experiment.false_alarm_trials)


def tasks(cells: list[Cell]) -> list[Task]:
    """Group cells that share mesh, scheme and trials."""
    groups: dict[tuple[str, str, int, int], list[Cell]] = {}
    for cell in cells:
        key = (cell.mesh_digest, json.dumps(cell.scheme.identity(), sort_keys=True), cell.start, cell.stop)
        groups.setdefault(key, []).append(cell)
    return [Task(tuple(group)) for group in groups.values()]


def _engine_versions(*components: Component) -> dict[str, str]:
    return {engine: version(engine) for component in components for engine in component.engines}
