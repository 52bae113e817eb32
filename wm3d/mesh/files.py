"""Whole files or none: writing through a temporary name in the same folder."""

import os
import secrets
from pathlib import Path

from wm3d.errors import Wm3dError


def write_whole(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file so that other readers see the old content or the new one, never a part of it.

    Parameters
    ----------
    path : str or path
        Target; an existing file is replaced, a symbolic link keeps pointing where it points.
    content : bytes
        The whole content.

    Raises
    ------
    Wm3dError
        If the folder is missing or cannot be written to, if the target is a folder, or if the disk is full.
        The old file, if any, is then untouched and no partial file stays.
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise Wm3dError(f"{path}: is a folder; name a file to write to.")
    if not target.parent.is_dir():
        raise Wm3dError(f"{path}: the folder {target.parent} does not exist; create it first.")
    # not tempfile: its files are readable by their owner alone, and the mode survives the rename
    temporary = target.with_name(f".wm3d-{secrets.token_hex(6)}.tmp")
    try:
        with temporary.open("xb") as stream:
            stream.write(content)
        temporary.replace(target)
    except OSError as error:
        raise Wm3dError(f"{path}: cannot be written ({error.strerror}).") from error
    finally:
        temporary.unlink(missing_ok=True)
