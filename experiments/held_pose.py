"""Is it the mark or the pose that simplification destroys? Score each mesh twice: as posed anew, and held.

    WM3D_DATA=folder-with-the-meshes python experiments/held_pose.py

"Held" reads the simplified mesh from the cylinder of the marked mesh before the attack, which no blind
detector knows. Prints mean z over keys; writes results/held_pose.csv.
"""

from pathlib import Path

import numpy as np
import pandas as pd
from pydantic import PrivateAttr

from wm3d.attacks import Simplify
from wm3d.mesh import Mesh, datasets, write_whole
from wm3d.scanner import Cylinder
from wm3d.schemes import Song2002

KEYS = 10
MODELS = {
    "happy-buddha-300k": Song2002(grid=(84, 120), region=(26, 0, 80, 80), alpha=0.9),
    "bunny-closed": Song2002(),
    "venus": Song2002(),
}
RESULT = Path(__file__).resolve().parent.parent / "results" / "held_pose.csv"


class Held(Song2002):
    """song2002 that is told where to scan from."""

    _held: Cylinder = PrivateAttr()

    @classmethod
    def at(cls, cylinder: Cylinder, scheme: Song2002) -> "Held":
        """Return a scheme that scans from a cylinder."""
        held = cls(**scheme.model_dump())
        held._held = cylinder
        return held

    def cylinder(self, mesh: Mesh) -> Cylinder:  # noqa: ARG002 (it does not look)
        """Return the cylinder that is held."""
        return self._held


def main() -> None:
    """Score each model, engine and key both ways."""
    rows = []
    for name, scheme in MODELS.items():
        mesh = datasets.load(name)
        for engine in ("fast-simplification", "pymeshlab-quadric", "clustering"):
            attack = Simplify(ratio=0.5, simplifier=engine)
            z = []
            for seed in range(KEYS):
                marked, _ = scheme.embed(mesh, seed)
                attacked = attack(marked, np.random.default_rng(seed))
                held = Held.at(scheme.cylinder(marked), scheme)
                z.append((scheme.score(attacked, seed).z, held.score(attacked, seed).z))
            posed, kept = np.mean(z, axis=0)
            rows.append({"mesh": name, "simplifier": engine, "keys": KEYS, "z_posed": posed, "z_held": kept})
            print(f"{name:18} {engine:20} z posed anew {posed:6.1f}, held {kept:6.1f}", flush=True)
    write_whole(RESULT, pd.DataFrame(rows).to_csv(index=False, lineterminator="\n").encode())


if __name__ == "__main__":
    main()
