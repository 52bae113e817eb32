"""Time one trial of the noise experiment, stage by stage: attack, pose, scan, score; one core.

    python experiments/trial_speed.py [MESH]

The model is marked once; each trial draws new noise and scores the right key. The parts of the reading are
timed by calling them once more on the same noisy model.
"""

import argparse
import time

import numpy as np

from wm3d.attacks import GaussianNoise
from wm3d.mesh import Mesh, datasets, orientation
from wm3d.scanner import VertexPca, kernels
from wm3d.schemes import Song2002

STAGES = ("noise", "reading", "score", "  pose", "  frame", "  winding", "  rays")
SEED = 1


def main(mesh: str | None, trials: int) -> None:
    original = datasets.resolve(mesh or ("igea" if "igea" in datasets.dataset_names() else "bunny"))
    marked, scheme = Song2002().embed(original, SEED)
    rng = np.random.default_rng(0)
    trial(scheme, marked, rng)  # compiles
    milliseconds = 1e3 * np.array([trial(scheme, marked, rng) for _ in range(trials)])

    print(f"{original.name}: {len(original.vertices)} vertices, {len(original.faces)} faces, {trials} trials")
    print("        ms: median  fastest")
    whole = milliseconds[:, :3].sum(axis=1)
    for stage, column in zip((*STAGES, "whole trial"), (*milliseconds.T, whole), strict=True):
        print(f"{stage:12s}{np.median(column):7.2f}{column.min():9.2f}")


def trial(scheme: Song2002, marked: Mesh, rng: np.random.Generator) -> list[float]:
    """Seconds of each of `STAGES`."""
    clock = [time.perf_counter()]
    noisy = GaussianNoise()(marked, rng)
    clock.append(time.perf_counter())
    evidence = scheme.evidence(noisy)
    clock.append(time.perf_counter())
    evidence.score(scheme.signs(SEED))
    clock.append(time.perf_counter())
    cylinder = VertexPca()(noisy)
    clock.append(time.perf_counter())
    posed = cylinder.posed(noisy)
    clock.append(time.perf_counter())
    outward = orientation(noisy)
    clock.append(time.perf_counter())
    columns, rows = scheme.grid
    kernels.cast(posed, noisy.faces, cylinder.planes(rows), columns, cylinder.radius, outward)
    clock.append(time.perf_counter())
    return np.diff(clock).tolist()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("mesh", nargs="?", metavar="MESH", help="dataset or file; default igea or bunny")
    parser.add_argument("--trials", type=int, default=60)
    main(**vars(parser.parse_args()))
