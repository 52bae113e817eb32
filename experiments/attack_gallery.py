"""A picture of every attack on the bundled bunny, for docs/attacks.md: the model, and its mesh close by.

    python experiments/attack_gallery.py [NAME ...]

Writes docs/attacks/NAME.png, with names only those. Strengths are the greatest of the LIRIS benchmark, or the
defaults. Attacks that need other marks of a scheme use those of song2002.
"""

import io
import sys
from pathlib import Path

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from PIL import Image

from wm3d.arrays import FloatArray
from wm3d.attacks import (
    ATTACKS,
    Attack,
    Bend,
    Chain,
    Companion,
    Crop,
    DropFaces,
    HalfSpaceCrop,
    Owner,
    Pedestal,
    Quantize,
    Shear,
    Simplify,
    Stretch,
    Subdivide,
    Twist,
)
from wm3d.bench.render import View, render
from wm3d.mesh import Mesh, datasets, write_whole
from wm3d.schemes import Song2002

OUT = Path(__file__).parents[1] / "docs" / "attacks"
SEED, PIXELS, COLORS = 2002, 230, 48
CLOSE_UP = 6.0
"""How much larger the right half of a picture is."""

GROWN = 1.2
"""Size of a result, over that of the model, from which the picture shows all of it."""

SPOT = 0.52, 0.56
SPOTS = {"crop": (0.5, 0.5), "half-space-crop": (0.42, 0.84), "chain": (0.42, 0.84), "pedestal": (0.5, 0.85)}
"""Middle of the close-up in the picture, from the left and from above: on the back, or at the cut."""

STRONGEST: dict[str, Attack] = {
    "quantize-per-axis": Quantize(bits=7, grid="per-axis"),
    "quantize-cubic": Quantize(bits=11, grid="cubic"),
    "subdivide-midpoint": Subdivide(rule="midpoint"),
    "subdivide-loop": Subdivide(rule="loop"),
    "subdivide-sqrt3": Subdivide(rule="sqrt3"),
    "simplify": Simplify(ratio=0.025, simplifier="pymeshlab-quadric"),
    "crop": Crop(percent=50),
    "drop-faces": DropFaces(percent=20),
    "pedestal": Pedestal(axis="y"),
    "companion": Companion(percent=40),
    # the pictures look along z, which is the default axis of the deformations
    "stretch": Stretch(axis="y"),
    "shear": Shear(axis="x"),
    "bend": Bend(axis="x"),
    "twist": Twist(axis="y"),
    "chain": Chain(then=(HalfSpaceCrop(percent=10), Quantize(bits=7))),
}
"""What is shown where it is not an attack by its defaults; names start with that of the attack."""


def pictured() -> dict[str, Attack]:
    """Every registered attack, once or in all its variants, by file name."""
    shown = {}
    for name, cls in ATTACKS.items():
        own = {file: attack for file, attack in STRONGEST.items() if isinstance(attack, cls)}
        shown |= own or {name: cls()}
    return shown


def attacked(mesh: Mesh, attack: Attack) -> Mesh:
    """Attack the mesh as an experiment does."""
    scheme = Song2002(grid=(84, 84), region=(2, 0, 80, 80))
    owner = Owner(mesh, lambda subject, seed: scheme.embed(subject, seed)[0])
    return attack.given(owner)(mesh, np.random.default_rng(SEED))


def edges_in_front(mesh: Mesh, view: View, hidden: FloatArray) -> FloatArray:
    """Edges (k, 2, 2) of the faces that look at the viewer, in pixels of the view."""
    points = view.project(mesh.vertices)
    a, b, c = (points[mesh.faces[:, k]] for k in range(3))
    u, v = (b - a)[:, :2], (c - a)[:, :2]
    height, width = view.size
    center = (a + b + c)[:, :2] / 3
    front = (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] < 0) & ~hidden
    front &= (np.abs(center - [width / 2, height / 2]) < [width, height]).all(axis=1)
    corners = mesh.faces[front]
    edges = np.unique(
        np.sort(np.vstack([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])), axis=0
    )
    return points[edges][:, :, :2]


def picture(mesh: Mesh, framed: Mesh, spot: tuple[float, float]) -> bytes:
    """PNG of a mesh in the view of the framed one, and of its edges close by."""
    whole = View.around(framed.vertices, np.eye(3), (PIXELS, PIXELS), margin=0.08)
    aside = [(spot[0] - 0.5) * PIXELS, (0.5 - spot[1]) * PIXELS, 0.0]
    center = whole.center + np.array(aside) / whole.scale
    near = View(whole.axes, center, whole.scale * CLOSE_UP, whole.size)
    figure = Figure(figsize=(2 * PIXELS / 100, PIXELS / 100), dpi=100)
    for k, view in enumerate((whole, near)):
        shot = render(mesh, view)
        panel = figure.add_axes((k / 2, 0, 0.5, 1))
        panel.set_axis_off()
        panel.imshow(shot.image.clip(0, 1), extent=(0, PIXELS, PIXELS, 0), interpolation="nearest")
        if k:
            centers = mesh.vertices[mesh.faces].mean(axis=1)
            centers[:, 2] += 1e-3 * mesh.diagonal  # a little before the surface, or it would hide itself
            lines = edges_in_front(mesh, view, shot.hides(centers))
            panel.add_collection(LineCollection(list(lines), colors="#20303c", linewidths=0.35))
        panel.set(xlim=(0, PIXELS), ylim=(PIXELS, 0))
    figure.add_artist(LineCollection([[(0.5, 0.03), (0.5, 0.97)]], colors="0.8", linewidths=0.8))
    full, small = io.BytesIO(), io.BytesIO()
    figure.savefig(full, format="png")
    Image.open(full).convert("RGB").quantize(COLORS).save(small, format="png", optimize=True)
    return small.getvalue()


def main() -> None:
    mesh, wanted = datasets.load("bunny"), sys.argv[1:]
    OUT.mkdir(parents=True, exist_ok=True)
    for name, attack in pictured().items():
        if wanted and name not in wanted:
            continue
        result = attacked(mesh, attack)
        framed = result if attack.turns or result.diagonal > GROWN * mesh.diagonal else mesh
        write_whole(OUT / f"{name}.png", picture(result, framed, SPOTS.get(name, SPOT)))
        size = (OUT / f"{name}.png").stat().st_size
        print(f"{name}: {attack.label()}, {len(result.faces)} faces, {size} bytes", flush=True)


if __name__ == "__main__":
    main()
