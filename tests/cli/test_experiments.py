"""`wm3d run` and `wm3d report`: how the command line reaches the bench, and what a failed trial does."""

import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from wm3d.bench import Outcome

Run = Callable[..., Any]


@pytest.mark.parametrize(("failed", "status"), [(0, 0), (3, 1)])
def test_run_hands_its_options_on_and_tells_failures(
    failed: int, status: int, wm3d: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []

    def run_config(path: Path, **options: object) -> Outcome:
        calls.append((path, options))
        return Outcome(Path("runs/tiny"), failed)

    monkeypatch.setattr("wm3d.bench.run_config", run_config)
    options = (
        "--out",
        "x",
        "--workers",
        "2",
        "--dask",
        "tcp://here",
        "--set",
        "trials=2",
        "--set",
        "a.0.b=c=d",
    )
    outcome = wm3d("run", "tiny.yaml", *options)
    assert calls == [
        (
            Path("tiny.yaml"),
            {
                "out": Path("x"),
                "workers": 2,
                "dask": "tcp://here",
                "overrides": ["trials=2", "a.0.b=c=d"],
                "dry_run": False,
            },
        )
    ]
    assert outcome.status == status
    assert outcome.stderr == (
        "wm3d: runs/tiny: 3 trials failed; report.html, under Faults, or a line above says why, and the same "
        "command tries them again unless wm3d refused the mesh.\n"
        if failed
        else ""
    )


@pytest.fixture
def own_handlers() -> Iterator[None]:
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell has what it runs aside ignore it
    yield
    for number, handler in handlers.items():
        signal.signal(number, handler)


@pytest.mark.usefixtures("own_handlers")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_stopped_says_what_is_kept(
    number: signal.Signals, wm3d: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wm3d.bench.run_config", lambda *_, **__: signal.raise_signal(number))
    outcome = wm3d("run", "tiny.yaml")
    assert outcome.status == 130
    assert "stopped; finished cells are kept, and the same command goes on" in outcome.stderr


def test_plan_run_and_report(wm3d: Run, files: Path, out: Path) -> None:
    config = out / "tiny.yaml"
    config.write_text(
        "name: tiny\ntrials: 2\nwrong_keys: 1\nattacks: [{name: clean}]\ncases:\n"
        f"  - meshes: ['{files / 'good.ply'}']\n"
        "    schemes: [{name: song2002, grid: [24, 24], region: [4, 0, 16, 24]}]\n"
    )
    arguments = ("run", config, "--out", out / "run", "--workers", "1")
    planned = wm3d(*arguments, "--dry-run")
    assert planned.status == 0
    assert not (out / "run").exists()
    done = wm3d(*arguments)
    assert done.status == 0
    tables = {file: file.read_bytes() for file in (out / "run" / "tables").iterdir()}
    assert tables
    for file in tables:
        file.unlink()
    outcome = wm3d("report", out / "run")
    assert outcome.status == 0
    assert Path(outcome.stdout.removesuffix("\n")).is_file()
    assert {file: file.read_bytes() for file in (out / "run" / "tables").iterdir()} == tables
