"""The command itself: its helps, and that nothing heavy is imported for them."""

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

import wm3d as library
from wm3d.api import DEFAULT_SCHEME, PAPER_SCHEME
from wm3d.scanner.scan import DEFAULT_GRID
from wm3d.stats import DEFAULT_PF

Run = Callable[..., Any]


def test_help_loads_nothing_heavy() -> None:
    script = (
        "import sys; from wm3d.cli import main; main(['--help'])\n"
        "heavy = {'numba', 'numpy', 'scipy', 'trimesh', 'pandas', 'matplotlib', 'pydantic'}\n"
        "sys.stderr.write(' '.join(heavy & sys.modules.keys()))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "Usage: wm3d" in done.stdout


@pytest.mark.parametrize("arguments", [(), ("--help",), ("-h",)])
def test_alone_it_prints_its_help(arguments: tuple[str, ...], wm3d: Run) -> None:
    outcome = wm3d(*arguments)
    assert outcome.status == 0
    for command in ("run", "report", "embed", "detect", "attack", "scan", "list", "data"):
        assert f"\n  {command} " in outcome.stdout


@pytest.mark.parametrize(
    ("command", "default"),
    [
        ("embed", f"({DEFAULT_SCHEME}; {PAPER_SCHEME} with a grid, a region, miss= or normalize=)"),
        ("detect", f"{DEFAULT_PF:g}"),
        ("scan", "{}x{}".format(*DEFAULT_GRID)),
        ("scan", "vertex-pca"),
    ],
)
def test_helps_show_the_defaults_of_the_library(command: str, default: str, wm3d: Run) -> None:
    assert f"[default: {default}]" in " ".join(wm3d(command, "--help").stdout.split())


def test_version(wm3d: Run) -> None:
    assert wm3d("--version").stdout.startswith("wm3d 0.")


def test_every_public_name_is_there() -> None:
    assert dir(library) == library.__all__
    for name in library.__all__:
        assert getattr(library, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'embedd'"):
        library.embedd  # noqa: B018 (the access is the test)
