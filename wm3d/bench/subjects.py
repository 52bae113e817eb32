"""The meshes of a task: marked, attacked, read. What does not change from trial to trial is made once."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from wm3d.attacks import Attack
from wm3d.attacks.base import Owner
from wm3d.bench.columns import NOT_MARKED
from wm3d.bench.memory import with_peak
from wm3d.bench.plan import Cell
from wm3d.bench.seeds import derived_seed, generator
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import snr
from wm3d.scanner import Cylinder
from wm3d.schemes import Scheme
from wm3d.stats import RademacherSum

MOST_RESIDUAL = 0.3
"""RMS distance of the vertices after their best alignment, over their RMS radius, up to which they count as
the same vertices in the same order; in another order it is nearly 1."""


class NotMarkedError(Wm3dError):
    """A scheme refused to mark a mesh with the key of a trial."""


@dataclass(frozen=True, eq=False)
class Mark:
    """A marked mesh, its key's seed, the scheme to read it with, its SNR in dB, what it took in s and MB."""

    mesh: Mesh
    seed: int
    scheme: Scheme
    snr_db: float
    seconds: float
    mb: float


@dataclass(frozen=True, eq=False)
class Reading:
    """What a detector sees in an attacked mesh.

    Attributes
    ----------
    faces : int
        Of the attacked mesh.
    evidence : RademacherSum
        The statistic as a function of the key; nothing but zeros where the mesh cannot be read.
    unreadable : str
        Why it cannot be read; empty where it can.
    axis_deg : float
        Angle in degrees between the axes of the original and of the attacked mesh; NaN without axes, and
        where an attack that turns the model left no vertices to turn it back by.
    attack_seconds, read_seconds : float
    """

    faces: int
    evidence: RademacherSum
    unreadable: str
    axis_deg: float
    attack_seconds: float
    read_seconds: float


_SETTLED: dict[tuple[str, str, str], tuple[Scheme, Reading]] = {}
"""What schemes read in a mesh without a mark, of this name and digest, after an attack that is not random."""

MOST_SETTLED = 256
"""Readings kept, of some 50 kB each."""


