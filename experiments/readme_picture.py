"""Draw docs/pipeline.png: one key on the bundled bunny, from the scan to its detection after noise.

Run it without arguments: ``python experiments/readme_picture.py``.
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pictures import (
    DPI,
    GREY,
    RED,
    credit_line,
    draw_cylinder,
    outline,
    portrait,
    save,
    show,
    show_ranges,
    wanted_change,
)

from wm3d import Mesh, snr
from wm3d.arrays import FloatArray
from wm3d.attacks import GaussianNoise
from wm3d.bench.figures import power_of_ten
from wm3d.mesh import datasets
from wm3d.scanner import Cylinder
from wm3d.schemes import Song2002

OUT = Path(__file__).resolve().parent.parent / "docs" / "pipeline.png"
SEED, WRONG_KEYS = 2002, 2000
WIDTH, HEIGHT = 9.0, 2.15  # inches; 900 pixels wide on a page, so 8 points are 11 pixels
PANEL, GAP, BOTTOM, TALL = 1.32, 0.19, 0.58, 1.45


def main() -> None:
    """Mark, attack, detect; draw each step."""
    mesh, scheme, attack = datasets.load("bunny"), Song2002(), GaussianNoise()
    image, change, marked = wanted_change(scheme, mesh, SEED)
    attacked = attack(marked, np.random.default_rng(SEED))
    evidence = scheme.evidence(attacked)
    score = evidence.score(scheme.signs(SEED))
    wrong = np.array([evidence.score(scheme.signs(SEED + k)).z for k in range(1, WRONG_KEYS + 1)])

    figure = Figure(figsize=(WIDTH, HEIGHT))
    panels = [
        step(figure, 0, "", "model", "in its virtual scanner"),
        step(figure, 1, "→", "range image", "84×84 rays"),
        step(figure, 2, "+", "mark", "±α on the block DCT, by key"),
        step(figure, 3, "→", "marked model", f"SNR {snr(mesh, marked):.1f} dB"),
        step(figure, 4, "→", "attacked model", f"noise, {attack.percent:g} % of the diagonal"),
        step(figure, 5, "→", "detection", f"right key: p ≈ {power_of_ten(round(score.log10_p))}"),
    ]
    show_model(panels[0], mesh, image.cylinder, wireframe=True)
    show_ranges(panels[1], image, scheme.region)
    show_mark(panels[2], change)
    for panel, model in ((panels[3], marked), (panels[4], attacked)):
        show_model(panel, model, image.cylinder)
    show_scores(panels[5], wrong, score.z)
    figure.text(0.998, 0.02, credit_line("bunny"), fontsize=5.5, color=GREY, ha="right")
    OUT.parent.mkdir(exist_ok=True)
    save(figure, OUT)
    print(f"{OUT.name}: z = {score.z:.1f}, log10 p = {score.log10_p:.1f}, {OUT.stat().st_size / 1000:.0f} kB")


def step(figure: Figure, k: int, sign: str, title: str, detail: str) -> Axes:
    """Return the k-th panel, with the sign that leads to it and its words below."""
    left = 0.06 + k * (PANEL + GAP)
    panel = figure.add_axes((left / WIDTH, BOTTOM / HEIGHT, PANEL / WIDTH, TALL / HEIGHT))
    panel.set_axis_off()
    middle = (left + PANEL / 2) / WIDTH
    figure.text(middle, 0.36 / HEIGHT, title, fontsize=9, ha="center", weight="bold")
    figure.text(middle, 0.20 / HEIGHT, detail, fontsize=7, ha="center", color="0.35")
    before = (left - GAP / 2) / WIDTH
    figure.text(before, (BOTTOM + TALL / 2) / HEIGHT, sign, fontsize=13, ha="center", va="center")
    return panel


def show_model(panel: Axes, mesh: Mesh, cylinder: Cylinder, *, wireframe: bool = False) -> None:
    """Render a model; all of them at the scale at which the first one shows its cylinder."""
    picture = portrait(mesh, cylinder, (int(TALL * DPI), int(PANEL * DPI)), outline(cylinder))
    show(panel, picture)
    if wireframe:
        draw_cylinder(panel, picture, cylinder, linewidth=0.8)


def show_mark(panel: Axes, change: FloatArray) -> None:
    """Show Δl, blue towards the scanner and red away from it."""
    rows, columns = change.shape
    reach = np.abs(change).max()
    panel.imshow(
        change, cmap="RdBu_r", vmin=-reach, vmax=reach, origin="lower", interpolation="nearest",
        extent=(0, columns, 0, rows),
    )  # fmt: skip


def show_scores(panel: Axes, wrong: FloatArray, right: float) -> None:
    """Show the histogram of z of keys that were never embedded, and z of the one that was."""
    panel.set_axis_on()
    x, y, width, height = panel.get_position().bounds
    panel.set_position((x, y + 0.12 * height, width, 0.88 * height))  # room for the numbers
    panel.spines["left"].set_visible(False)
    panel.hist(wrong, bins=np.arange(-5, 5.25, 0.25), color="0.6")
    tall = panel.get_ylim()[1]
    panel.plot([right, right], [0, 0.75 * tall], color=RED, linewidth=1.6)
    panel.annotate(f"right key\nz = {right:.1f}", (right, 0.78 * tall), fontsize=7, color=RED, ha="right")
    panel.annotate(f"{WRONG_KEYS}\nwrong keys", (1.6, 0.55 * tall), fontsize=7, color="0.35")
    panel.set(yticks=[], xticks=[0, 5, 10, 15], xlim=(-4.5, right + 1.5), ylim=(0, 1.05 * tall))
    panel.tick_params(labelsize=7, length=2, pad=1.5)
    panel.annotate("z", (1, 0), (-4, -9), xycoords="axes fraction", textcoords="offset points", fontsize=7)


if __name__ == "__main__":
    main()
