"""Running the trials of a task: embed, attack, scan, score; one row a score."""

import time
from collections import defaultdict
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from wm3d.attacks import Attack
from wm3d.bench.plan import Cell, Task
from wm3d.bench.seeds import derived_seed, generator
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import snr
from wm3d.scanner import Cylinder
from wm3d.schemes import Scheme
from wm3d.stats import RademacherSum, Score, log10_tail

COLUMNS = {
    "mesh": "str",
    "scheme": "str",
    "scheme_parameters": "str",
    "attack": "str",
    "attack_parameters": "str",
    "hypothesis": "str",
    "trial": "int64",
    "statistic": "float64",
    "z": "float64",
    "log10_p": "float64",
    "snr_db": "float64",
    "axis_deg": "float64",
    "faces_out": "int64",
    "seconds": "float64",
    "embed_seconds": "float64",
    "attack_seconds": "float64",
    "score_seconds": "float64",
    "error": "str",
}
"""Columns of a row. `seconds` is the time of attack and scoring; scores are NaN where the attack failed."""


def run_task(mesh: Mesh, task: Task) -> dict[str, pd.DataFrame]:
    """Run all trials of a task.

    Returns
    -------
    dict of str to DataFrame
        The rows of each cell, by its digest.
    """
    rows: dict[str, list[dict[str, Any]]] = defaultdict(list)
    first = task.cells[0]
    settled: dict[Attack, Mesh] = {}
    for trial in range(first.start, first.stop):
        seed = derived_seed(first.seed, first.mesh_digest, trial, "key")
        subjects = _Subjects(mesh, first.scheme, seed, settled)
        for cell in task.cells:
            rows[cell.digest] += _run_trial(cell, trial, subjects)
    return {digest: pd.DataFrame(cell_rows).astype(COLUMNS) for digest, cell_rows in rows.items()}


class _Subjects:
    """The meshes that a trial starts from: the marked one, made when first asked for, and the original.

    `settled` keeps, over the trials of a task, what attacks without randomness make of the original.
    """

    def __init__(self, mesh: Mesh, scheme: Scheme, seed: int, settled: dict[Attack, Mesh]) -> None:
        self.mesh, self.seed, self._settled = mesh, seed, settled
        self._scheme = scheme
        self._marked: tuple[Mesh, Scheme, float, float] | None = None

    def get(self, hypothesis: str) -> tuple[Mesh, Scheme, float, float]:
        """Return mesh, scheme to read it with, SNR in dB and seconds of embedding."""
        if self._marked is None:
            start = time.perf_counter()
            marked, scheme = self._scheme.embed(self.mesh, self.seed)
            seconds = time.perf_counter() - start
            self._marked = marked, scheme, snr(self.mesh, marked), seconds
        if hypothesis == "H1":
            return self._marked
        return self.mesh, self._marked[1], float("nan"), 0.0

    def attack(self, attack: Attack, subject: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the attacked mesh."""
        if attack.random or subject is not self.mesh:
            return attack(subject, rng)
        if attack not in self._settled:
            self._settled[attack] = attack(subject, rng)
        return self._settled[attack]


def _run_trial(cell: Cell, trial: int, subjects: _Subjects) -> list[dict[str, Any]]:
    row: dict[str, Any] = {
        "mesh": cell.mesh,
        "scheme": cell.scheme.label(),
        "scheme_parameters": cell.scheme.model_dump_json(),
        "attack": cell.attack.label(),
        "attack_parameters": cell.attack.model_dump_json(),
        "hypothesis": cell.hypothesis,
        "trial": trial,
        **dict.fromkeys(("statistic", "z", "log10_p", "snr_db", "axis_deg"), float("nan")),
        **dict.fromkeys(("seconds", "embed_seconds", "attack_seconds", "score_seconds"), 0.0),
        "faces_out": 0,
        "error": "",
    }
    try:
        subject, scheme, row["snr_db"], row["embed_seconds"] = subjects.get(cell.hypothesis)
        start = time.perf_counter()
        rng = generator(derived_seed(cell.seed, cell.mesh_digest, trial, "attack"))
        attacked = subjects.attack(cell.attack, subject, rng)
        row["attack_seconds"] = time.perf_counter() - start
    except Exception as error:  # whatever an engine raises fails this trial, not the run; the row says it
        return [{**row, "error": f"{type(error).__name__}: {error}"}]
    row["faces_out"] = len(attacked.faces)
    start = time.perf_counter()
    try:
        evidence = scheme.evidence(attacked)
    except Wm3dError as error:  # unreadable is not detected
        evidence, row["error"] = RademacherSum(0.0, np.zeros(scheme.capacity)), str(error)
    score = evidence.score(scheme.signs(subjects.seed))
    row["score_seconds"] = time.perf_counter() - start
    row["seconds"] = row["attack_seconds"] + row["score_seconds"]
    row["axis_deg"] = _axis_deviation(scheme, cell.attack, subjects.mesh, subject, attacked)
    return [{**row, **_fields(score)}, *_wrong_key_rows(cell, trial, row, evidence)]


def _fields(score: Score) -> dict[str, float]:
    return {"statistic": score.statistic, "z": score.z, "log10_p": score.log10_p}


def _wrong_key_rows(
    cell: Cell, trial: int, row: dict[str, Any], evidence: RademacherSum
) -> list[dict[str, Any]]:
    """Score keys that were never embedded on the same mesh; their trials are numbered on."""
    if cell.wrong_keys == 0:
        return []
    seeds = [
        derived_seed(cell.seed, cell.mesh_digest, trial, f"wrong-key-{i}") for i in range(cell.wrong_keys)
    ]
    sums = np.array([evidence.b @ cell.scheme.signs(seed) for seed in seeds])
    z = sums / evidence.scale if evidence.scale > 0 else np.zeros(len(sums))
    common = {**row, "hypothesis": "H0-wrong-key", "seconds": 0.0, "error": ""}
    return [
        {
            **common,
            "trial": trial * cell.wrong_keys + i,
            "statistic": evidence.offset + sums[i],
            "z": z[i],
            "log10_p": log10_p,
        }
        for i, log10_p in enumerate(log10_tail(evidence.b, z))
    ]


def _axis_deviation(scheme: Scheme, attack: Attack, original: Mesh, subject: Mesh, attacked: Mesh) -> float:
    """Angle in degrees between the axes found on the original and on the attacked mesh; NaN without axes.

    Where the attack turns the model and keeps its vertices, the best rotation back onto the mesh before the
    attack is undone first.
    """
    try:
        before, after = scheme.cylinder(original), scheme.cylinder(attacked)
    except Wm3dError:
        return float("nan")
    if before is None or after is None:
        return float("nan")
    if attack.turns:
        if len(attacked.vertices) != len(subject.vertices):
            return float("nan")
        x, y = (mesh.vertices - mesh.vertices.mean(axis=0) for mesh in (subject, attacked))
        back = Rotation.align_vectors(x / np.abs(x).max(), y / np.abs(y).max())[0]
        after = Cylinder(after.center, back.apply(after.axes), after.radius, after.hmin, after.hmax)
    return before.axis_deviation(after)
