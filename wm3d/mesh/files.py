"""Whole files or none: writing through temporary names in the same folders."""

import os
import secrets
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path

from wm3d.errors import Wm3dError

OWNER_ALONE, EVERYBODY = 0o600, 0o666
"""Modes of new files, of which the process's umask takes away."""


class Secret(bytes):
    """Content that only the owner of its file may read, where the system has such modes."""


def write_whole(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file so that other readers see the old content or the new one, never a part of it.

    Parameters
    ----------
    path : str or path
        Target; an existing file is replaced, a symbolic link keeps pointing where it points.
    content : bytes or Secret
        The whole content.

    Raises
    ------
    Wm3dError
        As `check_target`, and if the folder cannot be written to or the disk is full. The old file, if any,
        is then untouched and no partial file stays.
    """
    with _staged(path, content) as put_in_place:
        put_in_place()


def write_together(contents: Mapping[Path, bytes]) -> None:
    """Write several files, each as `write_whole` does, all of them or none.

    Raises
    ------
    Wm3dError
        As `write_whole`, for any of them. All files are then as they were.
    """
    with ExitStack() as stack:
        moves = {path: stack.enter_context(_staged(path, content)) for path, content in contents.items()}
        for path, put_in_place in moves.items():
            stack.enter_context(_restored_on_error(Path(os.path.realpath(path))))
            put_in_place()


def check_target(path: str | os.PathLike[str]) -> None:
    """Check what can be known of a file to be written before its content is made.

    Raises
    ------
    Wm3dError
        If the folder is missing, or the target is itself a folder, a device or a pipe.
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise Wm3dError(f"{path}: is a folder; name a file to write to.")
    if target.exists() and not target.is_file():
        raise Wm3dError(f"{path}: is a device or a pipe; name a file to write to.")
    if not target.parent.is_dir():
        problem = "is not a folder" if target.parent.exists() else "does not exist; create it first"
        raise Wm3dError(f"{path}: the folder {target.parent} {problem}.")


@contextmanager
def _staged(path: str | os.PathLike[str], content: bytes) -> Iterator[Callable[[], None]]:
    """Hold a content under a temporary name next to its target; the call that is yielded renames it."""
    check_target(path)
    target = Path(os.path.realpath(path))
    # not tempfile, which gives all its files one mode; it survives the rename
    temporary = target.with_name(f".wm3d-{secrets.token_hex(6)}.tmp")
    mode = OWNER_ALONE if isinstance(content, Secret) else EVERYBODY

    def put_in_place() -> None:
        with _blaming(path):
            temporary.replace(target)

    try:
        with _blaming(path), open(temporary, "xb", opener=partial(os.open, mode=mode)) as stream:
            stream.write(content)
        yield put_in_place
    finally:
        with suppress(OSError):  # of a file system that is read-only, of which the user has been told
            temporary.unlink(missing_ok=True)


@contextmanager
def _blaming(path: str | os.PathLike[str]) -> Iterator[None]:
    """Name the file, as the user named it, in what the operating system reports."""
    try:
        yield
    except OSError as error:
        raise Wm3dError(f"{path}: cannot be written ({error.strerror}).") from error


@contextmanager
def _restored_on_error(target: Path) -> Iterator[None]:
    """Bring a file back to what it was, or to its absence, if what follows fails."""
    old = (target.read_bytes(), stat.S_IMODE(target.stat().st_mode)) if target.exists() else None
    try:
        yield
    except BaseException:
        if old is None:
            target.unlink(missing_ok=True)
        else:
            content, mode = old
            write_whole(target, Secret(content))
            target.chmod(mode)
        raise
