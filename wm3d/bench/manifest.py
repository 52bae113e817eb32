"""The manifest of a run: what ran, where, when, with which versions."""

import json
import platform
import socket
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from importlib.metadata import requires, version
from typing import Any

from packaging.requirements import Requirement

from wm3d.attacks import Noise
from wm3d.bench.config import Experiment
from wm3d.bench.plan import Cell
from wm3d.component import Component
from wm3d.mesh import Mesh, datasets
from wm3d.registry import component_name


def manifest(
    experiment: Experiment,
    meshes: Mapping[str, Mesh],
    cells: list[Cell],
    started: datetime,
    lost_trials: int,
) -> str:
    """Return manifest.json as text.

    Parameters
    ----------
    experiment : Experiment
    meshes : mapping of str to Mesh
    cells : list of Cell
        The cells whose rows the run directory holds, in plan order; reports read these and no others.
    started : datetime
        When the run began; it ends now.
    lost_trials : int
        Attacked meshes that failed because their worker died or ran out of memory.
    """
    ended = datetime.now(UTC)
    content: dict[str, Any] = {
        "name": experiment.name,
        "started": started.isoformat(timespec="seconds"),
        "ended": ended.isoformat(timespec="seconds"),
        "seconds": round((ended - started).total_seconds(), 1),
        "host": {
            "name": socket.gethostname(),
            "system": platform.platform(),
            "processor": platform.machine(),
            "python": platform.python_version(),
        },
        "versions": _versions(),
        "schemes": _component_versions(cell.scheme for cell in cells),
        "attacks": _component_versions(cell.attack for cell in cells),
        "meshes": {name: _mesh_entry(name, mesh) for name, mesh in meshes.items()},
        "sigma_percent": {name: _noise(experiment, mesh) for name, mesh in meshes.items()},
        "lost_trials": lost_trials,
        "cells": [cell.digest for cell in cells if cell.kind == "trials"],
        "calibration_cells": [cell.digest for cell in cells if cell.kind == "calibration"],
        "false_alarm_cells": [cell.digest for cell in cells if cell.kind == "false-alarms"],
    }
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _component_versions(components: Iterable[Component]) -> dict[str, int]:
    """Return the versions of components, and of those among their parameters, by name."""
    return {component_name(type(part)): part.version for whole in components for part in whole.components()}


def _versions() -> dict[str, str]:
    """Versions of wm3d and of every package that it needs at run time."""
    needed = [Requirement(line) for line in requires("wm3d") or []]
    names = sorted(need.name for need in needed if need.marker is None)
    return {"wm3d": version("wm3d")} | {name: version(name) for name in names}


def _noise(experiment: Experiment, mesh: Mesh) -> dict[str, float]:
    """Noise of an experiment in its common unit, by the label of the attack; of the mesh without a mark."""
    noise = [attack for attack in experiment.attacks if isinstance(attack, Noise)]
    return {attack.label(): attack.sigma_percent(mesh) for attack in noise}


def _mesh_entry(name: str, mesh: Mesh) -> dict[str, Any]:
    return {
        "sha256": mesh.digest(),
        "vertices": len(mesh.vertices),
        "faces": len(mesh.faces),
        "credit": datasets.credit(name),
    }
