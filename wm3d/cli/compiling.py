"""A word to who waits at a terminal while numba compiles the kernels, as it does once after installation."""

import sys
from functools import cache
from typing import Any

import typer


@cache  # one listener a process
def tell_of_compiling() -> None:
    """Say so on stderr, if it is a terminal, when a kernel is compiled: its cache has none."""
    if not sys.stderr.isatty():
        return
    from numba.core import event

    class Word(event.Listener):  # type: ignore[misc]  # numba has no types
        told = False

        def on_start(self, _event: Any) -> None:
            if not self.told:
                typer.echo("wm3d: compiling its kernels, as once after each installation ...", err=True)
            self.told = True

        def on_end(self, event: Any) -> None:
            pass

    event.register("numba:compile", Word())
