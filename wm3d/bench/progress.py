"""Progress that a person can use: a bar on a terminal, plain lines elsewhere."""

import sys
import time
from typing import Protocol, Self, TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn
from rich.text import Text

PLAIN_INTERVAL = 10.0
"""Seconds between two plain lines."""


class Reporter(Protocol):
    """Receives what a run has done."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *exc: object) -> None: ...

    def advance(self, cells: int, trials: int) -> None:
        """Count finished cells and trials."""


def reporter(cells: int, trials: int, stream: TextIO | None = None) -> Reporter:
    """Return a reporter for a run of so many cells and trials, on stderr unless told otherwise."""
    stream = stream or sys.stderr
    kind = _Bar if stream.isatty() and cells else _Lines
    return kind(_Counter(cells, trials), stream)


def duration(seconds: float) -> str:
    """Return seconds as people say them."""
    if seconds < 90:
        return f"{max(seconds, 1):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 90 * 60 else f"{seconds / 3600:.1f} h"


class _Counter:
    """What is done of what there is to do, and how long the rest will take."""

    def __init__(self, cells: int, trials: int) -> None:
        self.cells, self.trials = cells, trials
        self.cells_done = self.trials_done = 0
        self.start = self.counted = time.monotonic()

    def count(self, cells: int, trials: int) -> None:
        self.cells_done += cells
        self.trials_done += trials
        self.counted = time.monotonic()

    def words(self) -> str:
        """Return pace and time left; the time runs down until the next count."""
        if self.trials_done == 0:
            return "the first trials are running"
        taken = max(self.counted - self.start, 1e-9)
        rate = self.trials_done / taken
        pace = f"{rate:.{1 if rate >= 1 else 2}f} trials/s"
        if self.cells_done == self.cells:
            return f"{pace}, done in {duration(taken)}"
        left = (self.trials - self.trials_done) / rate - (time.monotonic() - self.counted)
        return f"{pace}, about {duration(left)} left"


class _Bar:
    def __init__(self, counter: _Counter, stream: TextIO) -> None:
        self._counter = counter
        self._progress = Progress(
            MofNCompleteColumn(),
            TextColumn("cells"),
            BarColumn(),
            _Words(counter),
            console=Console(file=stream),
        )
        self._task = self._progress.add_task("cells", total=counter.cells)

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._progress.stop()

    def advance(self, cells: int, trials: int) -> None:
        self._counter.count(cells, trials)
        self._progress.update(self._task, advance=cells)


class _Words(ProgressColumn):
    """The words of a counter, drawn again with the bar."""

    def __init__(self, counter: _Counter) -> None:
        super().__init__()
        self._counter = counter

    def render(self, task: object) -> Text:  # noqa: ARG002 (the counter knows more)
        return Text(self._counter.words())


class _Lines:
    def __init__(self, counter: _Counter, stream: TextIO) -> None:
        self._counter, self._stream, self._shown = counter, stream, counter.start

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc: object) -> None:
        pass

    def advance(self, cells: int, trials: int) -> None:
        counter = self._counter
        counter.count(cells, trials)
        if counter.cells_done == counter.cells or counter.counted - self._shown >= PLAIN_INTERVAL:
            self._shown = counter.counted
            print(
                f"{counter.cells_done}/{counter.cells} cells, {counter.words()}",
                file=self._stream,
                flush=True,
            )
