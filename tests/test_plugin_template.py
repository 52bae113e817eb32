"""The plug-in template, installed without a network: wm3d finds it, it keeps the contract, and it runs."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TEMPLATE = Path(__file__).parents[1] / "examples" / "wm3d-plugin"
WM3D = "import sys; from wm3d.cli import main; sys.exit(main())"
LISTS = "from wm3d.cli import main; main(['list', 'schemes']); main(['list', 'attacks'])"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder that holds the installed plug-in."""
    pytest.importorskip("pip", reason="needs pip in this environment")
    folder = tmp_path_factory.mktemp("plugin")
    shutil.copytree(TEMPLATE, folder / "source", ignore=shutil.ignore_patterns("*.egg-info", "build"))
    words = "-m pip install --quiet --no-index --no-deps --no-build-isolation --disable-pip-version-check"
    command = [sys.executable, *words.split(), "--target", str(folder / "site"), str(folder / "source")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / "site"


def run(installed: Path, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join(filter(None, [str(installed), os.environ.get("PYTHONPATH")]))
    environment = os.environ | {"PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def test_it_is_listed(installed, tmp_path):
    listed = run(installed, tmp_path, "-c", LISTS)
    names = [line.split()[0] for line in listed.stdout.splitlines()]
    assert {"song2002", "latitude-bands", "gaussian-noise", "dents"} <= set(names), listed.stderr


def test_it_passes_its_own_tests(installed, tmp_path):
    words = ("-m", "pytest", "-q", "-p", "no:cacheprovider", str(TEMPLATE / "tests"))
    tested = run(installed, tmp_path, *words)
    assert tested.returncode == 0, tested.stdout + tested.stderr


def test_it_runs_beside_the_built_in_ones(installed, tmp_path):
    words = ("run", str(TEMPLATE / "quick.yaml"), "--out", "out", "--workers", "1", "--set", "trials=2")
    done = run(installed, tmp_path, "-c", WM3D, *words)
    assert done.returncode == 0, done.stderr
    lines = (tmp_path / "out" / "tables" / "detection.csv").read_text().splitlines()
    head, *rows = (line.split(",") for line in lines)
    shown = {(row[head.index("scheme")], row[head.index("attack")]) for row in rows}
    assert ("latitude-bands", "dents 50 0.5") in shown
    assert len(shown) == 4
