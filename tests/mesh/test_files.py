"""Writing whole files: several at once or none, and never over a device."""

import os
from pathlib import Path

import pytest

from wm3d.errors import Wm3dError
from wm3d.mesh import Secret, check_target, write_together


def test_files_are_written_together(tmp_path: Path) -> None:
    write_together({tmp_path / "a": b"1", tmp_path / "b": b"2"})
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == {"a": b"1", "b": b"2"}


def test_a_missing_folder_stops_the_other_files_too(tmp_path: Path) -> None:
    with pytest.raises(Wm3dError, match="nowhere does not exist"):
        write_together({tmp_path / "a": b"1", tmp_path / "nowhere" / "b": b"2"})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("refused", ["a", "b", "c"])
def test_a_refused_rename_brings_every_file_back(
    refused: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "b").write_bytes(b"old")
    (tmp_path / "b").chmod(0o640)
    replace = Path.replace

    def guarded(self: Path, target: Path) -> Path:
        if target.name == refused and self.read_bytes() != b"old":
            raise PermissionError(1, "Operation not permitted")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", guarded)
    with pytest.raises(Wm3dError, match=rf"{refused}: cannot be written \(Operation not permitted\)"):
        write_together({tmp_path / name: b"new" for name in "abc"})
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == {"b": b"old"}
    assert os.name != "posix" or (tmp_path / "b").stat().st_mode & 0o777 == 0o640


@pytest.mark.skipif(os.name != "posix", reason="other systems have no such modes")
def test_secrets_are_for_their_owner_alone(tmp_path: Path) -> None:
    before = os.umask(0o022)
    try:
        write_together({tmp_path / "mesh": b"1", tmp_path / "key": Secret(b"2")})
    finally:
        os.umask(before)
    modes = {file.name: oct(file.stat().st_mode & 0o777) for file in tmp_path.iterdir()}
    assert modes == {"mesh": "0o644", "key": "0o600"}


def test_devices_are_not_replaced() -> None:
    # root could: the rename would leave a regular file in its place
    with pytest.raises(Wm3dError, match="is a device or a pipe"):
        check_target(os.devnull)
