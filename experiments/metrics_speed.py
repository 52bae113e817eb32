"""Time the metrics on a pair of 100k faces, and show how far the sampling of MRMS is from its limit.

    WM3D_DATA=... python experiments/metrics_speed.py

The Happy Buddha of 50k vertices against itself marked, with noise, and simplified to half its faces. Each
number is the best of `--repeats` runs, in seconds by the clock, compilation left out. The two directions of
Hausdorff and MRMS are measured at a time on two cores; NUMBA_NUM_THREADS=1 gives the seconds of one.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np

import wm3d
from wm3d.mesh import Mesh, datasets
from wm3d.metrics import hausdorff, hausdorff_error, mrms, msdm, msdm2
from wm3d.metrics.surface import both_ways, distances

MESH = "happy-buddha-50k"


def surfaces(original: Mesh, other: Mesh) -> None:
    both_ways.cache_clear()
    hausdorff(original, other)
    mrms(original, other)


def seconds(function: Callable[[Mesh, Mesh], object], original: Mesh, other: Mesh, repeats: int) -> float:
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        function(original, other)
        best = min(best, time.perf_counter() - start)
    return best


def main(repeats: int) -> None:
    original = datasets.load(MESH)
    rng = np.random.default_rng(0)
    others = {
        "marked, 44 dB": wm3d.embed(original, seed=1, snr=44.0)[0],
        "noise, 0.3 %": wm3d.attacks.ATTACKS.build("gaussian-noise", {"percent": 0.3})(original, rng),
        "simplified, 50 %": wm3d.attacks.ATTACKS.build("simplify", {"ratio": 0.5})(original, rng),
    }
    percent = 100 / original.diagonal
    print("                  Hausdorff   error      MRMS  finer by 2 |  Hausdorff+MRMS    MSDM    MSDM2 [s]")
    for name, other in others.items():
        surfaces(original, other)  # compiles
        time_surfaces = seconds(surfaces, original, other, repeats)
        greatest, error = hausdorff(original, other) * percent, hausdorff_error(original, other) * percent
        mean = mrms(original, other) * percent
        distances.SPACING /= 2
        surfaces(original, other)
        finer = mrms(original, other) * percent
        distances.SPACING *= 2
        times = [f"{time_surfaces:14.2f}"]
        if len(original.vertices) == len(other.vertices):
            msdm(original, other)
            times.append(f"{seconds(msdm, original, other, repeats):7.2f}")
        else:
            times.append("      –")
        msdm2(original, other)
        times.append(f"{seconds(msdm2, original, other, repeats):8.2f}")
        print(
            f"{name:16}  {greatest:8.4f}%  {error:.4f}%  {mean:.5f}%  {finer:.5f}%  |" + " ".join(times),
            flush=True,
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=3)
    main(**vars(parser.parse_args()))
