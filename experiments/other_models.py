"""Mark each mesh of a folder with range-dct, attack it and read it; writes a table of z.

    python experiments/other_models.py FOLDER [--out other_models.csv] [--seed 7]

One key a model, the default parameters. So: how does it do on models that it was not made with, or on yours?
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from wm3d import Wm3dError, load_mesh
from wm3d.attacks import (
    Attack,
    Bend,
    Chain,
    Clean,
    Crop,
    DropFaces,
    FlipFaces,
    GaussianNoise,
    LaplacianSmoothing,
    Quantize,
    Similarity,
    Simplify,
)
from wm3d.mesh import ENDINGS, Mesh, write_whole
from wm3d.schemes import RangeDct

ATTACKED: tuple[Attack, ...] = (
    Clean(),
    Similarity(),
    GaussianNoise(percent=0.6),
    GaussianNoise(percent=0.6, amplitude="per-axis"),
    Simplify(ratio=0.5),
    Simplify(ratio=0.1),
    LaplacianSmoothing(iterations=10),
    Quantize(bits=9),
    Bend(degrees=10),
    Crop(percent=10),
    Chain(then=(Crop(percent=10), Similarity())),
    DropFaces(percent=5),
    FlipFaces(percent=50),
)


def models(folder: Path) -> Iterator[Mesh]:
    """Load the meshes of a folder that have faces, the largest last."""
    for file in sorted(folder.iterdir(), key=lambda file: (file.stat().st_size, file.name)):
        if file.suffix.lower() in ENDINGS:
            try:
                yield load_mesh(file)
            except Wm3dError as error:
                print(f"left out: {error}")


def row(mesh: Mesh, seed: int) -> dict[str, Any]:
    """Return z after each attack, NaN where the mesh cannot be read; or why the mesh is refused."""
    line: dict[str, Any] = {"model": mesh.name, "vertices": len(mesh.vertices), "faces": len(mesh.faces)}
    line["version"] = RangeDct.version
    try:
        marked, scheme = RangeDct().embed(mesh, seed)
    except Wm3dError as error:
        return line | {"refused": str(error).removeprefix(f"{mesh.name}: ")}
    for attack in ATTACKED:
        try:
            line[attack.label()] = scheme.score(attack(marked, np.random.default_rng(seed)), seed).z
        except Wm3dError:
            line[attack.label()] = np.nan
    return line


def main() -> None:
    """Mark and read one model after the other, and write the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, default=Path("other_models.csv"))
    parser.add_argument("--seed", type=int, default=7)
    options = parser.parse_args()
    if not options.folder.is_dir():
        parser.error(f"{options.folder} is no folder")
    lines = []
    for mesh in models(options.folder):
        lines.append(row(mesh, options.seed))
        refused = lines[-1].get("refused")
        print(f"{mesh.name}: {refused or 'z {:.1f}'.format(lines[-1]['clean'])}", flush=True)
    if not lines:
        parser.error(f"{options.folder} holds no mesh")
    columns = ["model", "vertices", "faces", "refused", *(attack.label() for attack in ATTACKED), "version"]
    table = pd.DataFrame(lines).reindex(columns=columns)
    write_whole(options.out, table.to_csv(index=False, float_format="%.2f").encode())


if __name__ == "__main__":
    main()
