"""Progress that a person can use: a bar on a terminal, plain lines elsewhere."""

import sys
import time
from typing import Protocol, Self, TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

PLAIN_INTERVAL = 10.0
"""Seconds between two plain lines."""


class Reporter(Protocol):
    """Receives what a run has done."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *exc: object) -> None: ...

    def advance(self, cells: int, trials: int) -> None:
        """Count finished cells and trials."""

    def note(self, text: str) -> None:
        """Show a sentence without disturbing the bar."""


def reporter(cells: int, trials: int, stream: TextIO | None = None) -> Reporter:
    """Return a reporter for a run of so many cells and trials, on stderr unless told otherwise."""
    stream = stream or sys.stderr
    return _Bar(cells, trials, stream) if stream.isatty() else _Lines(cells, trials, stream)


class _Counter:
    def __init__(self, cells: int, trials: int) -> None:
        self.cells, self.trials = cells, trials
        self.cells_done = self.trials_done = 0
        self.start = time.monotonic()

    def count(self, cells: int, trials: int) -> None:
        self.cells_done += cells
        self.trials_done += trials

    @property
    def rate(self) -> float:
        return self.trials_done / max(time.monotonic() - self.start, 1e-9)


class _Bar(_Counter):
    def __init__(self, cells: int, trials: int, stream: TextIO) -> None:
        super().__init__(cells, trials)
        self._progress = Progress(
            TextColumn("cells"),
            MofNCompleteColumn(),
            BarColumn(),
            TextColumn("{task.fields[rate]:.0f} trials/s"),
            TimeRemainingColumn(),
            console=Console(file=stream),
        )
        self._task = self._progress.add_task("cells", total=cells, rate=0.0)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._progress.stop()

    def advance(self, cells: int, trials: int) -> None:
        self.count(cells, trials)
        self._progress.update(self._task, advance=cells, rate=self.rate)

    def note(self, text: str) -> None:
        self._progress.console.print(text, markup=False, highlight=False)


class _Lines(_Counter):
    def __init__(self, cells: int, trials: int, stream: TextIO) -> None:
        super().__init__(cells, trials)
        self._stream, self._shown = stream, self.start

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        pass

    def advance(self, cells: int, trials: int) -> None:
        self.count(cells, trials)
        now, finished = time.monotonic(), self.cells_done == self.cells
        if finished or now - self._shown >= PLAIN_INTERVAL:
            self._shown = now
            left = (self.trials - self.trials_done) / self.rate if self.rate > 0 else float("nan")
            self.note(
                f"{self.cells_done}/{self.cells} cells, {self.rate:.1f} trials/s, "
                + ("done" if finished else f"about {left:.0f} s left")
            )

    def note(self, text: str) -> None:
        print(text, file=self._stream, flush=True)
