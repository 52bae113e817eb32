"""Work on two threads, as far as it does not hold the GIL."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
from numba import config

from wm3d.arrays import FloatArray, IntArray

T = TypeVar("T")
Items = TypeVar("Items", FloatArray, IntArray)


def two_threads() -> ThreadPoolExecutor:
    """Return two threads, or one where numba may use one, as in a worker; no number may depend on that."""
    return ThreadPoolExecutor(min(2, int(config.NUMBA_NUM_THREADS)))


def by_halves(kernel: Callable[[Items], T], items: Items) -> tuple[T, T]:
    """Return what a kernel makes of each half of some items, on `two_threads`."""
    with two_threads() as threads:
        one, other = threads.map(kernel, np.array_split(items, 2))
    return one, other
