"""Named meshes: how a name becomes a file and a mesh.

A name is looked up first in the folder that the environment variable WM3D_DATA names: any mesh file there
answers to its name without the ending, and wins over an entry of the registry with the same name. Downloads
and results of recipes are kept in the user's cache folder, or in the folder that WM3D_CACHE names.
"""

import os
from dataclasses import dataclass
from pathlib import Path

from wm3d.errors import Wm3dError, hint
from wm3d.mesh.catalog import DATASETS, Dataset
from wm3d.mesh.io import ENDINGS, load_mesh
from wm3d.mesh.mesh import Mesh
from wm3d.mesh.recipes import Recipe
from wm3d.mesh.sources import Bundled, Download

__all__ = [
    "DATASETS",
    "DatasetInfo",
    "cache_folder",
    "credit",
    "dataset_names",
    "describe",
    "fetch",
    "info",
    "load",
    "locate",
    "path",
    "resolve",
]


@dataclass(frozen=True)
class DatasetInfo:
    """A line of `wm3d data list`: name, origin, size where known, and whether it needs no network now."""

    name: str
    source: str
    vertices: int | None
    faces: int | None
    available: bool
    credit: str | None
    terms: str | None


def dataset_names() -> list[str]:
    """Return the names of the registry and of the mesh files in WM3D_DATA, sorted."""
    return sorted(DATASETS.keys() | _data_files().keys())


def fetch(name: str) -> Path:
    """Return the file of a dataset, downloading or computing it where it is not at hand.

    Parameters
    ----------
    name : str
        One of `dataset_names`.

    Raises
    ------
    Wm3dError
        If the name is unknown, or the download fails or has other bytes than expected.
    """
    return _file(name, download=True)


def path(name: str) -> Path:
    """Return the file of a dataset without using the network; a recipe is computed if a base is at hand.

    Raises
    ------
    Wm3dError
        If the name is unknown, or the file would have to be downloaded first.
    """
    return _file(name, download=False)


def load(name: str) -> Mesh:
    """Return a dataset as a mesh of that name, without using the network; errors as in `path`."""
    return load_mesh(path(name), name=name)


def resolve(name_or_path: str | os.PathLike[str]) -> Mesh:
    """Return the mesh that a config or a command line means: a dataset name, else the path of a mesh file.

    Raises
    ------
    Wm3dError
        If it is neither, with the nearest dataset name; and as in `load` and `load_mesh`.
    """
    text = os.fspath(name_or_path)
    return load_mesh(text) if _means_a_file(text) else load(text)


def locate(name_or_path: str | os.PathLike[str]) -> Path:
    """Return the file that `resolve` reads; one that a path means need not exist. Errors as in `path`."""
    text = os.fspath(name_or_path)
    return Path(text) if _means_a_file(text) else path(text)


def credit(name: str) -> str | None:
    """Return the credit line that a figure of this dataset must carry, or None.

    A file of WM3D_DATA named after an entry of the registry and a hyphen, such as bunny-closed, has its line.
    """
    entry = _entry(name)
    return entry.credit if entry else None


def describe(name: str) -> DatasetInfo:
    """Return what is known of a dataset; for a recipe with the base that it is, or would be, made from."""
    entry = _entry(name)
    owed = (entry.credit, entry.terms) if entry else (None, None)
    if file := _data_files().get(name):
        return DatasetInfo(name, str(file), None, None, True, *owed)
    if name not in DATASETS:
        raise Wm3dError(_unknown(name))
    source, at_hand = DATASETS[name].source, _at_hand(name)
    origin = f"{_base(source)}, {source.summary}" if isinstance(source, Recipe) else str(source)
    return DatasetInfo(name, origin, DATASETS[name].vertices, DATASETS[name].faces, at_hand, *owed)


def info() -> list[DatasetInfo]:
    """Return `describe` of each of `dataset_names`."""
    return [describe(name) for name in dataset_names()]


def cache_folder() -> Path:
    """Return the folder for downloads and results of recipes; it need not exist."""
    if chosen := os.environ.get("WM3D_CACHE"):
        return Path(chosen)
    import pooch

    return Path(pooch.os_cache("wm3d"))


def _means_a_file(text: str) -> bool:
    file = Path(text)
    looks_like_one = file.suffix.lower() in ENDINGS or len(file.parts) > 1 or file.exists()
    return looks_like_one and text not in dataset_names()


def _file(name: str, download: bool) -> Path:
    if name in (files := _data_files()):
        return files[name]
    if name not in DATASETS:
        raise Wm3dError(_unknown(name))
    source = DATASETS[name].source
    if isinstance(source, Bundled):
        return source.path()
    if isinstance(source, Recipe) and (download or _at_hand(name)):
        return source.cook(name, _file(_base(source), download), cache_folder())
    if isinstance(source, Download) and (download or _at_hand(name)):
        return source.fetch(name, cache_folder())
    raise Wm3dError(
        f"dataset {name}: is not on this machine; run `wm3d data fetch {name}`, or put {name}.ply into the "
        "folder that the environment variable WM3D_DATA names."
    )


def _at_hand(name: str) -> bool:
    """Tell whether a dataset needs no network."""
    if name in _data_files():
        return True
    if name not in DATASETS:
        return False
    source = DATASETS[name].source
    if isinstance(source, Bundled):
        return source.find() is not None
    if isinstance(source, Recipe):
        return any(map(_at_hand, source.bases))
    return source.target(name, cache_folder()).is_file()


def _data_files() -> dict[str, Path]:
    """Mesh files in WM3D_DATA by their stem; of one stem with several endings the first in `ENDINGS` wins."""
    folder = os.environ.get("WM3D_DATA")
    if not folder:
        return {}
    if not Path(folder).is_dir():
        raise Wm3dError(f"WM3D_DATA: {folder} is not a folder; correct or unset the environment variable.")
    files = [file for file in Path(folder).iterdir() if file.suffix.lower() in ENDINGS and file.is_file()]
    files.sort(key=lambda file: (ENDINGS.index(file.suffix.lower()), file.name), reverse=True)
    return {file.stem: file for file in files}


def _entry(name: str) -> Dataset | None:
    """Entry of the registry that a name, or the part of it before a hyphen, stands for."""
    roots = [root for root in DATASETS if name == root or name.startswith(f"{root}-")]
    return DATASETS[max(roots, key=len)] if roots else None


def _base(recipe: Recipe) -> str:
    return next(filter(_at_hand, recipe.bases), recipe.bases[0])


def _unknown(name: str) -> str:
    if Path(name).suffix.lower() in ENDINGS:
        return f"{name}: names a file, not a mesh of `wm3d data list`; wm3d.load_mesh reads files."
    return (
        f"unknown mesh {name!r}: neither a dataset nor a mesh file, nor in a folder that the environment "
        f"variable WM3D_DATA names; {hint(name, dataset_names())}"
    )