class Subjects:
    """What the cells of a task start from.

    Parameters
    ----------
    meshes : mapping of str to Mesh
        Those that the task needs.
    first : Cell
        Any cell of the task; all have the same mesh, scheme and seed.
    """

    def __init__(self, meshes: Mapping[str, Mesh], first: Cell) -> None:
        self._meshes, self._first = meshes, first
        self._last: tuple[int, Mark | NotMarkedError] | None = None
        self._cylinders: dict[str, Cylinder | None] = {}

    def mark(self, trial: int) -> Mark:
        """Return the mesh marked with the key of a trial; the last one is kept, or why it was refused.

        Raises
        ------
        NotMarkedError
            If the mesh cannot carry the mark.
        """
        if self._last is None or self._last[0] != trial:
            try:
                self._last = trial, self._marked(trial)
            except Wm3dError as error:
                self._last = trial, NotMarkedError(f"{NOT_MARKED}{error}")
        if isinstance(self._last[1], NotMarkedError):
            raise self._last[1]
        return self._last[1]

    def _marked(self, trial: int) -> Mark:
        cell = self._first
        seed = derived_seed(cell.seed, cell.mesh_digest, trial, "key")
        original = self._meshes[cell.mesh]
        start = time.perf_counter()
        if self._last is None:
            (marked, scheme), mb = with_peak(lambda: _embedded(cell.scheme, original, seed))
        else:
            (marked, scheme), mb = _embedded(cell.scheme, original, seed), float("nan")
        seconds = time.perf_counter() - start
        return Mark(marked, seed, scheme, snr(original, marked), seconds, mb)

    def read(self, cell: Cell, trial: int) -> Reading:
        """Attack the mesh of a cell and read it.

        An attack without randomness does the same to a mesh without the mark in every trial, so that is
        attacked and read only once, by this worker.
        """
        mark = self.mark(trial)
        if cell.marked:
            return self._read(cell, trial, mark.mesh, mark.scheme)
        what = (*cell.subject, cell.attack.model_dump_json())
        if what in _SETTLED and _SETTLED[what][0] == mark.scheme:
            return _SETTLED[what][1]
        reading = self._read(cell, trial, self._meshes[cell.subject[0]], mark.scheme)
        if not cell.attack.random:
            again = replace(reading, attack_seconds=0.0, read_seconds=0.0)
            if len(_SETTLED) >= MOST_SETTLED:
                _SETTLED.clear()
            _SETTLED[what] = mark.scheme, again
        return reading

    def _read(self, cell: Cell, trial: int, subject: Mesh, scheme: Scheme) -> Reading:
        original = self._meshes[cell.subject[0]]
        attack = cell.attack.given(Owner(original, lambda mesh, seed: cell.scheme.embed(mesh, seed)[0]))
        rng = generator(derived_seed(cell.seed, cell.mesh_digest, trial, "attack"))
        start = time.perf_counter()
        attacked = attack(subject, rng)
        if not isinstance(attacked, Mesh):
            raise TypeError(f"the attack returned {type(attacked).__name__}, not Mesh")
        attacked_at, unreadable = time.perf_counter(), ""
        try:
            evidence = scheme.evidence(attacked)
        except Wm3dError as error:  # unreadable is not detected
            evidence, unreadable = RademacherSum(0.0, np.zeros(scheme.capacity)), str(error)
        read_at = time.perf_counter()
        before, after = self._cylinder(cell.subject[0]), _cylinder(scheme, attacked)
        axis_deg = _axis_deviation(before, after, cell.attack, subject, attacked)
        return Reading(
            len(attacked.faces), evidence, unreadable, axis_deg, attacked_at - start, read_at - attacked_at
        )

    def _cylinder(self, mesh: str) -> Cylinder | None:
        if mesh not in self._cylinders:
            self._cylinders[mesh] = _cylinder(self._first.scheme, self._meshes[mesh])
        return self._cylinders[mesh]


def _embedded(scheme: Scheme, mesh: Mesh, seed: int) -> tuple[Mesh, Scheme]:
    made: object = scheme.embed(mesh, seed)
    match made:
        case (Mesh() as marked, Scheme() as reader):
            return marked, reader
    raise TypeError(f"embed returned {type(made).__name__}, not a marked mesh and the scheme that reads it")


def _cylinder(scheme: Scheme, mesh: Mesh) -> Cylinder | None:
    try:
        return scheme.cylinder(mesh)
    except Wm3dError:
        return None


def _axis_deviation(
    before: Cylinder | None, after: Cylinder | None, attack: Attack, subject: Mesh, attacked: Mesh
) -> float:
    """Angle between the axes; where the attack turns the model, it is first turned back."""
    if before is None or after is None:
        return float("nan")
    if attack.turns:
        back = _rotation_back(subject, attacked)
        if back is None:
            return float("nan")
        after = replace(after, axes=back.apply(after.axes))
    return before.axis_deviation(after)


def _rotation_back(subject: Mesh, attacked: Mesh) -> Rotation | None:
    """Rotation that turns the attacked mesh back, vertex by vertex; None where the vertices do not match."""
    if len(attacked.vertices) != len(subject.vertices):
        return None
    x, y = (mesh.vertices - mesh.vertices.mean(axis=0) for mesh in (subject, attacked))
    products = x.T @ y / np.sqrt(np.vdot(x, x) * np.vdot(y, y))
    back = Rotation.align_vectors(products.T, np.eye(3))[0]  # sees no more of x and y than their products
    # with the best scale too, the squared residual is 1 − (x · y)²
    agreement = float((products * back.as_matrix()).sum())
    return back if agreement > 0 and 1 - agreement**2 <= MOST_RESIDUAL**2 else None
