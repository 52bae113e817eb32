"""Time embedding and detection of each scheme on one mesh, after warm-up; one process.

python experiments/scheme_speed.py [MESH] [--schemes range-dct,song2002] [--repeats 5]
"""

import argparse
import time

import numpy as np

from wm3d.errors import Wm3dError
from wm3d.mesh import datasets
from wm3d.schemes import SCHEMES

SEED = 1


def main(mesh: str | None, schemes: str, repeats: int) -> None:
    model = datasets.resolve(
        mesh or ("happy-buddha-300k" if "happy-buddha-300k" in datasets.dataset_names() else "bunny")
    )
    print(f"{model.name}: {len(model.vertices)} vertices, {len(model.faces)} faces; median of {repeats}")
    print(f"{'scheme':20s}{'embed s':>10s}{'detect s':>10s}")
    for name in schemes.split(","):
        scheme = SCHEMES.build(name, {})
        try:
            marked, known = scheme.embed(model, SEED)
            known.score(marked, SEED)
        except Wm3dError as error:
            print(f"{name:20s}{error}")
            continue
        # into a mesh not seen before: schemes keep what they found in the last one for its next key
        unseen = [model.with_vertices(model.vertices.copy()) for _ in range(repeats)]
        embed = [seconds(lambda scheme=scheme, mesh=mesh: scheme.embed(mesh, SEED)) for mesh in unseen]
        detect = [
            seconds(lambda known=known, marked=marked: known.score(marked, SEED)) for _ in range(repeats)
        ]
        print(f"{name:20s}{np.median(embed):10.2f}{np.median(detect):10.2f}", flush=True)


def seconds(call) -> float:
    """Return how long a call takes."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("mesh", nargs="?", metavar="MESH", help="dataset or file")
    parser.add_argument("--schemes", default="range-dct,song2002")
    parser.add_argument("--repeats", type=int, default=5)
    main(**vars(parser.parse_args()))
