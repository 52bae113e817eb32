"""Work on two threads."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
from numba import config

from wm3d.arrays import FloatArray, IntArray

T = TypeVar("T")
Items = TypeVar("Items", FloatArray, IntArray)


def by_halves(kernel: Callable[[Items], T], items: Items) -> tuple[T, T]:
    """Return what a kernel makes of each half of some items; it gains as far as it does not hold the GIL.

    At a time where numba may use two threads. The numbers do not depend on that.
    """
    with ThreadPoolExecutor(min(2, config.NUMBA_NUM_THREADS)) as threads:
        one, other = threads.map(kernel, np.array_split(items, 2))
    return one, other
