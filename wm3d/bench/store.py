"""A run directory: the config as run, one parquet file a cell, tables, figures, manifest."""

import io
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from filelock import FileLock, Timeout

from wm3d.bench.columns import ADDED, TRIALS, TRY_AGAIN
from wm3d.errors import Wm3dError
from wm3d.mesh import write_whole

CELL_KEY = b"wm3d.cell"

TABLES = (
    *("leaderboard", "calibration"),
    *("detection", "snr", "axes", "nulls", "timing"),
    *("false_alarms", "roc_paper"),
)
FIGURES = ("roc", "heatmap", "quality", "false_alarms")
"""All tables and figures that a report may have; few have each."""


class RunDirectory:
    """The files of one run; every file appears whole or not at all.

    Attributes
    ----------
    path : Path
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)

    def create(self) -> None:
        """Make the folders.

        Raises
        ------
        Wm3dError
            If they cannot be made.
        """
        try:
            for folder in ("cells", "tables", "figures"):
                (self.path / folder).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise Wm3dError(f"{self.path}: cannot be used as run directory ({error.strerror}).") from None

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the directory for one run or report; the lock goes with the process, however that ends.

        Raises
        ------
        Wm3dError
            If another one holds it.
        """
        lock = FileLock(self.path / ".lock")
        try:
            lock.acquire(timeout=0)
        except Timeout:
            raise Wm3dError(
                f"{self.path}: another run or report is writing here; wait for it, or let `wm3d run` write "
                "to another --out."
            ) from None
        except OSError as error:
            raise Wm3dError(f"{self.path}: cannot be written to ({error.strerror}).") from None
        try:
            yield
        finally:
            lock.release()

    def begin(self, config: str) -> None:
        """Store the config as run; a manifest and a report that speak of another config go."""
        path = self.path / "config.yaml"
        if path.exists() and path.read_bytes() != config.encode():  # as bytes, for it may be damaged
            (self.path / "manifest.json").unlink(missing_ok=True)
            self.drop_report()
        self.write_text(path.name, config)

    def drop_report(self, keep: Collection[str] = ()) -> None:
        """Remove the files of a report, but those of these names; a user's own files stay."""
        for name in report_files(TABLES, FIGURES):
            if name not in keep:
                (self.path / name).unlink(missing_ok=True)

    def cell_path(self, digest: str) -> Path:
        """Return where the rows of a cell are kept."""
        return self.path / "cells" / f"{digest}.parquet"

    def write_cell(self, digest: str, rows: pd.DataFrame) -> None:
        """Store the rows of a cell, with page checksums and the digest inside, and whether to try again."""
        again = {TRY_AGAIN.encode(): b"yes"} if rows.attrs.get(TRY_AGAIN) else {}
        table = pa.Table.from_pandas(rows, preserve_index=False)
        table = table.replace_schema_metadata({CELL_KEY: digest.encode()} | again)
        buffer = io.BytesIO()
        pq.write_table(table, buffer, write_page_checksum=True)
        write_whole(self.cell_path(digest), buffer.getvalue())

    def read_cell(self, digest: str, columns: Mapping[str, str] = TRIALS) -> pd.DataFrame | None:
        """Return the rows of a cell, None if there are none yet.

        Parameters
        ----------
        digest : str
        columns : mapping of str to str
            Types of the columns, from `wm3d.bench.columns`.

        Raises
        ------
        DamagedCellError
            If the file is not what `write_cell` wrote.
        """
        path = self.cell_path(digest)
        if not path.exists():
            return None
        try:
            content = pa.BufferReader(path.read_bytes())  # its own reader wants UTF-8 in paths
            with pq.ParquetFile(content, page_checksum_verification=True) as file:
                table = file.read()
            metadata = table.schema.metadata or {}
            if metadata.get(CELL_KEY) != digest.encode():
                raise DamagedCellError(path, "it belongs to another cell")
            rows = _of_columns(table.to_pandas(), path, columns)
            rows.attrs = {TRY_AGAIN: True} if TRY_AGAIN.encode() in metadata else {}
            return rows
        except DamagedCellError:
            raise
        except Exception as error:  # there is no telling what noise leads a decoder to
            raise DamagedCellError(path, (str(error) or type(error).__name__).splitlines()[0]) from None

    def write_text(self, name: str, text: str) -> None:
        """Write a text file of the run directory."""
        write_whole(self.path / name, text.encode())

    def write_tables(self, tables: Mapping[str, pd.DataFrame]) -> None:
        """Write tables/NAME.csv; floats in the shortest form that reads back to the same bits."""
        for name, table in tables.items():
            self.write_text(f"tables/{name}.csv", table.to_csv(index=False, lineterminator="\n"))


def report_files(tables: Collection[str], figures: Iterable[str]) -> set[str]:
    """Return the names of the files of a report with these tables and figures."""
    return {
        "report.html",
        *(["leaderboard.json"] if "leaderboard" in tables else []),
        *(f"tables/{name}.csv" for name in tables),
        *(f"figures/{name}.{ending}" for name in figures for ending in ("png", "svg")),
    }


def _of_columns(rows: pd.DataFrame, path: Path, columns: Mapping[str, str]) -> pd.DataFrame:
    absent = columns.keys() - set(rows)
    if not absent <= ADDED or not set(rows) <= columns.keys():
        raise DamagedCellError(path, "its columns are others")
    if list(rows) != list(columns):
        rows = rows.assign(**dict.fromkeys(absent, float("nan")))[list(columns)]
    # converting all columns takes longer than reading them
    kinds = rows.dtypes
    other = {name: kind for name, kind in columns.items() if kinds[name] != kind}
    return rows.astype(other) if other else rows


class DamagedCellError(Wm3dError):
    """A cell file that cannot be trusted; it is computed again."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path}: is damaged ({reason}); `wm3d run` computes it again.")
