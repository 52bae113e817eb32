"""Memory of a step: what it needed at its peak, whatever came before it."""

import subprocess
import sys

import numpy as np
import pytest

from wm3d.bench.allocator import keeping_memory
from wm3d.bench.memory import with_peak

MEGABYTE = 125_000  # float64

AFTER_LARGER = f"""
import numpy as np
from wm3d.bench.memory import with_peak
fill = lambda count: [np.ones({MEGABYTE}) for _ in range(count)]
fill(200)
print(with_peak(lambda: len(fill(40)))[1])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lets a process set its peak back")
def test_peak_is_that_of_the_step_alone():
    total, large = with_peak(lambda: np.ones(200 * MEGABYTE).sum())
    assert total == 200 * MEGABYTE
    assert large == pytest.approx(200, abs=10)
    _, small = with_peak(lambda: np.ones(40 * MEGABYTE).sum())
    assert small == pytest.approx(40, abs=10)  # not hidden by the larger step before


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lets a process set its peak back")
def test_a_worker_that_keeps_memory_still_tells_what_a_step_needs():
    with keeping_memory():
        done = subprocess.run(
            [sys.executable, "-c", AFTER_LARGER], capture_output=True, text=True, check=True
        )
    assert float(done.stdout) == pytest.approx(40, abs=10)
