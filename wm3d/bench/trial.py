"""Running the cells of a task: embed, attack, scan, score; one row a score."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from wm3d.bench.calibration import calibration_row, uncalibrated_row
from wm3d.bench.columns import COLUMNS, GONE, LOST, TRY_AGAIN
from wm3d.bench.plan import CalibrationCell, Cell, FalseAlarmCell, Task, TrialCell
from wm3d.bench.seeds import derived_seed
from wm3d.bench.subjects import NotMarkedError, Subjects
from wm3d.errors import Wm3dError, in_words
from wm3d.mesh import Mesh
from wm3d.schemes import Scheme
from wm3d.stats import RademacherSum, hadamard_keys, log10_tail

THRESHOLDS = np.arange(-30, 66) / 10
"""Thresholds z of the Monte Carlo false-alarm curve: Pf from 0.999 down to 4e-11."""

_SECONDS = ("seconds", "embed_seconds", "attack_seconds", "score_seconds")
_MEASURED = ("statistic", "z", "log10_p", "snr_db", "axis_deg", "log10_p_least")
_ONCE = ("bit_error_rate", "embed_mb")  # of the key that was embedded, or of embedding it

_UNREAD = dict.fromkeys(("statistic", "z", "log10_p", "log10_p_least"), 0.0)
"""Score of a key that its mesh could not carry: p = 1, as where the mark cannot be read."""

Row = dict[str, Any]

Made = tuple[list[Row], Exception | None]
"""Rows of one trial, and the error that it met."""


def run_task(meshes: Mapping[str, Mesh], task: Task) -> dict[str, pd.DataFrame]:
    """Run all trials of a task.

    Parameters
    ----------
    meshes : mapping of str to Mesh
        Those of `task.meshes`, by name.
    task : Task

    Returns
    -------
    dict of str to DataFrame
        The rows of each cell, by its digest; a cell for which memory ran out is not there.
    """
    made: dict[str, list[Made]] = {cell.digest: [] for cell in task.cells}
    first = task.cells[0]
    subjects = Subjects(meshes, first)
    for trial in range(first.start, first.stop):
        for cell in task.cells:
            if cell.digest not in made:
                continue
            try:
                made[cell.digest].append(_made(cell, trial, subjects, meshes))
            except MemoryError:  # that is about this machine, not about the mesh: there is nothing to store
                del made[cell.digest]
    return {cell.digest: _frame(cell, made[cell.digest]) for cell in task.cells if cell.digest in made}


def lost_rows(cell: Cell) -> pd.DataFrame:
    """Return the rows of a cell that no worker could make: each trial failed, and is to be tried again."""
    rows: list[Row] = []
    if isinstance(cell, CalibrationCell):
        rows = [uncalibrated_row(cell, GONE)]
    elif isinstance(cell, TrialCell):
        rows = [_blank(cell, trial) | {"error": GONE} for trial in range(cell.start, cell.stop)]
    frame = _frame(cell, [(rows, None)])
    frame.attrs = {TRY_AGAIN: True, LOST: True}
    return frame


def _made(cell: Cell, trial: int, subjects: Subjects, meshes: Mapping[str, Mesh]) -> Made:
    if isinstance(cell, TrialCell):
        return _trial_rows(cell, trial, subjects)
    if isinstance(cell, FalseAlarmCell):
        return _false_alarm_rows(cell, trial, subjects)
    if isinstance(cell, CalibrationCell):
        row, error = calibration_row(cell, meshes[cell.mesh])
        return [row], error
    raise TypeError(f"no rows are made for {type(cell).__name__}")


def _frame(cell: Cell, made: list[Made]) -> pd.DataFrame:
    columns = COLUMNS[cell.kind]
    frame = pd.DataFrame([row for rows, _ in made for row in rows], columns=list(columns)).astype(columns)
    if any(error is not None and not isinstance(error, Wm3dError) for _, error in made):
        frame.attrs[TRY_AGAIN] = True
    return frame


def _names(cell: Cell) -> Row:
    return {
        "mesh": cell.mesh,
        "scheme": cell.label,
        "scheme_parameters": cell.scheme.model_dump_json(),
        "attack": cell.attack.label(),
        "attack_parameters": cell.attack.model_dump_json(),
    }


def _blank(cell: TrialCell, trial: int) -> Row:
    """Return the row of a trial of which nothing is known yet."""
    return {
        **_names(cell),
        "hypothesis": cell.hypothesis,
        "subject": cell.subject[0],
        "trial": trial,
        **dict.fromkeys((*_MEASURED, *_ONCE, *_SECONDS), float("nan")),
        "faces_out": 0,
        "error": "",
    }


def _trial_rows(cell: TrialCell, trial: int, subjects: Subjects) -> Made:
    row = _blank(cell, trial)
    try:
        mark = subjects.mark(trial)
        if cell.hypothesis == "H1":
            row |= {"snr_db": mark.snr_db, "embed_seconds": mark.seconds, "embed_mb": mark.mb}
        reading = subjects.read(cell, trial)
        start = time.perf_counter()
        signs = mark.scheme.signs(mark.seed)
        score = reading.evidence.score(signs)
        score_seconds = reading.read_seconds + time.perf_counter() - start
    except MemoryError:
        raise
    except NotMarkedError as refusal:
        if cell.hypothesis != "H1":
            return [], refusal  # there is no such key; H1 rows say so
        row |= _UNREAD | ({"bit_error_rate": 0.5} if cell.scheme.message else {})
        return [row | {"error": str(refusal)}], refusal
    except Exception as error:  # whatever an engine raises fails this trial, not the run; the row says it
        return [row | {"error": in_words(error)}], error
    row |= {
        "statistic": score.statistic,
        "z": score.z,
        "log10_p": score.log10_p,
        "axis_deg": reading.axis_deg,
        "faces_out": reading.faces,
        "seconds": reading.attack_seconds + score_seconds,
        "attack_seconds": reading.attack_seconds,
        "score_seconds": score_seconds,
        "error": reading.unreadable,
        "log10_p_least": reading.evidence.log10_p_least,
    }
    if cell.hypothesis == "H1" and mark.scheme.message:
        row["bit_error_rate"] = reading.evidence.bit_error_rate(signs)
    return [row, *_wrong_key_rows(cell, row, mark.scheme, reading.evidence)], None


def _wrong_key_rows(cell: TrialCell, row: Row, scheme: Scheme, evidence: RademacherSum) -> list[Row]:
    """Score keys that were never embedded on the same mesh; their trials are numbered on."""
    if cell.wrong_keys == 0:
        return []
    streams = [f"wrong-key-{i}" for i in range(cell.wrong_keys)]
    seeds = [derived_seed(cell.seed, cell.mesh_digest, row["trial"], stream) for stream in streams]
    sums = np.array([evidence.b @ scheme.signs(seed) for seed in seeds])
    z = sums / evidence.scale if evidence.scale > 0 else np.zeros(len(sums))
    common = row | {"hypothesis": "H0-wrong-key", "error": ""}
    common |= dict.fromkeys(_SECONDS, 0.0) | dict.fromkeys(_ONCE, float("nan"))
    return [
        {
            **common,
            "trial": row["trial"] * cell.wrong_keys + i,
            "statistic": evidence.offset + sums[i],
            "z": z[i],
            "log10_p": log10_p,
        }
        for i, log10_p in enumerate(evidence.log10_p(z))
    ]


def _false_alarm_rows(cell: FalseAlarmCell, trial: int, subjects: Subjects) -> Made:
    """Draw random keys on the marked, attacked mesh; no rows where it cannot be had, as H1 rows say."""
    try:
        evidence = subjects.read(cell, trial).evidence
    except MemoryError:
        raise
    except Exception as error:  # the same trial fails under H1
        return [], error
    if evidence.scale == 0:
        return [], None
    seed = derived_seed(cell.seed, cell.mesh_digest, trial, "false-alarm")
    drawn = hadamard_keys(evidence.b, THRESHOLDS, cell.keys, seed)
    band = drawn.interval()
    names = _names(cell)
    rows = [
        {
            **names,
            "z": z,
            "exceedances": count,
            "keys": drawn.trials,
            "pf_low": low,
            "pf_high": high,
            "log10_p": log10_p,
        }
        for z, count, low, high, log10_p in zip(
            THRESHOLDS, drawn.counts, band.low, band.high, log10_tail(evidence.b, THRESHOLDS), strict=True
        )
    ]
    return rows, None
