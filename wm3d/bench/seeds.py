"""Randomness from names: each draw follows from the root seed, a mesh, a trial and a stream."""

import hashlib

import numpy as np


def derived_seed(root: int, mesh_digest: str, trial: int, stream: str) -> int:
    """Return 256 bits that belong to one stream of one trial on one mesh.

    The scheme and the attack are left out on purpose: all of them see the same keys and the same noise, so
    that differences between them are not differences between draws.
    """
    name = f"wm3d/{root}/{mesh_digest}/{trial}/{stream}"
    return int.from_bytes(hashlib.sha256(name.encode()).digest(), "big")


def generator(seed: int) -> np.random.Generator:
    """Return the generator of a derived seed."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))
