"""Running tasks on a Dask cluster.

Not by joblib's Dask backend: it waits forever for a task that the scheduler gave up because its workers died.
"""

from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pandas as pd

from wm3d.bench.plan import Task
from wm3d.bench.worker import work
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

if TYPE_CHECKING:
    from distributed import Client, Future

PATIENCE = 60.0
"""Seconds without any worker after which a run gives up."""


@contextmanager
def on_cluster(
    meshes: Mapping[str, Mesh], address: str
) -> Iterator[Callable[[list[Task]], Iterator[tuple[Task, dict[str, pd.DataFrame]]]]]:
    """Connect to a Dask scheduler and yield what runs tasks there (`wm3d.bench.execute.Run`).

    The scheduler gives a task to another worker when one dies. A task that saw several of its workers die has
    no rows, nor has what happened to be in flight beside it.

    Raises
    ------
    Wm3dError
        If distributed is not installed, or no scheduler or no worker answers.
    """
    client = _client(address)
    import dask

    def run(tasks: list[Task]) -> Iterator[tuple[Task, dict[str, pd.DataFrame]]]:
        futures = {
            client.submit(work, {name: held[name] for name in task.meshes}, task, pure=False): task
            for task in tasks
        }
        try:
            for future in _finished(client, set(futures), address):
                task, rows = futures.pop(future), _rows(future, address)
                if rows is not None:
                    yield task, rows
        except CancelledError:
            raise Wm3dError(f"--dask {address}: the scheduler is gone; run again.") from None

    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError:
            raise Wm3dError(f"--dask {address}: the scheduler has no workers; start some.") from None
        # tasks, not scattered data: those the scheduler can make again when their worker dies
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1 GiB"}):
            held = {name: client.submit(_hold, mesh, pure=False) for name, mesh in meshes.items()}
        yield run


def _finished(client: "Client", left: "set[Future]", address: str) -> "Iterator[Future]":
    """Yield the futures, and forget them, as they are finished; for as long as the cluster has a worker."""
    from distributed import as_completed

    while left:
        try:
            for future in as_completed(list(left), loop=client.loop, timeout=PATIENCE):
                left.remove(future)
                yield future
        except TimeoutError:
            if not client.scheduler_info()["workers"]:
                raise Wm3dError(f"--dask {address}: no worker is left; start some and run again.") from None


def _rows(future: "Future", address: str) -> dict[str, pd.DataFrame] | None:
    """Return what a task made; None if its workers died."""
    from distributed import KilledWorker

    try:
        rows: dict[str, pd.DataFrame] = future.result()
    except KilledWorker:
        return None
    except (ImportError, RuntimeError) as error:
        if isinstance(error, RuntimeError) and "deserialization" not in str(error):
            raise
        raise Wm3dError(
            f"--dask {address}: the scheduler or a worker lacks a package that is installed here; both need "
            "wm3d and its plug-ins."
        ) from error
    return rows


def check_scheduler(address: str) -> None:
    """Raise Wm3dError unless a Dask scheduler answers at an address."""
    _client(address).close()


def _client(address: str) -> "Client":
    try:
        from distributed import Client
    except ImportError:
        raise Wm3dError("--dask needs Dask: pip install 'dask[distributed]'.") from None
    if ":" not in address:  # of which a client leaves a traceback
        raise Wm3dError(f"--dask {address}: is no address of a scheduler, such as tcp://127.0.0.1:8786.")
    try:
        return Client(address, timeout="10s", set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise Wm3dError(f"--dask {address}: no scheduler answers there ({error}).") from None


def _hold(mesh: Mesh) -> Mesh:
    return mesh
