"""Running tasks on local processes or a Dask cluster; results come back one by one, in any order."""

import multiprocessing
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext

import pandas as pd
from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from wm3d.bench.plan import Task
from wm3d.bench.trial import run_task
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

ROUNDS = 2
"""How often all that is left is tried again together after a worker died; then each task once on its own."""


def execute(
    tasks: list[Task], meshes: Mapping[str, Mesh], workers: int, dask: str | None
) -> Iterator[tuple[Task, dict[str, pd.DataFrame]]]:
    """Yield each task with its rows by cell digest, as they are finished.

    A worker that is killed (by the system when memory runs out, say) costs only the tasks in flight: they are
    run again. A task whose worker dies even when it runs alone is not yielded.

    Parameters
    ----------
    tasks : list of Task
    meshes : mapping of str to Mesh
    workers : int
        Local processes; 1 runs everything in this process.
    dask : str or None
        Address of a Dask scheduler to use instead.
    """
    left = list(tasks)
    for _ in range(ROUNDS):
        done: list[int] = []
        try:
            for index, rows in _parallel(left, meshes, workers, dask):
                done.append(index)
                yield left[index], rows
        except TerminatedWorkerError:
            pass
        left = [task for index, task in enumerate(left) if index not in set(done)]
        if not left:
            return
    for task in left:
        try:
            for _, rows in _parallel([task], meshes, max(workers, 2), dask):
                yield task, rows
        except TerminatedWorkerError:
            continue


def _parallel(
    tasks: list[Task], meshes: Mapping[str, Mesh], workers: int, dask: str | None
) -> Iterator[tuple[int, dict[str, pd.DataFrame]]]:
    calls = (delayed(_indexed)(index, meshes[task.mesh], task) for index, task in enumerate(tasks))
    with _backend(workers, dask):
        yield from Parallel(return_as="generator_unordered")(calls)


def _indexed(index: int, mesh: Mesh, task: Task) -> tuple[int, dict[str, pd.DataFrame]]:
    return index, run_task(mesh, task)


def _backend(workers: int, dask: str | None) -> AbstractContextManager[object]:
    if dask is not None:
        _connect(dask)
        return _config(backend="dask", n_jobs=-1)
    if workers == 1:
        return nullcontext()
    return _config(backend="loky", n_jobs=workers, inner_max_num_threads=1)


def _config(**options: object) -> AbstractContextManager[object]:
    config: AbstractContextManager[object] = parallel_config(**options)
    return config


def _connect(address: str) -> None:
    try:
        from distributed import Client
    except ImportError:
        raise Wm3dError("--dask needs the extra: pip install 'wm3d[dask]'.") from None
    try:
        Client(address, timeout="10s")
    except (OSError, TimeoutError, ValueError) as error:
        raise Wm3dError(f"--dask {address}: no scheduler answers there ({error}).") from None


def default_workers() -> int:
    """Return the number of processors that this machine offers."""
    return multiprocessing.cpu_count()
