"""A small experiment that takes a second, and a plug-in whose attacks misbehave."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from shapes import blob

from wm3d.mesh import save_mesh

PLUGIN = Path(__file__).parent / "plugin"

CONFIG = """\
name: small
trials: 4
block: 2
wrong_keys: 3
cases:
  - meshes: [{mesh}]
    schemes:
      - name: song2002
        grid: [24, 24]
        region: [4, 0, 16, 24]
        alpha: 4.0
attacks:
  - name: clean
  - name: gaussian-noise
  - name: similarity
"""


@pytest.fixture(scope="session")
def blobs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with two meshes of 2562 vertices, one.ply and two.ply."""
    folder = tmp_path_factory.mktemp("blobs")
    for seed, name in ((1, "one"), (2, "two")):
        save_mesh(blob(seed=seed, subdivisions=4), folder / f"{name}.ply")
    return folder


@pytest.fixture(scope="session")
def small_config(blobs: Path) -> Path:
    """Config of four trials on one.ply, in two blocks, with three attacks."""
    path = blobs / "small.yaml"
    path.write_text(CONFIG.format(mesh=blobs / "one.ply"))
    return path


@pytest.fixture
def config(tmp_path: Path, small_config: Path) -> Callable[..., Path]:
    """Writer of the small config with lines added at its end, where the attacks are."""

    def write(*lines: str) -> Path:
        path = tmp_path / "small.yaml"
        path.write_text("".join([small_config.read_text(), *(f"{line}\n" for line in lines)]))
        return path

    return write


@pytest.fixture
def misbehaving(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Path to add to PYTHONPATH; the attacks `throwaway` can be imported, here and in workers."""
    monkeypatch.syspath_prepend(str(PLUGIN))
    yield str(PLUGIN)
    sys.modules.pop("throwaway", None)
