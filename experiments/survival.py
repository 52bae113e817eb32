"""What runs survive: kills, dead workers, a cluster that loses one, full disks, a second run in their folder.

    python experiments/survival.py [--only dask]

Prints a line for each check, PASS, FAIL or SKIP, and exits with status 1 if one failed. Results are compared
byte by byte, figures included; timing.csv tells seconds and is left out. The attacks that misbehave are the
plug-in of the tests. Some ten minutes.
"""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from survival_tools import Bench, children, cluster, detection, running, stored, wait_for


def workers(bench: Bench) -> None:
    """Run on one, two and four local processes."""
    for count in ("2", "4"):
        out = bench.folder / f"workers-{count}"
        bench.run(bench.config, out, "--workers", count)
        bench.same(f"{count} workers", out)


def killed(bench: Bench) -> None:
    """Kill -9 at ten random moments and resume each time; in blocks of one trial, which change no number."""
    moments, out, counts = random.Random(2002), bench.folder / "killed", []
    options = ("--workers", "2", "--set", "block=1")
    for _ in range(10):
        with bench.started(*bench.command(bench.config, out, *options)) as process:
            before = stored(out)
            # some while it starts, most after it has stored something
            wait_for(lambda before=before: stored(out) > before, moments.choice([2, 120, 120]))
            time.sleep(moments.uniform(0, 1))
            its_workers = children(process.pid)
            counts.append("finished" if process.poll() is not None else stored(out))
            process.kill()
        if not wait_for(lambda pids=its_workers: not any(map(running, pids)), 10):
            bench.check("workers leave within 10 s of a killed run", False, its_workers)
    amid = "finished" not in counts and counts[-1] > 0
    bench.check("ten kills before the end", amid, f"cells after each: {counts}")
    done = bench.run(bench.config, out, *options)
    bench.check("resumed after ten kills", done.returncode == 0, done.stderr.splitlines()[0])
    bench.same("resumed after ten kills", out)


def two_runs(bench: Bench) -> None:
    """Start a second run in the directory of one that runs."""
    out = bench.folder / "two"
    with bench.started(*bench.command(bench.config, out, "--workers", "1")) as process:
        wait_for(lambda: stored(out) > 0, 60)
        second = bench.run(bench.config, out, "--workers", "1")
        told = second.returncode == 2 and "another run is writing here" in second.stderr
        bench.check("a second run in the directory is told", told, second.stderr.strip())
        process.wait()
    bench.same("the first run goes on", out)


def failing(bench: Bench) -> None:
    """Run an attack that raises in some trials."""
    out = bench.folder / "raising"
    done = bench.run(bench.write("raising", ", {name: raising, share: 0.5}"), out, "--workers", "2")
    failed = detection(out)["failed"]["raising share=0.5"]
    bench.check("an attack that raises: exit status 1", done.returncode == 1, done.stderr.splitlines()[-1])
    bench.check("an attack that raises: counted", 0 < failed < 24, f"{failed} of 24")
    bench.others_stand("an attack that raises", out)


def dying(bench: Bench, name: str = "local workers", *options: str) -> None:
    """Run attacks that kill their worker, once and always."""
    out = bench.folder / f"once {name}"
    config = bench.write("once", f", {{name: killing, once: '{bench.folder / name}'}}")
    done = bench.run(config, out, *(options or ("--workers", "2")))
    bench.check(f"{name}: killed once: retried", done.returncode == 0, f"exit status {done.returncode}")
    bench.others_stand(f"{name}: killed once", out)
    out = bench.folder / f"always {name}"
    shorter = ("--set", "trials=4", "--set", "unmarked=false", "--set", "false_alarm_trials=0")
    done = bench.run(
        bench.write("always", ", {name: killing}"), out, *(options or ("--workers", "2")), *shorter
    )
    said = [line for line in done.stderr.splitlines() if "killing" in line]
    bench.check(f"{name}: always killed: told", bool(said) and done.returncode == 1, "; ".join(said))
    lost = json.loads((out / "manifest.json").read_text())["lost_trials"]
    bench.check(f"{name}: always killed: counted", lost == 4, f"{lost} trials")
    trials = detection(out)["trials"]
    bench.check(f"{name}: always killed: the others stand", set(trials) == {4} and len(trials) == 4)


def disk(bench: Bench) -> None:
    """Fill a disk up, and forbid to write to it."""
    mount = bench.folder / "disk"
    mount.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=200k", "tmpfs", mount], check=False).returncode:
        print("SKIP  full and read-only disks: mounting a tmpfs is not permitted")
        return
    try:
        out = mount / "run"
        done = bench.run(bench.config, out, "--workers", "1")
        told = done.returncode == 2 and "cannot be written (No space left on device)." in done.stderr
        bench.check(
            "full disk: a sentence", told and "Traceback" not in done.stderr, done.stderr.splitlines()[-1]
        )
        before = stored(out)
        subprocess.run(["mount", "-o", "remount,ro", mount], check=True)
        done = bench.run(bench.config, out, "--workers", "1")
        told = done.returncode == 2 and "Read-only file system" in done.stderr
        bench.check("read-only folder: a sentence", told, done.stderr.splitlines()[-1])
        subprocess.run(["mount", "-o", "remount,rw,size=50m", mount], check=True)
        done = bench.run(bench.config, out, "--workers", "1")
        kept = before > 0 and f"{before} of" in done.stderr
        bench.check("full disk: what was stored is kept", kept, f"{before} cells")
        bench.same("full disk, then space", out)
    finally:
        subprocess.run(["umount", mount], check=True)


def dask(bench: Bench) -> None:
    """Run on a Dask cluster: undisturbed, with attacks that kill workers, losing a worker, losing all."""
    with cluster(bench) as (address, _):
        out = bench.folder / "dask"
        done = bench.run(bench.config, out, "--dask", address)
        bench.same("dask", out, f"exit status {done.returncode}")
        dying(bench, "dask", "--dask", address)
    with cluster(bench) as (address, nannies):
        out = bench.folder / "dask-loses-one"
        with bench.started(*bench.command(bench.config, out, "--dask", address)) as process:
            wait_for(lambda: stored(out) > 0, 120)
            for pid in (*children(nannies[0].pid), nannies[0].pid):
                os.kill(pid, signal.SIGKILL)
            at = stored(out)
            process.wait()
        bench.same("dask, one of two workers killed", out, f"after {at} of {stored(out)} cells")
    with cluster(bench, dict(os.environ)) as (address, _):
        done = bench.run(bench.config, bench.folder / "none", "--dask", address)
        told = done.returncode == 2 and "both need wm3d and its plug-ins" in done.stderr
        bench.check("a cluster without the plug-in: told", told, done.stderr.strip().splitlines()[-1])
    done = bench.run(bench.config, bench.folder / "none", "--dask", address)
    bench.check("no scheduler: told", done.returncode == 2, done.stderr.strip()[:100])


CHECKS = (workers, killed, two_runs, failing, dying, disk, dask)


def main() -> int:
    """Run the checks."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", choices=[check.__name__ for check in CHECKS], action="append")
    only = parser.parse_args().only
    folder = Path(tempfile.mkdtemp(prefix="wm3d-survival-"))
    bench = Bench(folder)
    try:
        for check in CHECKS:
            if not only or check.__name__ in only:
                check(bench)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    print(f"{bench.failures} failed")
    return min(bench.failures, 1)


if __name__ == "__main__":
    sys.exit(main())
