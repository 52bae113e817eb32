"""One picture of every attack on the bunny, at its greatest strength in the LIRIS benchmark or by default.

Usage: python experiments/attack_gallery.py

Writes results/attacks/gallery.png. Attacks that need other marks of a scheme use those of song2002.
"""

import textwrap
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from wm3d.attacks import (
    ATTACKS,
    Attack,
    Chain,
    Crop,
    LaplacianSmoothing,
    Owner,
    Quantize,
    Simplify,
    Subdivide,
)
from wm3d.bench.render import View, render
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, datasets, write_whole
from wm3d.schemes import Song2002

OUT = Path(__file__).parents[1] / "results" / "attacks" / "gallery.png"
SEED, COLUMNS, PIXELS, DPI = 2002, 6, 320, 200
CAPTION = "Stanford bunny (Stanford Computer Graphics Laboratory)"
STRONGEST: dict[str, Attack] = {
    "laplacian-smoothing": LaplacianSmoothing(iterations=50),
    "quantize": Quantize(bits=7),
    "simplify": Simplify(ratio=0.025),
    "subdivide": Subdivide(rule="sqrt3"),
    "crop": Crop(percent=50),
    "chain": Chain(then=(Crop(percent=10), Quantize(bits=8))),
}


def attacked(mesh: Mesh, attack: Attack) -> Mesh:
    """Attack the mesh as an experiment does."""
    scheme = Song2002(grid=(84, 84), region=(2, 0, 80, 80))
    owner = Owner(mesh, lambda subject, seed: scheme.embed(subject, seed)[0])
    return attack.given(owner)(mesh, np.random.default_rng(SEED))


def main() -> None:
    mpl.rcParams.update({"font.size": 6, "axes.titlesize": 6})
    mesh = datasets.load("bunny")
    attacks = [STRONGEST.get(name, cls()) for name, cls in ATTACKS.items()]
    rows = -(-len(attacks) // COLUMNS)
    figure = Figure(figsize=(7.2, 1.32 * rows), dpi=DPI, layout="constrained")
    panels = figure.subplots(rows, COLUMNS).ravel()
    for panel in panels:
        panel.set_axis_off()
    for panel, attack in zip(panels, attacks, strict=False):
        panel.set_title(textwrap.fill(attack.label(), 24), pad=2)
        try:
            result = attacked(mesh, attack)
        except Wm3dError as error:
            print(error)
            panel.text(0.5, 0.5, "refused", ha="center")
            continue
        view = View.around(result.vertices, np.eye(3), (PIXELS, PIXELS))
        panel.imshow(render(result, view).image.clip(0, 1), interpolation="antialiased")
        print(attack.label(), len(result.vertices), len(result.faces), flush=True)
    figure.text(0.995, 0.004, CAPTION, ha="right", size=5)
    OUT.parent.mkdir(parents=True, exist_ok=True)
    partial = OUT.with_suffix(".partial.png")
    figure.savefig(partial, pil_kwargs={"optimize": True})
    write_whole(OUT, partial.read_bytes())
    partial.unlink()


if __name__ == "__main__":
    main()
