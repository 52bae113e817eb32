"""Tools of survival.py: runs in processes of their own, their results, a Dask cluster on this machine."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pandas as pd

WM3D = Path(sys.executable).with_name("wm3d")
DASK = Path(sys.executable).with_name("dask")
PLUGIN = Path(__file__).resolve().parent.parent / "tests" / "bench" / "plugin"
ENVIRONMENT = os.environ | {"PYTHONPATH": str(PLUGIN)}

ATTACKS = "[{name: clean}, {name: gaussian-noise}, {name: simplify}, {name: sleeping, seconds: 0.05}%s]"
CONFIG = """\
name: survival
trials: 24
block: 2
wrong_keys: 5
unmarked: true
false_alarm_trials: 1000000
cases:
  - meshes: [bunny]
    schemes: [{name: song2002, grid: [168, 168], region: [4, 0, 160, 160]}]
attacks: %s
"""
"""A key of 25200 signs: long enough that BLAS would use all its threads."""


class Bench:
    """A folder to work in, the verdicts so far, and the run that others are held against."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.failures = 0
        self.config = self.write("survival", "")

    def write(self, name: str, more: str) -> Path:
        """Write a config with more attacks."""
        path = self.folder / f"{name}.yaml"
        path.write_text(CONFIG % (ATTACKS % more))
        return path

    def command(self, config: Path, out: Path, *options: str) -> list[str]:
        """Return what is typed to run a config."""
        return [str(WM3D), "run", str(config), "--out", str(out), *options]

    def run(self, config: Path, out: Path, *options: str) -> subprocess.CompletedProcess[str]:
        """Run a config to its end."""
        command = self.command(config, out, *options)
        return subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, check=False)

    @contextmanager
    def started(self, *command: str) -> Iterator[subprocess.Popen[str]]:
        """Start a process, and end it at the latest when the block ends."""
        with subprocess.Popen(
            command, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        ) as process:
            try:
                yield process
            finally:
                process.kill()

    def check(self, what: str, passed: bool, detail: object = "") -> None:
        """Print a verdict and count it."""
        self.failures += not passed
        print(f"{'PASS' if passed else 'FAIL'}  {what}{f'  ({detail})' if detail else ''}", flush=True)

    def same(self, what: str, out: Path, detail: object = "") -> None:
        """Check that a run gave the bytes of the undisturbed one."""
        expected, found = results(self.reference), results(out)
        differing = sorted(name for name in expected | found if expected.get(name) != found.get(name))
        self.check(f"{what}: same bytes", not differing, ", ".join(differing) or detail)

    @property
    def reference(self) -> Path:
        """Directory of the undisturbed run."""
        out = self.folder / "reference"
        if not out.exists():
            done = self.run(self.config, out, "--workers", "1")
            self.check("undisturbed run, one worker", done.returncode == 0, done.stderr.splitlines()[-1])
        return out

    def others_stand(self, what: str, out: Path) -> None:
        """Check that the attacks of the undisturbed run have its lines in the detection table."""
        ours, theirs = detection(out), detection(self.reference)
        self.check(
            f"{what}: other attacks as if it had not been there", ours.loc[theirs.index].equals(theirs)
        )


def results(out: Path) -> dict[str, bytes]:
    files = [file for folder in ("tables", "figures") for file in (out / folder).glob("*")]
    return {file.name: file.read_bytes() for file in files if file.name != "timing.csv"}


def detection(out: Path) -> pd.DataFrame:
    return pd.read_csv(out / "tables" / "detection.csv").set_index("attack")


def stored(out: Path) -> int:
    return len(list((out / "cells").glob("*.parquet")))


def wait_for(condition: Callable[[], object], seconds: float) -> bool:
    """Wait until a condition holds; return whether it did in time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return bool(condition())


def children(pid: int) -> list[int]:
    listed = subprocess.run(
        ["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True, check=False
    )
    return [int(word) for word in listed.stdout.split()]


def running(pid: int) -> bool:
    state = subprocess.run(["ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False)
    return state.stdout[:1] not in ("", "Z")


@contextmanager
def cluster(
    bench: Bench, environment: dict[str, str] = ENVIRONMENT
) -> Iterator[tuple[str, list[subprocess.Popen[str]]]]:
    """Start a scheduler and two workers of one thread; yield its address and the workers' nannies."""
    contact = Path(tempfile.mkdtemp(dir=bench.folder)) / "scheduler.json"
    scheduler = (
        DASK,
        "scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--no-dashboard",
        "--scheduler-file",
        contact,
    )
    worker = (DASK, "worker", "--scheduler-file", contact, "--nthreads", "1", "--no-dashboard")
    with tempfile.TemporaryFile() as log:
        processes = [subprocess.Popen(scheduler, env=environment, stderr=log, text=True)]
        try:
            wait_for(contact.exists, 60)
            for _ in range(2):
                processes.append(subprocess.Popen(worker, env=environment, stderr=log, text=True))
            yield json.loads(contact.read_text())["address"], processes[1:]
        finally:
            for process in reversed(processes):
                process.terminate()
                process.wait()
