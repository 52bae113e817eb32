"""Time embedding and detection of each scheme on one mesh, after warm-up; one process, median seconds.

    python experiments/scheme_speed.py [MESH] [--schemes range-dct,song2002] [--repeats 5]

Detection is timed on the marked mesh as it is and after attacks that make it look longer for the pose.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np

from wm3d.attacks import Clean, Crop, GaussianNoise, Simplify
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, datasets
from wm3d.schemes import SCHEMES

SEED = 1
ATTACKED = (
    Clean(),
    GaussianNoise(percent=0.6, amplitude="rms-vector"),
    Simplify(ratio=0.1),
    Crop(percent=30),
)


def main(mesh: str | None, schemes: str, repeats: int) -> None:
    model = datasets.resolve(
        mesh or ("happy-buddha-300k" if "happy-buddha-300k" in datasets.dataset_names() else "bunny")
    )
    print(f"{model.name}: {len(model.vertices)} vertices, {len(model.faces)} faces; median of {repeats}")
    print(f"{'scheme':14s}{'embed':>8s}" + "".join(f"{attack.name:>16s}" for attack in ATTACKED))
    for name in schemes.split(","):
        scheme = SCHEMES.build(name, {})
        try:
            marked, known = scheme.embed(model, SEED)
            suspects = [attack(marked, np.random.default_rng(SEED)) for attack in ATTACKED]
            for suspect in suspects:
                known.score(suspect, SEED)
        except Wm3dError as error:
            print(f"{name:14s}{error}")
            continue
        embed = median_seconds(lambda mesh, scheme=scheme: scheme.embed(mesh, SEED), model, repeats)
        detect = [
            median_seconds(lambda mesh, known=known: known.score(mesh, SEED), suspect, repeats)
            for suspect in suspects
        ]
        print(f"{name:14s}{embed:8.2f}" + "".join(f"{taken:16.2f}" for taken in detect), flush=True)


def median_seconds(call: Callable[[Mesh], object], mesh: Mesh, repeats: int) -> float:
    """Return how long a call takes on a mesh not seen before: what was found in the last one may be kept."""
    return float(np.median([seconds(call, mesh.with_vertices(mesh.vertices.copy())) for _ in range(repeats)]))


def seconds(call: Callable[[Mesh], object], mesh: Mesh) -> float:
    """Return how long a call takes."""
    start = time.perf_counter()
    call(mesh)
    return time.perf_counter() - start


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("mesh", nargs="?", metavar="MESH", help="dataset or file")
    parser.add_argument("--schemes", default="range-dct,song2002")
    parser.add_argument("--repeats", type=int, default=5)
    main(**vars(parser.parse_args()))
