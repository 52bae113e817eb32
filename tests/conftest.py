"""Fixtures that many tests share: the bundled bunny and the real meshes of WM3D_DATA."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: a thread for each worker of the tests

from collections.abc import Callable
from pathlib import Path

import pytest

from wm3d.mesh import Mesh, load_mesh
from wm3d.mesh.catalog import DATASETS


@pytest.fixture(scope="session")
def bunny() -> Mesh:
    """Closed bunny of the pymeshlab wheel: 28088 vertices, 56172 faces."""
    # not by datasets.load: a bunny in WM3D_DATA would win
    return load_mesh(DATASETS["bunny"].source.path(), name="bunny")


@pytest.fixture(scope="session")
def data_mesh() -> Callable[[str], Mesh]:
    """Loader of real meshes by file stem; the test skips where WM3D_DATA does not hold the file."""
    folder = os.environ.get("WM3D_DATA")

    def load(name: str) -> Mesh:
        if not folder:
            pytest.skip(f"needs the mesh {name}: WM3D_DATA is not set")
        path = Path(folder) / f"{name}.ply"
        if not path.is_file():
            pytest.skip(f"needs the mesh {name}: WM3D_DATA holds no {path.name}")
        return load_mesh(path)

    return load
