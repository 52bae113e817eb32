"""What runs in a worker: one task at a time, on one thread, with the engines of the plan."""

import os
import threading
import time
from collections.abc import Mapping
from dataclasses import replace

import pandas as pd
from threadpoolctl import threadpool_limits

from wm3d.bench.allocator import give_back
from wm3d.bench.plan import Task
from wm3d.bench.trial import run_task
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

_ENGINES = threading.Lock()
"""Dask workers may have several threads, but fast-simplification keeps its mesh in global variables."""


def work(meshes: Mapping[str, Mesh], task: Task) -> dict[str, pd.DataFrame]:
    """Run a task so that its numbers do not depend on the worker.

    BLAS sums in another order on another number of threads, so it gets one. Arrays that were pickled are
    writable and those that were memory-mapped are slow in numba, so the meshes are built anew.

    Parameters and result as for `run_task`.

    Raises
    ------
    Wm3dError
        If this worker has other versions of the engines than the process that made the plan.
    """
    for cell in task.cells:
        here = replace(cell)  # without the digest that came along
        if here.digest != cell.digest:
            raise Wm3dError(
                f"a worker runs other versions than this process: {here.identity()['engines']} there, for "
                f"{cell.attack.label()}; install the same versions of wm3d and its engines on all workers."
            )
    with _ENGINES, threadpool_limits(limits=1):
        own = {name: Mesh(mesh.vertices, mesh.faces, mesh.name) for name, mesh in meshes.items()}
        rows = run_task(own, task)
    give_back()  # joblib takes a worker that grows for one that leaks, and starts another
    return rows


def leave_with_parent(parent: int) -> None:
    """Let this worker end within a second of the process, of id `parent`, that started it.

    A run that is killed would otherwise leave workers that finish their tasks for nobody. POSIX only: a
    Windows process does not learn that its parent is gone, and loky ends it after some idle minutes.
    """

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
