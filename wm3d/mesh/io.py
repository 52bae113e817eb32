"""Mesh files: `load_mesh` and `save_mesh`, which keep every vertex and face in its place.

`decode_mesh` and `encode_mesh` are the same between bytes and meshes.
"""

import logging
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from wm3d.errors import Wm3dError
from wm3d.mesh.files import write_whole
from wm3d.mesh.formats import READERS, WRITERS, Arrays
from wm3d.mesh.mesh import Mesh

#: File endings that `load_mesh` and `save_mesh` know, in order of preference.
ENDINGS = tuple(READERS)


def load_mesh(path: str | os.PathLike[str], name: str | None = None) -> Mesh:
    """Read a mesh from a PLY, OBJ, OFF, STL or GLB file.

    Vertices keep their number and order, also those that no face uses; triangles keep theirs. Polygons are
    split into fans of triangles, from a corner at which none folds over. The nodes of a GLB scene are moved
    to their place and appended. STL knows no shared vertices: a file of m faces gives 3 m vertices.

    Parameters
    ----------
    path : str or path
        File whose ending names its format.
    name : str, optional
        Name of the mesh; by default the file name without its ending.

    Returns
    -------
    Mesh
        Coordinates as float64, in the unit of the file.

    Raises
    ------
    Wm3dError
        If the file is missing, not readable, empty, of an unknown or another format, damaged or cut short, or
        if what it holds is not a `Mesh`: no faces, NaN or infinite coordinates, faces out of range.
    """
    # an unknown format is the better reason to give than a missing file
    _ending(path, hint="; wm3d.mesh.datasets.load reads datasets by name")
    return decode_mesh(_content(path), path, name)


def decode_mesh(content: bytes, path: str | os.PathLike[str], name: str | None = None) -> Mesh:
    """Return the mesh that `load_mesh` would read from a file of this content and path; errors alike."""
    title = Path(path).stem if name is None else name
    vertices, faces = _parsed(content, path, _ending(path))
    try:
        return Mesh(vertices, faces, name=title)
    except Wm3dError as error:
        raise Wm3dError(f"{path}{str(error).removeprefix(title)}") from error


def save_mesh(mesh: Mesh, path: str | os.PathLike[str]) -> None:
    """Write a mesh to a PLY, OBJ, OFF, STL or GLB file, whole or not at all.

    PLY (binary), OBJ and OFF give back every float64 coordinate, face and unused vertex. STL and GLB round to
    float32, and STL writes three vertices a face. The same mesh gives the same bytes.

    Parameters
    ----------
    mesh : Mesh
        What to write; its name is not written.
    path : str or path
        Target whose ending names the format; an existing file is replaced.

    Raises
    ------
    Wm3dError
        If `mesh` is no `Mesh`, the ending is unknown, the folder is missing or not writable, or float32
        would spoil the mesh.
    """
    write_whole(path, encode_mesh(mesh, path))


def encode_mesh(mesh: Mesh, path: str | os.PathLike[str]) -> bytes:
    """Return the content that `save_mesh` would write to a file of this path; errors alike."""
    if not isinstance(mesh, Mesh):
        raise Wm3dError(f"the mesh is a {type(mesh).__name__}, not a wm3d.Mesh; the order is mesh, path.")
    writer = WRITERS[_ending(path)]
    try:
        with _quiet():
            return writer(mesh)
    except ValueError as error:
        raise Wm3dError(f"{path}: cannot be written; {error}.") from error


def _ending(path: str | os.PathLike[str], hint: str = "") -> str:
    ending = Path(path).suffix.lower()
    if ending not in READERS:
        found = f"the ending {ending!r} is" if ending else "no ending, which is"
        hint = "" if ending else hint
        raise Wm3dError(f"{path}: {found} no mesh format wm3d knows; use one of {', '.join(ENDINGS)}{hint}.")
    return ending


def _content(path: str | os.PathLike[str]) -> bytes:
    try:
        content = Path(path).read_bytes()
    except FileNotFoundError as error:
        raise Wm3dError(f"{path}: no such file.") from error
    except IsADirectoryError as error:
        raise Wm3dError(f"{path}: is a folder, not a mesh file.") from error
    except PermissionError as error:
        raise Wm3dError(f"{path}: cannot be read; permission denied.") from error
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        raise Wm3dError(f"{path}: cannot be read; {getattr(error, 'strerror', error)}.") from error
    if not content:
        raise Wm3dError(f"{path}: is empty.")
    return content


def _parsed(content: bytes, path: str | os.PathLike[str], ending: str) -> Arrays:
    try:
        with _quiet():
            return READERS[ending](content)
    except Exception as error:  # damaged bytes make parsers fail in every way there is
        detail = f" ({error})" if isinstance(error, ValueError) else ""
        what = f"cannot be read as {ending[1:].upper()}"
        raise Wm3dError(f"{path}: {what}; it is damaged, cut short or of another format{detail}.") from error


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep trimesh's log and numpy's warnings from the user; a number numpy cannot parse is an error."""
    logger = logging.getLogger("trimesh")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.filterwarnings("error", message="string or file could not be read to its end")
            yield
    finally:
        logger.setLevel(level)
