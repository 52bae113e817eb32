"""Memory of a step: what it needed at its peak, whatever came before it."""

import sys

import numpy as np
import pytest

from wm3d.bench.memory import with_peak

MEGABYTE = 125_000  # float64


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lets a process set its peak back")
def test_peak_is_that_of_the_step_alone():
    total, large = with_peak(lambda: np.ones(200 * MEGABYTE).sum())
    assert total == 200 * MEGABYTE
    assert large == pytest.approx(200, abs=10)
    _, small = with_peak(lambda: np.ones(40 * MEGABYTE).sum())
    assert small == pytest.approx(40, abs=10)  # not hidden by the larger step before
