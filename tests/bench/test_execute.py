"""Workers: deaths cost no more than the cell that causes them; other versions are refused."""

import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import pytest
from joblib import parallel_config
from shapes import blob

from wm3d import component as component_module
from wm3d.attacks import Clean, Simplify
from wm3d.bench import execute as execute_module
from wm3d.bench.columns import LOST, TRY_AGAIN
from wm3d.bench.execute import execute
from wm3d.bench.plan import Task, TrialCell
from wm3d.bench.worker import work
from wm3d.errors import Wm3dError
from wm3d.schemes import Song2002

MESHES = {"one": blob(seed=1, subdivisions=4)}
SCHEME = Song2002(grid=(24, 24), region=(4, 0, 16, 24), alpha=4.0)


def task(*attacks, start=0) -> Task:
    digest = MESHES["one"].digest()
    return Task(
        tuple(TrialCell(7, "one", digest, SCHEME, attack, start, start + 1, "H1") for attack in attacks)
    )


@pytest.mark.usefixtures("misbehaving")
def test_a_cell_that_kills_its_workers_is_lost_alone(tmp_path):
    from throwaway import Killing

    innocent, once, always = Clean(), Killing(once=str(tmp_path / "once")), Killing()
    given = [task(innocent, once), task(innocent, always, start=1), task(innocent, start=2)]
    found = {}
    for done, rows in execute(given, MESHES, workers=2, dask=None):
        assert [cell.digest for cell in done.cells] == list(rows)
        assert not found.keys() & rows.keys()
        found |= rows
    cells = {cell.digest: cell for each in given for cell in each.cells}
    assert found.keys() == cells.keys()
    for digest, rows in found.items():
        if cells[digest].attack == always:
            assert rows.attrs == {TRY_AGAIN: True, LOST: True}
            assert rows["error"].tolist() == ["its worker died or ran out of memory each time"]
            assert rows["log10_p"].isna().all()
        else:
            assert not rows.attrs
            assert (rows["log10_p"] < -3).all()


@pytest.mark.usefixtures("misbehaving")
@pytest.mark.parametrize("workers", [1, 2])
def test_a_cell_that_runs_out_of_memory_is_lost_alone(workers):
    from throwaway import Starving

    given = [task(Clean(), Starving(), Simplify()), task(Starving(), start=1), task(Clean(), start=2)]
    rows = {
        cell: rows[cell.digest]
        for done, rows in execute(given, MESHES, workers=workers, dask=None)
        for cell in done.cells
    }
    assert {cell.digest for cell in rows} == {cell.digest for each in given for cell in each.cells}
    lost = {cell for cell in rows if rows[cell].attrs.get(LOST)}
    assert lost == {cell for cell in rows if isinstance(cell.attack, Starving)}


@pytest.mark.parametrize("wait", [0, 1])
def test_who_stops_early_is_told_nothing_more(wait):
    results = execute([task(Clean(), start=start) for start in range(6)], MESHES, workers=2, dask=None)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        next(results)
        time.sleep(wait)  # other tasks may be done by then, or not
        results.close()
    assert [str(warning.message) for warning in told] == []


@pytest.mark.parametrize(("count", "started"), [(1, 2), (2, 2), (3, 3), (9, 5)])
def test_no_more_workers_are_started_than_there_are_tasks(count, started, monkeypatch):
    wanted = []

    def noted(**options: object) -> AbstractContextManager[object]:
        wanted.append(options["n_jobs"])
        return parallel_config(**options)

    def here(**_: object) -> Callable[..., Iterator[object]]:
        return lambda calls: (function(*given, **named) for function, given, named in calls)

    monkeypatch.setattr(execute_module, "parallel_config", noted)
    monkeypatch.setattr(execute_module, "Parallel", here)
    given = [task(Clean(), start=start) for start in range(count)]
    assert len(list(execute(given, MESHES, workers=5, dask=None))) == count
    assert wanted == [started]  # a task alone must not run here, where it may end this process


def test_a_worker_with_other_engines_is_refused(monkeypatch):
    planned = task(Simplify())
    (cell,) = planned.cells
    assert len(cell.digest) == 20  # names the versions of here and now
    monkeypatch.setattr(component_module, "version", lambda _: "0.0")
    with pytest.raises(Wm3dError, match=r"a worker runs other versions .*'fast-simplification': '0\.0'"):
        work(MESHES, planned)


@pytest.mark.skipif(os.name != "posix", reason="only POSIX tells a process that its parent is gone")
def test_workers_leave_with_a_parent_that_is_killed(tmp_path):
    program = f"""
import os, sys, threading, time
from wm3d.bench.worker import leave_with_parent
parent = os.getpid()
if os.fork() == 0:
    leave_with_parent(parent)
    open({str(tmp_path / "child")!r}, "w").write(str(os.getpid()))
    time.sleep(60)
time.sleep(60)
"""
    with subprocess.Popen([sys.executable, "-c", program]) as parent:
        while not (tmp_path / "child").exists() or not (tmp_path / "child").read_text():
            assert parent.poll() is None
            time.sleep(0.05)
        parent.kill()
    child = int((tmp_path / "child").read_text())
    for _ in range(200):  # it looks once a second
        if not alive(child):
            return
        time.sleep(0.05)
    pytest.fail("the worker lives on")


def alive(pid: int) -> bool:
    """Whether a process runs; one that waits for somebody to collect it does not."""
    state = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False)
    return state.stdout[:1] not in ("", "Z")


def test_an_unknown_cluster_is_told():
    pytest.importorskip("distributed")
    with pytest.raises(Wm3dError, match=r"^--dask tcp://127.0.0.1:1: no scheduler answers there"):
        list(execute([task(Clean())], MESHES, workers=1, dask="tcp://127.0.0.1:1"))
    with pytest.raises(Wm3dError, match=r"^--dask nonsense: is no address of a scheduler"):
        list(execute([task(Clean())], MESHES, workers=1, dask="nonsense"))
