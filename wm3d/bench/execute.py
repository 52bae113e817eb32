"""Running tasks in this process, on local processes or on a Dask cluster; results come in any order."""

import os
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import AbstractContextManager, closing, nullcontext

import joblib
import pandas as pd
from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.process_executor import TerminatedWorkerError

from wm3d.bench.allocator import keeping_memory
from wm3d.bench.plan import Task
from wm3d.bench.trial import lost_rows
from wm3d.bench.worker import leave_with_parent, work
from wm3d.mesh import Mesh

Result = tuple[Task, dict[str, pd.DataFrame]]

Run = Callable[[list[Task]], Iterator[Result]]
"""Yields each task with the rows that could be made; none of those tasks that were being worked on when a
worker died."""


def execute(
    tasks: list[Task], meshes: Mapping[str, Mesh], workers: int, dask: str | None
) -> Iterator[Result]:
    """Yield each task with its rows by cell digest, as they are finished.

    A worker that is killed (by the system when memory runs out, say) costs no more than the tasks in flight;
    one that is told in time that memory has run out, no more than that cell. These cells are run again, first
    together, then each on its own. A cell that fails even then has the rows that `lost_rows` makes.

    Parameters
    ----------
    tasks : list of Task
    meshes : mapping of str to Mesh
    workers : int
        Local processes; 1 runs everything in this process.
    dask : str or None
        Address of a Dask scheduler to use instead.

    Raises
    ------
    Wm3dError
        If the cluster cannot be used, or a worker runs other versions of the engines.
    """
    with _pool(meshes, workers, dask) as run:
        left = yield from _tried(run, tasks)
        left = yield from _tried(run, [part for task in left for part in task.split()])
        for task in left:
            for lost in (yield from _tried(run, [task])):
                yield lost, {cell.digest: lost_rows(cell) for cell in lost.cells}


def _tried(run: Run, tasks: list[Task]) -> Generator[Result, None, list[Task]]:
    """Yield what could be made of each task; return tasks of the cells that could not."""
    made: set[str] = set()
    for task, rows in run(tasks):
        if rows:
            yield Task(tuple(cell for cell in task.cells if cell.digest in rows)), rows
        made |= rows.keys()
    rests = [tuple(cell for cell in task.cells if cell.digest not in made) for task in tasks]
    return [Task(rest) for rest in rests if rest]


def _pool(meshes: Mapping[str, Mesh], workers: int, dask: str | None) -> AbstractContextManager[Run]:
    if dask is not None:
        from wm3d.bench.cluster import on_cluster

        return on_cluster(meshes, dask)
    return nullcontext(_in_this_process(meshes) if workers == 1 else _on_processes(meshes, workers))


def _in_this_process(meshes: Mapping[str, Mesh]) -> Run:
    def run(tasks: list[Task]) -> Iterator[Result]:
        for task in tasks:
            yield task, work(_needed(task, meshes), task)

    return run


def _on_processes(meshes: Mapping[str, Mesh], workers: int) -> Run:
    def run(tasks: list[Task]) -> Iterator[Result]:
        left = dict(enumerate(tasks))
        while left:
            started: set[int] = set()

            def calls(left: dict[int, Task], started: set[int]) -> Iterator[object]:
                for index, task in list(left.items()):
                    started.add(index)
                    yield delayed(_numbered)(index, _needed(task, meshes), task)

            with parallel_config(
                backend="loky",
                n_jobs=min(workers, max(2, len(left))),  # one would be this process
                inner_max_num_threads=1,
                initializer=leave_with_parent,
                initargs=(os.getpid(),),
            ):
                # no calls ahead: those in flight are lost with a worker
                parallel = Parallel(return_as="generator_unordered", batch_size=1, pre_dispatch="n_jobs")
            try:
                with (
                    keeping_memory(),
                    warnings.catch_warnings(),
                    closing(parallel(calls(left, started))) as results,
                ):
                    # joblib replaces a worker that has grown, as by loading an engine, and finds that odd
                    warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")
                    # who stops early, as on a full disk, says why
                    warnings.filterwarnings("ignore", r"\d+ tasks .* You could benefit from adjusting")
                    for index, rows in results:
                        yield left.pop(index), rows
            except TerminatedWorkerError:
                for index in started & left.keys():
                    del left[index]

    return run


def _numbered(index: int, meshes: Mapping[str, Mesh], task: Task) -> tuple[int, dict[str, pd.DataFrame]]:
    return index, work(meshes, task)


def _needed(task: Task, meshes: Mapping[str, Mesh]) -> dict[str, Mesh]:
    return {name: meshes[name] for name in sorted(task.meshes)}


def default_workers() -> int:
    """Return the number of processors that this process may use."""
    return int(joblib.cpu_count())
