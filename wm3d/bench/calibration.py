"""Calibration: the strength at which a scheme meets a budget of distortion on a mesh."""

import time
from typing import Any

from wm3d.bench.plan import CALIBRATION_DB, CalibrationCell, uncalibrated
from wm3d.bench.seeds import derived_seed
from wm3d.errors import in_words
from wm3d.mesh import Mesh
from wm3d.metrics import Budget


def calibration_row(cell: CalibrationCell, mesh: Mesh) -> tuple[dict[str, Any], Exception | None]:
    """Return the row of a calibration, with the columns `wm3d.bench.columns.CALIBRATION`, and what it met.

    One key serves all schemes and budgets. A scheme that cannot carry a mark in this mesh, or cannot meet the
    budget, has a row that says so.
    """
    scheme, budget = cell.scheme, _budget(cell)
    seed = derived_seed(cell.seed, cell.mesh_digest, 0, "calibration")
    strength, reached, met = float("nan"), float("nan"), None
    start = time.perf_counter()
    try:
        found = scheme.at_distortion(mesh, seed, budget, CALIBRATION_DB)
        strength = float(getattr(found, found.strength))
        reached = budget.measured(mesh, found.embed(mesh, seed)[0])
    except MemoryError:
        raise
    except Exception as error:  # whatever an engine raises fails this scheme, not the run; the row says it
        met = error
    row = uncalibrated_row(cell, "" if met is None else in_words(met)) | {
        "reached": reached,
        "strength": strength,
        "seconds": time.perf_counter() - start,
    }
    return row, met


def uncalibrated_row(cell: CalibrationCell, error: str) -> dict[str, Any]:
    """Return the row of a calibration of which nothing is known but what went wrong."""
    budget = _budget(cell)
    return {
        "mesh": cell.mesh,
        "scheme": cell.label,
        "method": uncalibrated(cell.scheme).label(),
        "budget": budget.label(),
        "metric": budget.metric,
        "wanted": budget.value,
        "reached": float("nan"),
        "parameter": cell.scheme.strength,
        "strength": float("nan"),
        "seconds": float("nan"),
        "error": error,
    }


def _budget(cell: CalibrationCell) -> Budget:
    if cell.budget is None:
        raise ValueError("a calibration needs a budget")
    return cell.budget
