"""The command line: thin commands over `wm3d.api`, `wm3d.scanner`, `wm3d.attacks` and `wm3d.bench`.

Each command imports what it needs when it runs, so that ``wm3d --help`` need not wait for numba.
"""

from wm3d.cli.app import main

__all__ = ["main"]
