"""How much memory a step needs beyond what the process holds."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from wm3d.bench.allocator import give_back

T = TypeVar("T")

_OWN = Path("/proc/self")
_RESET_PEAK = "5"  # proc(5), clear_refs


def with_peak(step: Callable[[], T]) -> tuple[T, float]:
    """Return what a step returns, and how far memory rose above its level at the start, in MB of 10⁶ bytes.

    The peak that `resource.getrusage` tells is that of the whole life of a process, so after a costly attack
    it would be silent about the next embedding. Linux lets a process set its peak back; elsewhere the answer
    is NaN. What is free in the heap is given back first, as far as the C library does that.
    """
    give_back()
    try:
        (_OWN / "clear_refs").write_text(_RESET_PEAK)
        before = _peak()
    except (OSError, ValueError):
        return step(), float("nan")
    result = step()
    return result, max(_peak() - before, 0.0)


def _peak() -> float:
    for line in (_OWN / "status").read_text().splitlines():
        if line.startswith("VmHWM:"):
            return float(line.split()[1]) * 1024 / 1e6
    raise ValueError("no VmHWM in /proc/self/status")
