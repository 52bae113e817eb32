"""The memory allocator of worker processes: memory that is freed stays in the process while a task runs."""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_VARIABLE = "GLIBC_TUNABLES"
KEEP_MEMORY = ":".join(
    [
        "glibc.malloc.hugetlb=1",  # ask for transparent huge pages
        "glibc.malloc.trim_threshold=4294967296",  # give nothing back below 4 GiB
        "glibc.malloc.mmap_threshold=33554432",  # no mapping of its own below 32 MiB, the most it takes
    ]
)
"""A trial makes and drops arrays of megabytes, and by default the C library gives each back to the system,
which clears every page anew. Fewer, larger pages also help the simplifiers, which walk memory at random."""


@contextmanager
def keeping_memory() -> Iterator[None]:
    """Start processes whose C library, where it is glibc, keeps memory; a setting of the user's stands.

    A Dask worker is started elsewhere: set ``GLIBC_TUNABLES`` to `KEEP_MEMORY` there for the same gain.
    """
    if _VARIABLE in os.environ:
        yield
        return
    os.environ[_VARIABLE] = KEEP_MEMORY  # read once, when a process starts
    try:
        yield
    finally:
        if os.environ.get(_VARIABLE) == KEEP_MEMORY:
            del os.environ[_VARIABLE]


def give_back() -> None:
    """Give all memory that is free in the heap back to the system; only glibc has a call for that."""
    with suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)
