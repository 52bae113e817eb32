"""The allocator of workers: what is freed is used again, not fetched anew from the system."""

import os
import platform
import subprocess
import sys

import pytest

from wm3d.bench.allocator import KEEP_MEMORY, keeping_memory

PROGRAM = """
import resource
import numpy as np
faults = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_minflt
def trial(): return [np.ones(125_000) for _ in range(20)]  # 20 MB
trial()
before = faults()
for _ in range(20): trial()
print(faults() - before)
"""

GIVEN_BACK = """
from wm3d.bench.allocator import give_back
def megabytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() // 10**6
before = megabytes()
kept = [trial() for _ in range(5)]
del kept
print(megabytes() - before)
give_back()
print(megabytes() - before)
"""


def faults_of_a_new_process() -> int:
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    return int(done.stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another C library has other settings")
def test_memory_that_was_freed_is_used_again(monkeypatch):
    monkeypatch.delenv("GLIBC_TUNABLES", raising=False)
    fetched = faults_of_a_new_process()
    with keeping_memory():
        assert os.environ["GLIBC_TUNABLES"] == KEEP_MEMORY
        kept = faults_of_a_new_process()
    assert "GLIBC_TUNABLES" not in os.environ
    assert kept < fetched / 20


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another C library has no such call")
def test_memory_is_given_back_when_asked():
    program = PROGRAM.partition("trial()\nbefore")[0] + GIVEN_BACK
    with keeping_memory():
        grown, left = map(int, subprocess.check_output([sys.executable, "-c", program], text=True).split())
    assert grown > 90
    assert left < 10


def test_a_setting_of_the_user_stands(monkeypatch):
    monkeypatch.setenv("GLIBC_TUNABLES", "glibc.malloc.arena_max=1")
    with keeping_memory():
        assert os.environ["GLIBC_TUNABLES"] == "glibc.malloc.arena_max=1"
    assert os.environ["GLIBC_TUNABLES"] == "glibc.malloc.arena_max=1"
