"""Run directories: what is read is what was written, or it is said to be damaged; writes are whole or not."""

import errno
import os
import random
import resource
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from wm3d.bench.columns import ADDED, TRIALS
from wm3d.bench.store import DamagedCellError, RunDirectory
from wm3d.errors import Wm3dError

A, B = "a" * 20, "b" * 20


def rows(seed: int = 0, n: int = 20) -> pd.DataFrame:
    """Random rows, with NaN, infinities and words."""
    rng = np.random.default_rng(seed)
    values = {"str": lambda: rng.choice(["", "σ", "x y"], n), "int64": lambda: rng.integers(-9, 9, n)}
    values["float64"] = lambda: rng.choice([np.nan, np.inf, -0.0, 1e-320, rng.normal()], n)
    return pd.DataFrame({name: values[kind]() for name, kind in TRIALS.items()}).astype(TRIALS)


@pytest.fixture
def directory(tmp_path: Path) -> RunDirectory:
    directory = RunDirectory(tmp_path / "run")
    directory.create()
    directory.write_cell(A, rows())
    return directory


def test_rows_come_back_bit_for_bit(directory):
    pd.testing.assert_frame_equal(directory.read_cell(A), rows(), check_exact=True)
    assert directory.read_cell(B) is None


def test_a_folder_may_have_a_name_that_is_no_utf_8(directory):
    moved = directory.path.rename(directory.path.with_name(os.fsdecode(b"\xe9")))
    assert len(RunDirectory(moved).read_cell(A)) == len(rows())


def test_cells_of_earlier_versions_read_with_nan_for_what_they_lack(directory):
    directory.write_cell(B, rows().drop(columns=list(ADDED)))
    read = directory.read_cell(B)
    assert list(read) == list(TRIALS)
    assert read[list(ADDED)].isna().all(axis=None)
    directory.write_cell(A, rows().drop(columns="z"))
    assert "its columns are others" in damaged(directory)


def damaged(directory: RunDirectory) -> str:
    with pytest.raises(DamagedCellError) as raised:
        directory.read_cell(A)
    message = str(raised.value)
    assert message.startswith(f"{directory.cell_path(A)}: is damaged (")
    assert message.endswith("); `wm3d run` computes it again.")
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    "content", [b"", b"PAR1", random.Random(0).randbytes(5000)], ids=["empty", "stub", "noise"]
)
def test_a_file_of_something_else_is_damaged(directory, content):
    directory.cell_path(A).write_bytes(content)
    damaged(directory)


def test_every_truncation_is_noticed(directory):
    path, whole = directory.cell_path(A), directory.cell_path(A).read_bytes()
    for length in range(0, len(whole), 97):
        path.write_bytes(whole[:length])
        damaged(directory)


def test_no_flipped_bit_changes_a_row_unnoticed(directory):
    path, whole = directory.cell_path(A), directory.cell_path(A).read_bytes()
    for position in range(0, len(whole), 31):
        content = bytearray(whole)
        content[position] ^= 1 << position % 8
        path.write_bytes(content)
        try:
            read = directory.read_cell(A)
        except DamagedCellError:
            continue
        pd.testing.assert_frame_equal(read, rows(), check_exact=True)


def test_a_cell_in_the_place_of_another_is_noticed(directory):
    directory.write_cell(B, rows(1))
    directory.cell_path(B).replace(directory.cell_path(A))
    assert "it belongs to another cell" in damaged(directory)


def test_a_second_run_in_the_same_directory_is_told(directory):
    with (
        directory.locked(),
        pytest.raises(Wm3dError, match="another run or report is writing here; wait for it, or"),
        RunDirectory(directory.path).locked(),
    ):
        pass
    with directory.locked():  # and free again
        pass


def test_errors_of_the_run_are_not_taken_for_those_of_the_lock(directory):
    with pytest.raises(OSError, match="of the run"), directory.locked():
        raise OSError(errno.EIO, "of the run")


def test_a_full_disk_is_a_sentence_and_leaves_the_old_file(directory):
    # a limit on the size of files stands in for the disk
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = sorted(directory.path.rglob("*"))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        with pytest.raises(Wm3dError, match=rf"{A}.parquet: cannot be written \(File too large\)\.$"):
            directory.write_cell(A, rows(1))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    pd.testing.assert_frame_equal(directory.read_cell(A), rows())
    assert sorted(directory.path.rglob("*")) == before


def test_a_path_that_cannot_be_a_directory_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(Wm3dError, match=r"file: cannot be used as run directory"):
        RunDirectory(tmp_path / "file").create()


def test_another_config_drops_the_manifest_and_the_report(directory):
    made = [
        "manifest.json",
        "report.html",
        "leaderboard.json",
        "tables/calibration.csv",
        "figures/quality.svg",
    ]
    own = ["tables/mine.csv", "figures/mine.png", "notes.txt"]
    directory.begin("trials: 1\n")
    for name in made + own:
        directory.write_text(name, "")
    directory.begin("trials: 1\n")
    assert all((directory.path / name).exists() for name in made)
    directory.begin("trials: 2\n")
    assert not any((directory.path / name).exists() for name in made)
    assert all((directory.path / name).exists() for name in own)
    assert directory.read_cell(A) is not None
    assert (directory.path / "config.yaml").read_text() == "trials: 2\n"


def test_a_damaged_config_is_another_config(directory):
    (directory.path / "config.yaml").write_bytes("title: Größe\n".encode("latin-1"))
    directory.write_text("manifest.json", "{}")
    directory.begin("title: Größe\n")
    assert not (directory.path / "manifest.json").exists()
    assert (directory.path / "config.yaml").read_text(encoding="utf-8") == "title: Größe\n"


def test_tables_keep_every_bit_of_their_numbers(directory):
    numbers = [0.1 + 0.2, 1e-320, np.pi, -0.0, 1e300 / 3]
    directory.write_tables({"t": pd.DataFrame({"x": numbers})})
    lines = (directory.path / "tables" / "t.csv").read_text().splitlines()
    assert [float(line).hex() for line in lines[1:]] == [number.hex() for number in numbers]
