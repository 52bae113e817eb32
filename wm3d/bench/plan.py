"""The plan of an experiment: cells, which are data, named by a digest of all that their numbers depend on."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from typing import Any, Literal

from wm3d.attacks import Attack
from wm3d.bench.config import Experiment
from wm3d.component import Component
from wm3d.mesh import Mesh
from wm3d.schemes import Scheme

ROWS_VERSION = 1
"""Raised when the columns of a row or the way a trial is made change."""

Hypothesis = Literal["H1", "H0-unmarked"]


@dataclass(frozen=True)
class Cell:
    """Consecutive trials of one scheme and one attack on one mesh, stored in one file.

    Attributes
    ----------
    hypothesis : "H1" or "H0-unmarked"
        H1: each trial marks the mesh, attacks it and scores the right key and `wrong_keys` wrong ones.
        H0-unmarked: each trial attacks the mesh as it is and scores the trial's key.
    start, stop : int
        Trials start ≤ t < stop.
    """

    seed: int
    mesh: str
    mesh_digest: str
    scheme: Scheme
    attack: Attack
    hypothesis: Hypothesis
    start: int
    stop: int
    wrong_keys: int

    @cached_property
    def digest(self) -> str:
        """Name of the cell: 20 hex digits of the sha256 of its identity."""
        canonical = json.dumps(self.identity(), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()[:20]

    def identity(self) -> dict[str, Any]:
        """Return all that the numbers of this cell depend on, as plain JSON values."""
        return {
            "rows": ROWS_VERSION,
            "seed": self.seed,
            "mesh": [self.mesh, self.mesh_digest],
            "scheme": self.scheme.identity(),
            "attack": self.attack.identity(),
            "engines": _engine_versions(self.scheme, self.attack),
            "hypothesis": self.hypothesis,
            "trials": [self.start, self.stop],
            "wrong_keys": self.wrong_keys,
        }


@dataclass(frozen=True)
class Task:
    """What one worker does at a time: cells with the same marked meshes, so each mark is embedded once."""

    mesh: str
    cells: tuple[Cell, ...]

    @property
    def trials(self) -> int:
        """Number of attacked and scored meshes."""
        return sum(cell.stop - cell.start for cell in self.cells)


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
        Cell(
            seed=experiment.seed,
            mesh=mesh,
            mesh_digest=digests[mesh],
            scheme=scheme,
            attack=attack,
            hypothesis=hypothesis,
            start=start,
            stop=min(start + experiment.block, experiment.trials),
            wrong_keys=experiment.wrong_keys if hypothesis == "H1" else 0,
        )
        for case in experiment.cases
        for mesh in case.meshes
        for scheme in case.schemes
        for start in range(0, experiment.trials, experiment.block)
        for hypothesis in _hypotheses(experiment)
        for attack in experiment.attacks
    ]
    return list({cell.digest: cell for cell in cells}.values())  # a mesh or attack named twice is run once


def tasks(cells: list[Cell]) -> list[Task]:
    """Group cells that share mesh, scheme and trials."""
    groups: dict[tuple[str, str, int, int], list[Cell]] = {}
    for cell in cells:
        key = (cell.mesh_digest, json.dumps(cell.scheme.identity(), sort_keys=True), cell.start, cell.stop)
        groups.setdefault(key, []).append(cell)
    return [Task(group[0].mesh, tuple(group)) for group in groups.values()]


def _hypotheses(experiment: Experiment) -> tuple[Hypothesis, ...]:
    return ("H1", "H0-unmarked") if experiment.unmarked else ("H1",)


def _engine_versions(*components: Component) -> dict[str, str]:
    return {engine: version(engine) for component in components for engine in component.engines}
