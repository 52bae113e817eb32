"""Every attack on every mesh of the folder WM3D_DATA: CPU time, size of the result, or why it refuses.

Usage: WM3D_DATA=FOLDER python experiments/attack_table.py [MESH ...]

Writes results/attacks/timing.csv; with names of meshes, only their rows are made anew. Every row is kept in
timing.partial.csv as soon as it is there: the same command goes on where a run was ended. Attacks that need
other marks of a scheme get noise in their place: the time of a scheme is no part of the attack.
"""

import os
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd

from wm3d.attacks import ATTACKS, Attack, GaussianNoise, MarchingCubes, Owner, RoundTrip, Subdivide
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, load_mesh, write_whole

OUT = Path(__file__).parents[1] / "results" / "attacks" / "timing.csv"
PARTIAL = OUT.with_suffix(".partial.csv")
SEED = 2002
COLUMNS = ["mesh", "faces_in", "attack", "cpu_seconds", "vertices_out", "faces_out", "refusal"]
VARIANTS: list[Attack] = [
    *(cls() for cls in ATTACKS.values()),
    MarchingCubes(cells=256),
    Subdivide(rule="loop"),
    Subdivide(rule="sqrt3"),
    RoundTrip(format="stl", weld=True),
    RoundTrip(format="obj"),
]


def other_mark(mesh: Mesh, seed: int) -> Mesh:
    """Return the mesh with faint noise, in the place of a mark."""
    return GaussianNoise(percent=0.01)(mesh, np.random.default_rng(seed))


def row(mesh: Mesh, attack: Attack) -> dict[str, object]:
    """Attack once; a crash of any kind but a refusal ends the script."""
    run = attack.given(Owner(mesh, other_mark))
    start = time.process_time()
    try:
        result, refusal = run(mesh, np.random.default_rng(SEED)), ""
    except Wm3dError as error:
        result, refusal = None, str(error)
    seconds = time.process_time() - start
    return {
        "mesh": mesh.name,
        "faces_in": len(mesh.faces),
        "attack": attack.label(),
        "cpu_seconds": round(seconds, 3),
        "vertices_out": len(result.vertices) if result else 0,
        "faces_out": len(result.faces) if result else 0,
        "refusal": refusal,
    }


def main() -> None:
    folder = os.environ.get("WM3D_DATA")
    if not folder:
        sys.exit("set WM3D_DATA to a folder of PLY meshes")
    OUT.parent.mkdir(parents=True, exist_ok=True)
    wanted, files = sys.argv[1:], sorted(Path(folder).glob("*.ply"))
    row(load_mesh(min(files, key=lambda file: file.stat().st_size)), GaussianNoise())  # compiles
    done = stored(PARTIAL)
    if len(done):
        print(f"{PARTIAL}: {len(done)} rows are there already; delete it to begin anew.")
    for file in files:
        if wanted and file.stem not in wanted:
            continue
        mesh = load_mesh(file)
        for attack in VARIANTS:
            if ((done["mesh"] == mesh.name) & (done["attack"] == attack.label())).any():
                continue
            made = row(mesh, attack)
            print(*made.values(), sep="  ", flush=True)
            done = pd.concat([done, pd.DataFrame([made])])
            write_whole(PARTIAL, done.to_csv(index=False).encode())
    before = stored(OUT)
    table = pd.concat([before[~before["mesh"].isin(done["mesh"])], done])
    write_whole(OUT, table.sort_values("mesh", kind="stable").to_csv(index=False).encode())
    PARTIAL.unlink(missing_ok=True)


def stored(path: Path) -> pd.DataFrame:
    """Rows of a table, none where there is no file."""
    return pd.read_csv(path, keep_default_na=False) if path.exists() else pd.DataFrame(columns=COLUMNS)


if __name__ == "__main__":
    main()
