"""The command line in-process, and a folder of good and bad files to give it."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from shapes import blob, icosphere

from wm3d.cli import main
from wm3d.mesh import save_mesh


@dataclass(frozen=True)
class Outcome:
    status: int
    stdout: str
    stderr: str


@pytest.fixture
def wm3d(capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """`wm3d ARGUMENT...`, in this process."""

    def run(*arguments: str | os.PathLike[str]) -> Outcome:
        capsys.readouterr()
        status = main([os.fspath(argument) for argument in arguments])
        return Outcome(status, *capsys.readouterr())

    return run


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a good mesh and its key, and files that are wrong in one way each."""
    folder = tmp_path_factory.mktemp("files")
    save_mesh(blob(subdivisions=4), folder / "good.ply")
    region = ("--grid", "24x24", "--region", "4,0,16,24")
    arguments = (
        "embed",
        folder / "good.ply",
        folder / "marked.ply",
        "--key",
        folder / "good.json",
        "--seed",
        "7",
    )
    assert main([str(argument) for argument in (*arguments, *region)]) == 0
    _write_bad_meshes(folder)
    _write_bad_keys(folder)
    return folder


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Folder that a command may write to; empty before it runs."""
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


def _write_bad_meshes(folder: Path) -> None:
    (folder / "empty.ply").write_bytes(b"")
    (folder / "text.ply").write_text("Dear reader, this is no mesh.\n")
    (folder / "text.obj").write_text("Dear reader, this is no mesh.\n")
    (folder / "mesh.xyz").write_text("0 0 0\n")
    (folder / "folder.ply").mkdir()
    whole = (folder / "good.ply").read_bytes()
    (folder / "cut.ply").write_bytes(whole[: len(whole) // 2])
    (folder / "cloud.off").write_text("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n")
    (folder / "nan.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n")
    (folder / "dangling.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n")
    (folder / "point.off").write_text("OFF\n3 1 0\n1 1 1\n1 1 1\n1 1 1\n3 0 1 2\n")
    (folder / "line.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n3 0 0\n3 0 1 2\n")
    (folder / "triangle.off").write_text("OFF\n3 1 0\n0 0 0\n3 0 0\n0 1 0\n3 0 1 2\n")
    save_mesh(icosphere(), folder / "sphere.ply")
    side = 9
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(side), np.arange(side)))
    corners = [row * side + column for row in range(side - 1) for column in range(side - 1)]
    faces = [f"3 {i} {i + 1} {i + side}\n3 {i + 1} {i + side + 1} {i + side}\n" for i in corners]
    # unequal steps, so that the sheet has axes of its own
    vertices = [f"{2 * (1.1**a)} {1.05**b} 0\n" for a, b in zip(x, y, strict=True)]
    (folder / "sheet.off").write_text(
        f"OFF\n{side**2} {2 * len(corners)} 0\n" + "".join(vertices) + "".join(faces)
    )


def _write_bad_keys(folder: Path) -> None:
    good = (folder / "good.json").read_text()
    changed = {
        "other-grid": ("24,\n      24", "24,\n      12"),
        "odd-region": ("16,\n", "15,\n"),
        "no-seed": ('"seed": 7', '"salt": 7'),
        "huge-seed": ('"seed": 7', f'"seed": {1 << 256}'),
        "text-seed": ('"seed": 7', '"seed": "seven"'),
        "unknown-scheme": ('"song2002"', '"song2003"'),
        "unknown-parameter": ('"alpha"', '"alhpa"'),
        "nan-alpha": ('"alpha": 1.3', '"alpha": NaN'),
        "unknown-detector": ('"ggd-lrt"', '"gdd-lrt"'),
        "other-format": ("wm3d-key-1", "wm3d-key-9"),
    }
    for name, (old, new) in changed.items():
        assert old in good
        (folder / f"{name}.json").write_text(good.replace(old, new))
    (folder / "text.json").write_text("Dear reader, this is no key.\n")
    (folder / "binary.json").write_bytes(b"\xff\xfe\x00key")
    (folder / "list.json").write_text("[1, 2]\n")
    (folder / "deep.json").write_text("[" * 100_000)
    (folder / "empty.json").write_text("")
    (folder / "folder.json").mkdir()
