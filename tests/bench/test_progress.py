"""Progress: plain lines where nobody watches, a bar on a terminal."""

import io

import pytest

from wm3d.bench import progress
from wm3d.bench.progress import duration, reporter


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def clock(monkeypatch):
    """Seconds that pass only when told."""
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_plain_lines_come_now_and_then_and_at_the_end(clock):
    stream = io.StringIO()
    with reporter(4, 40, stream) as shown:
        for seconds in (1, 10, 1, 8):
            clock[0] += seconds
            shown.advance(1, 10)
    assert stream.getvalue().splitlines() == [
        "2/4 cells, 1.8 trials/s, about 11 s left",
        "4/4 cells, 2.0 trials/s, done in 20 s",
    ]
    assert "\x1b" not in stream.getvalue()


def test_the_bar_shows_cells_rate_and_time_left(clock):
    stream = Terminal()
    with reporter(4, 40, stream) as shown:
        clock[0] += 20
        shown.advance(1, 10)
        clock[0] += 20
        shown.advance(3, 30)
    frames = stream.getvalue().split("\r")
    assert "0/4" in frames[0]
    assert "the first trials are running" in frames[0]
    assert "4/4" in frames[-1]
    assert "1.0 trials/s, done in 40 s" in frames[-1]
    assert frames[-1].endswith("\n\x1b[?25h")  # what comes next has a line of its own


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()], ids=["file", "terminal"])
def test_a_run_without_anything_to_do_shows_nothing(stream):
    with reporter(0, 0, stream):
        pass
    assert stream.getvalue() == ""


def test_the_time_left_runs_down_between_counts(clock):
    counter = progress._Counter(10, 100)
    clock[0] += 10
    counter.count(1, 10)
    assert counter.words() == "1.0 trials/s, about 2 min left"
    clock[0] += 30
    assert counter.words() == "1.0 trials/s, about 60 s left"


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.2, "1 s"), (89, "89 s"), (150, "2 min"), (5300, "88 min"), (5400, "1.5 h")]
)
def test_durations_are_said_as_people_do(seconds, words):
    assert duration(seconds) == words
