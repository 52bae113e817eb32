"""Cut off a part of a model and turn the rest; count how often the search lays it where it belongs.

    WM3D_DATA=folder python experiments/turned_halves.py [--percent 50] [--cuts 12] [--seed 500] [--mirrored]

Each cut has a random direction, each turn is random, parts are mended as detection does it, and nothing is
known of the pose. Prints for each model how many parts were laid within `NEAR` of the turn that undoes
theirs.
"""

import argparse

import numpy as np
from scipy.linalg import polar
from scipy.spatial.transform import Rotation

from wm3d.arrays import FloatArray
from wm3d.attacks import Crop
from wm3d.mesh import datasets, whole_surface
from wm3d.scanner.registration import Landmarks, Surface, Warp, posed, registered
from wm3d.schemes.range_dct import RangeDct

ALPHAS = {"bunny-closed": 0.63, "venus": 0.63, "igea": 0.63, "horse": 0.63, "happy-buddha-300k": 0.33}
"""Models, and the strengths of their marks (of the paper's SNR)."""

NEAR = 10.0
"""Degrees."""

NOWHERE = Warp.linear(np.diag([1.0, 1.0, -1.0]), np.zeros(3))
"""A pose that has nothing to do with the model."""


def laid_right(name: str, percent: float, seeds: range, image: FloatArray) -> int:
    """Return how many turned parts of a model, or of its (3, 3) `image`, were laid where they belong."""
    marked, scheme = RangeDct(alpha=ALPHAS[name]).embed(datasets.resolve(name), 0)
    if scheme.reference is None:
        raise TypeError("embedding always returns a reference")
    landmarks = Landmarks.decode(scheme.reference.landmarks)
    home = np.reshape(scheme.reference.home[:9], (3, 3))
    right = 0
    for seed in seeds:
        rng = np.random.default_rng(seed)
        part = Crop(percent=percent)(marked, rng)
        turn = Rotation.random(rng=rng).as_matrix() @ image
        surface = Surface.of(whole_surface(part.with_vertices(part.vertices @ turn.T)))
        found = registered(surface, landmarks, [posed(surface, landmarks, NOWHERE)], mirrored=True).warp
        off = polar(found.matrix)[0] @ polar(home @ turn.T)[0].T
        turned = np.linalg.det(off) > 0 and np.degrees(Rotation.from_matrix(off).magnitude()) < NEAR
        right += bool(turned)
    return right


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--percent", type=float, default=50.0, help="of the vertices, cut off")
    parser.add_argument("--cuts", type=int, default=12)
    parser.add_argument("--seed", type=int, default=500, help="of the first cut; the next has the next")
    parser.add_argument("--mirrored", action="store_true", help="parts of the mirror image")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.cuts)
    image = np.diag([1.0, 1.0, -1.0 if options.mirrored else 1.0])
    total = 0
    for name in ALPHAS:
        right = laid_right(name, options.percent, seeds, image)
        total += right
        print(f"{name:18} {right} of {options.cuts}", flush=True)
    print(f"{'all':18} {total} of {options.cuts * len(ALPHAS)}")
