"""What the harness costs: the share of a simplification trial that is spent outside the simplifier itself.

    WM3D_DATA=folder-with-the-meshes python experiments/overhead.py [--trials 4]

Runs the trials of a task as `wm3d run` does, on one core, each attack by itself, and times the call into the
engine inside the attack. All else is overhead: marking, SNR, seeds, checks and copies around the engine,
pose, axes, scan, score and wrong keys. A task embeds each mark once for all of its attacks, so the overhead
is given both with the mark shared by the attacks below and with all of it.
"""

import argparse
import time
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any
from unittest.mock import patch

import fast_simplification
import pymeshlab

from wm3d.attacks import Simplify
from wm3d.bench.plan import Task, TrialCell
from wm3d.bench.subjects import Subjects
from wm3d.bench.worker import work
from wm3d.mesh import Mesh, datasets
from wm3d.schemes import Song2002

MESH = "happy-buddha-300k"
SCHEME = Song2002(grid=(84, 120), region=(26, 0, 80, 80), alpha=0.9)
ATTACKS = [Simplify(simplifier="fast-simplification"), Simplify(simplifier="pymeshlab-quadric")]
WRONG_KEYS = 50
"""As in configs/paper/fig6a.yaml."""

PARTS = [
    (fast_simplification, "simplify", "engine"),
    (pymeshlab.MeshSet, "meshing_decimation_quadric_edge_collapse", "engine"),
    (Subjects, "mark", "mark"),
]
"""The functions that are timed. Handing the mesh over to an engine and back is overhead."""

LIMIT = 0.15
"""Share that the overhead may have where a task's attacks share the mark."""


def main(trials: int) -> None:
    mesh = datasets.resolve(MESH)
    print(f"{MESH}: {len(mesh.vertices)} vertices, {len(mesh.faces)} faces; {trials} trials; seconds a trial")
    print(f"{'attack':22s}{'engine':>8s}{'mark':>8s}{'rest':>8s}   overhead: mark shared, not shared")
    for attack in ATTACKS:
        measured(mesh, attack, 1)  # loads the kernels
        seconds = measured(mesh, attack, trials)
        engine, mark = seconds["engine"], seconds["mark"]
        rest = seconds["whole"] - engine - mark
        shared, alone = (1 - engine / (engine + rest + mark / share) for share in (len(ATTACKS), 1))
        print(
            f"{attack.simplifier:22s}{engine:8.3f}{mark:8.3f}{rest:8.3f}{shared:16.1%}{alone:15.1%}"
            f"   {'at most' if shared <= LIMIT else 'ABOVE'} {LIMIT:.0%}"
        )


def measured(mesh: Mesh, attack: Simplify, trials: int) -> Counter[str]:
    """Return the seconds a trial of a task with this attack: in all, and in its parts."""
    seconds: Counter[str] = Counter()

    def timed(function: Callable[..., Any], part: str) -> Callable[..., Any]:
        def call(*arguments: Any, **options: Any) -> Any:
            start = time.perf_counter()
            result = function(*arguments, **options)
            seconds[part] += (time.perf_counter() - start) / trials
            return result

        return call

    task = Task((TrialCell(2002, MESH, mesh.digest(), SCHEME, attack, 0, trials, "H1", WRONG_KEYS),))
    with ExitStack() as stack:
        for owner, name, part in PARTS:
            stack.enter_context(patch.object(owner, name, timed(getattr(owner, name), part)))
        timed(work, "whole")({MESH: mesh}, task)
    return seconds


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=4)
    main(**vars(parser.parse_args()))
