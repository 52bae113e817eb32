"""A plug-in with attacks that misbehave; its entry points are read where this folder is on PYTHONPATH."""

import os
import signal
import time
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from wm3d.attacks.base import Attack
from wm3d.mesh import Mesh


class Raising(Attack):
    """Raises an error in a share of the trials."""

    name: Literal["raising"] = "raising"

    share: Annotated[float, Field(ge=0, le=1)] = 1.0

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        if rng.random() < self.share:
            raise RuntimeError("as it was told to")
        return mesh


class Sleeping(Attack):
    """Takes its time."""

    name: Literal["sleeping"] = "sleeping"

    seconds: float = 0.1

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (one signature)
        time.sleep(self.seconds)
        return mesh


class Starving(Attack):
    """Wants more memory than there is, as numpy says it."""

    name: Literal["starving"] = "starving"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (one signature)
        np.empty(1 << 56)
        return mesh


class Killing(Attack):
    """Kills its own process, as the system does when memory runs out.

    Attributes
    ----------
    once : str
        A file; the attack is harmless once that exists. Without one it always kills.
    """

    name: Literal["killing"] = "killing"

    once: str = ""

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (one signature)
        if self.once:
            try:
                Path(self.once).open("x").close()
            except FileExistsError:
                return mesh
        os.kill(os.getpid(), signal.SIGKILL)
        return mesh
