"""Who waits at a terminal is told when kernels are compiled, and nobody else."""

import sys
from collections import defaultdict

import pytest
from numba import njit

from wm3d.cli.compiling import tell_of_compiling


@pytest.mark.parametrize(("terminal", "words"), [(True, 1), (False, 0)])
def test_first_kernel_that_is_compiled_is_told_once_and_only_at_a_terminal(
    terminal: bool, words: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    monkeypatch.setattr("numba.core.event._registered", defaultdict(list))
    tell_of_compiling.cache_clear()
    for kernel in (njit(lambda x: x + 1), njit(lambda x: x + 2)):
        tell_of_compiling()
        kernel(1)
    tell_of_compiling.cache_clear()
    assert capsys.readouterr().err.count("compiling its kernels") == words
