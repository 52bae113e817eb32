"""Time embedding and detection of each scheme on one mesh, after warm-up; one process, median seconds.

    python experiments/scheme_speed.py [MESH] [--other MESH] [--schemes range-dct,song2002] [--repeats 5]

Detection is timed on the marked mesh as it is and after attacks that make it look longer for the pose, and
on another model, of as many faces, for which it looks longest.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np

from wm3d.attacks import Chain, Clean, Crop, GaussianNoise, Similarity, Simplify, Subdivide
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, datasets
from wm3d.schemes import SCHEMES

SEED = 1
ATTACKED = (
    Clean(),
    GaussianNoise(percent=0.6, amplitude="rms-vector"),
    Simplify(ratio=0.1),
    Crop(percent=30),
    Chain(then=(Crop(percent=50), Similarity())),
)


def main(mesh: str | None, other: str, schemes: str, repeats: int) -> None:
    model = datasets.resolve(
        mesh or ("happy-buddha-300k" if "happy-buddha-300k" in datasets.dataset_names() else "bunny")
    )
    another = with_faces(datasets.resolve(other), len(model.faces))
    print(f"{model.name}: {len(model.vertices)} vertices, {len(model.faces)} faces; median of {repeats}")
    columns = [attack.name for attack in ATTACKED] + [f"other: {other}"]
    print(f"{'scheme':14s}{'embed':>8s}" + "".join(f"{column:>16s}" for column in columns))
    for name in schemes.split(","):
        scheme = SCHEMES.build(name, {})
        try:
            marked, known = scheme.embed(model, SEED)
            suspects = [attack(marked, np.random.default_rng(SEED)) for attack in ATTACKED] + [another]
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


def with_faces(mesh: Mesh, faces: int) -> Mesh:
    """Return a mesh with so many faces, or a few less: subdivided, then simplified."""
    rng = np.random.default_rng(SEED)
    while len(mesh.faces) < faces:
        mesh = Subdivide(rule="midpoint")(mesh, rng)
    return mesh if len(mesh.faces) == faces else Simplify(ratio=faces / len(mesh.faces))(mesh, rng)


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
    parser.add_argument("--other", default="bunny", metavar="MESH", help="another model, dataset or file")
    parser.add_argument("--schemes", default="range-dct,song2002")
    parser.add_argument("--repeats", type=int, default=5)
    main(**vars(parser.parse_args()))
