"""Draw Figs. 1, 2, 4 and 5 of the paper for any mesh into results/paper/figures.

python experiments/paper_figures.py
python experiments/paper_figures.py --mesh happy-buddha-300k --grid 84x120 --region 26,0,80,80 --alpha 0.9
"""

import argparse
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import ArrayLike
from pictures import (
    BLUE,
    DPI,
    GREY,
    RED,
    TILT,
    TURN,
    credit_line,
    draw,
    draw_cylinder,
    outline,
    portrait,
    save,
    show,
    show_ranges,
    wall,
    wanted_change,
)

from wm3d import Mesh, snr
from wm3d.arrays import FloatArray
from wm3d.bench.render import Picture, View, render, upright
from wm3d.mesh import datasets
from wm3d.scanner import Cylinder, RangeImage, scan
from wm3d.schemes import Song2002

OUT = Path(__file__).resolve().parent.parent / "results" / "paper" / "figures"
SEED = 2002
CAPTION_INCHES = 0.62
INCHES_A_LETTER = 0.0515  # of the caption, 6 points
ARROW: dict[str, Any] = {"mutation_scale": 8, "shrinkA": 0, "shrinkB": 0}


def main(name: str, scheme: Song2002, out: Path) -> None:
    """Mark the mesh once and draw the four figures."""
    mesh = datasets.resolve(name)
    image, change, marked = wanted_change(scheme, mesh, SEED)
    difference = np.abs(marked.vertices - scheme.embed(mesh, SEED)[0].vertices).max()
    print(f"{name}: step by step and `embed` differ by {difference / mesh.diagonal:.1e} diagonals")
    facts = (
        f"{name}: {len(mesh.vertices)} vertices, {len(mesh.faces)} faces; song2002 with grid "
        f"{'×'.join(map(str, scheme.grid))}, region {','.join(map(str, scheme.region))}, "
        f"α = {scheme.alpha:g}, seed {SEED}; SNR {snr(mesh, marked):.2f} dB. {credit_line(name)}"
    )
    out.mkdir(parents=True, exist_ok=True)
    for key, (figure, caption) in {
        "fig1": cylinder_and_axes(mesh, image.cylinder),
        "fig2": grid_and_ranges(mesh, image, scheme),
        "fig4": rays(marked, image, change, scheme),
        "fig5": before_and_after(mesh, marked, image.cylinder),
    }.items():
        width, height = figure.get_size_inches()
        text = textwrap.fill(f"{caption} {facts}", int(width / INCHES_A_LETTER))
        figure.text(0.06 / width, 0.05 / height, text, fontsize=6, color="0.3", va="bottom")
        save(figure, out / f"{key}-{name}.png")
        if key != "fig5":  # which has nothing that is not a raster
            save(figure, out / f"{key}-{name}.svg")


def cylinder_and_axes(mesh: Mesh, cylinder: Cylinder) -> tuple[Figure, str]:
    """Fig. 1: the model inside its scanning cylinder, with the reference axes from the mean m."""
    lengths = [cylinder.hmax + 0.2 * cylinder.height, 1.5 * cylinder.radius, 1.5 * cylinder.radius]
    tips = cylinder.center + cylinder.axes * np.array(lengths)[:, None]
    room = cylinder.center + 1.08 * (tips - cylinder.center)  # for the letters
    figure, panel, picture = picture_panel(mesh, cylinder, np.vstack([outline(cylinder), room]), 3.4, 4.4)
    draw_cylinder(panel, picture, cylinder)
    for k, tip in enumerate(tips):
        line = np.linspace(cylinder.center, tip, 200)
        faint = {"linewidth": 0.8, "linestyle": (0, (2, 1.5)), "alpha": 0.8}
        draw(panel, picture, line, hidden=faint, color=RED, linewidth=1.3)
        (x0, y0), (x, y) = picture.view.project(line[[-12, -1]])[:, :2]
        panel.annotate("", (x, y), (x0, y0), arrowprops={"arrowstyle": "-|>", "color": RED, "linewidth": 1.3})
        ahead = 9 * np.array([x - x0, y0 - y]) / np.hypot(x - x0, y - y0)
        letter(panel, f"s{'₁₂₃'[k]}", (x, y), ahead, RED)
    x, y, _ = picture.view.project(cylinder.center)
    panel.plot(x, y, "o", color=RED, markersize=3)
    letter(panel, "m", (x, y), (-7, 5), RED)
    dimensions(panel, picture, cylinder)
    return (
        figure,
        "The model inside its scanning cylinder: mean m of the vertices, reference axes s₁, s₂, s₃.",
    )


def dimensions(panel: Axes, picture: Picture, cylinder: Cylinder) -> None:
    """Write the height h beside the cylinder and the radius r on its top."""
    right = np.radians(TURN + 90)
    beside = picture.view.project(wall(cylinder, [cylinder.hmin, cylinder.hmax], right, radius=1.12))[:, :2]
    arrow = ARROW | {"arrowstyle": "<|-|>", "color": GREY, "linewidth": 0.7}
    panel.annotate("", beside[1], beside[0], arrowprops=arrow)
    letter(panel, "h", beside.mean(axis=0), (7, 0), GREY)
    top = cylinder.center + cylinder.hmax * cylinder.axes[0]
    spoke = picture.view.project(np.stack([top, wall(cylinder, cylinder.hmax, right + np.pi + 0.6)]))[:, :2]
    panel.plot(*spoke.T, color=GREY, linewidth=0.7)
    letter(panel, "r", spoke.mean(axis=0), (0, 6), GREY)


def letter(panel: Axes, text: str, at: ArrayLike, beside: ArrayLike, color: str) -> None:
    """Write a symbol so many points beside a place, legible on any ground."""
    panel.annotate(
        text, at, beside, textcoords="offset points", color=color, fontsize=10, ha="center", va="center",
        path_effects=[withStroke(linewidth=2, foreground="white")],
    )  # fmt: skip


def grid_and_ranges(mesh: Mesh, image: RangeImage, scheme: Song2002) -> tuple[Figure, str]:
    """Fig. 2: the grid of rays on the near half of the cylinder, and the range image that they give."""
    cylinder = image.cylinder
    below = wall(cylinder, cylinder.hmin - 0.12 * cylinder.height, np.radians(TURN))
    figure, panel, picture = picture_panel(
        mesh, cylinder, np.vstack([outline(cylinder), below]), 7.2, 4.0, share=0.42
    )
    draw_cylinder(panel, picture, cylinder)
    columns, rows = scheme.grid
    heights, angles = cylinder.planes(rows), 2 * np.pi * np.arange(columns) / columns
    around, along = np.linspace(0, 2 * np.pi, 721), np.linspace(heights[0], heights[-1], 2)
    for row in heights:
        draw_near(panel, picture, wall(cylinder, row, around), around, color=GREY, linewidth=0.25)
    for angle in angles:
        draw_near(panel, picture, wall(cylinder, along, angle), angle, color=GREY, linewidth=0.25)
    top, left, height, width = scheme.region
    low, high = cylinder.hmin + np.array([top, top + height]) * cylinder.height / rows
    start, end = 2 * np.pi * (np.array([left, left + width]) - 0.5) / columns
    side = np.linspace(start, end, 721)
    for edge, turns in (
        (wall(cylinder, low, side), side),
        (wall(cylinder, high, side), side),
        (wall(cylinder, [low, high], start), start),
        (wall(cylinder, [low, high], end), end),
    ):
        draw_near(panel, picture, edge, turns, color=BLUE, linewidth=1.4, solid_capstyle="round")
    label_grid(panel, picture, cylinder)
    beside = figure.add_axes((0.53, 0.2, 0.36, 0.72))
    shown = show_ranges(beside, image, scheme.region)
    beside.set(xlabel="column v, around the axis", ylabel="row u, along s₁")
    bar = figure.colorbar(shown, cax=figure.add_axes((0.91, 0.2, 0.014, 0.72)))
    bar.set_label("range l / r")
    return figure, (
        f"The {columns}×{rows} grid of rays (N_v×N_u) on the near half of the cylinder, and the range image; "
        "blue: the marked region; pale blue: rays that meet no face."
    )


def draw_near(panel: Axes, picture: Picture, points: FloatArray, angles: ArrayLike, **style: Any) -> None:
    """Draw a polyline on the cylinder as far as it runs on the half that faces the viewer."""
    near = np.broadcast_to(np.cos(angles - np.radians(TURN)) > 0, len(points))
    panel.plot(*np.where(near[:, None], picture.view.project(points)[:, :2], np.nan).T, **style)


def label_grid(panel: Axes, picture: Picture, cylinder: Cylinder) -> None:
    """Show on the rim which way u and v count."""
    arrow = ARROW | {"arrowstyle": "-|>", "color": RED, "linewidth": 1.1}
    start = np.radians(TURN - 35)
    origin = wall(cylinder, cylinder.hmin - 0.05 * cylinder.height, start)
    along = wall(cylinder, cylinder.hmin + 0.10 * cylinder.height, start)
    around = wall(cylinder, cylinder.hmin - 0.05 * cylinder.height, start + np.linspace(0, 0.6, 20))
    panel.plot(*picture.view.project(around)[:, :2].T, color=RED, linewidth=1.1)
    for name, tail, tip, beside in (("v", around[-2], around[-1], (7, 0)), ("u", origin, along, (0, 6))):
        (x0, y0), (x, y) = picture.view.project(np.stack([tail, tip]))[:, :2]
        panel.annotate("", (x, y), (x0, y0), arrowprops=arrow)
        letter(panel, name, (x, y), beside, RED)


def rays(marked: Mesh, image: RangeImage, change: FloatArray, scheme: Song2002) -> tuple[Figure, str]:
    """Fig. 4: the rays of one column before and after marking, and Δl wanted and found again."""
    cylinder, rows = image.cylinder, scheme.grid[1]
    column = telling_column(image, change)
    heights = (cylinder.planes(rows) - cylinder.hmin) / cylinder.height
    before = image.ranges[:, column] / cylinder.radius
    wanted = change[:, column] / cylinder.radius
    found = scan(marked, scheme.grid, cylinder).ranges[:, column] / cylinder.radius - before
    blind = scan(marked, scheme.grid).ranges[:, column] / cylinder.radius - before
    factor = nice(0.15 / np.abs(wanted).max())
    figure = Figure(figsize=(7.2, 4.2))
    figure.subplots_adjust(left=0.07, right=0.98, top=0.93, bottom=0.31, wspace=0.12)
    first, second, third = figure.subplots(1, 3, sharey=True)
    for panel, ranges in ((first, before), (second, before + factor * found)):
        panel.hlines(heights, 0, ranges, color=GREY, linewidth=0.35)
        panel.axvline(1, color=GREY, linewidth=0.7, linestyle=(0, (6, 2, 1, 2)))
        panel.set(xlim=(0, 1.25), ylim=(0, 1), xlabel="range l / r", xticks=[0, 0.5, 1])
    dots = {"color": BLUE, "linestyle": "", "markersize": 3.5, "markeredgewidth": 0.5}
    original, wish, again, blindly = (
        {"color": "0.25", "linewidth": 0.8, "label": "original surface"},
        {"color": RED, "linewidth": 0.9, "label": "wanted, l + Δl"},
        dots | {"marker": ".", "label": "marked mesh, same cylinder"},
        dots | {"marker": "o", "label": "marked mesh, posed again", "fillstyle": "none"},
    )  # fmt: skip
    first.plot(before, heights, **original)
    second.plot(before, heights, **original)
    second.plot(before + factor * wanted, heights, **wish)
    second.plot(before + factor * found, heights, **again)
    per_mille = 1000 * cylinder.radius / marked.diagonal
    third.axvline(0, **original)
    third.plot(per_mille * wanted, heights, **wish)
    third.plot(per_mille * found, heights, **again)
    third.plot(per_mille * blind, heights, **blindly)
    first.set(ylabel="height along s₁ / h", title="before")
    second.set_title(f"after, change of range × {factor}")
    third.set(title="change of range", xlabel="‰ of the diagonal")
    figure.legend(
        *third.get_legend_handles_labels(),
        loc="lower center",
        bbox_to_anchor=(0.52, 0.155),
        ncols=4,
        fontsize=7,
    )
    return figure, (
        f"The rays of column v = {column} in the u-direction before and after marking; dash-dotted: axis. "
        "Posed again, the cylinder has another radius if the outermost vertex moved; all ranges shift alike."
    )


def telling_column(image: RangeImage, change: FloatArray) -> int:
    """Return the column with the fewest rays that meet nothing; of several the most changed."""
    misses = np.isnan(image.ranges).sum(axis=0)
    moved = np.where(misses == misses[change.any(axis=0)].min(), (change**2).sum(axis=0), -1)
    return int(moved.argmax())


def nice(value: float) -> int:
    """Round down to 1, 2 or 5 times a power of ten."""
    decade = 10 ** np.floor(np.log10(value))
    return int(decade * max(step for step in (1, 2, 5) if step * decade <= value))


def before_and_after(mesh: Mesh, marked: Mesh, cylinder: Cylinder) -> tuple[Figure, str]:
    """Fig. 5: the two models, and how far each vertex moved along its ray."""
    away = wall_direction(mesh, cylinder)
    moved = 100 * np.einsum("ij,ij->i", marked.vertices - mesh.vertices, away) / mesh.diagonal
    reach = float(np.percentile(np.abs(moved), 99))
    scale = ScalarMappable(Normalize(-reach, reach), "RdBu_r")
    axes = upright(cylinder, TURN, TILT)
    extent = np.ptp(mesh.vertices @ axes.T, axis=0)
    width = 2.0
    tall = min(width * 1.03 * extent[1] / extent[0], 3.1)
    figure = Figure(figsize=(6.8, tall + CAPTION_INCHES + 0.24))
    view = View.around(mesh.vertices, axes, (int(tall * DPI), int(width * DPI)), margin=0.01)
    pictures = {
        "original": render(mesh, view),
        "marked": render(marked, view),
        "displacement": render(marked, view, colors=scale.to_rgba(moved)[:, :3]),
    }
    inches = np.array([*figure.get_size_inches()] * 2)
    for k, (title, picture) in enumerate(pictures.items()):
        panel = figure.add_axes(np.array([0.05 + k * (width + 0.05), CAPTION_INCHES, width, tall]) / inches)
        show(panel, picture)
        panel.set_title(title, fontsize=8)
    bar = figure.colorbar(
        scale, cax=figure.add_axes(np.array([6.28, CAPTION_INCHES + 0.15 * tall, 0.09, 0.7 * tall]) / inches)
    )
    bar.ax.set_title("% of the\ndiagonal", fontsize=6)
    bar.ax.tick_params(labelsize=6)
    return figure, (
        "The model before and after marking; red vertices moved away from the axis, blue ones towards it "
        f"(99 % of them by at most {reach:.3f} % of the diagonal)."
    )


def wall_direction(mesh: Mesh, cylinder: Cylinder) -> FloatArray:
    """Return the unit vector from the axis to each vertex, (n, 3)."""
    _, across, depth = cylinder.posed(mesh).T
    angle = np.arctan2(across, depth)
    _, s2, s3 = cylinder.axes
    direction: FloatArray = np.sin(angle)[:, None] * s2 + np.cos(angle)[:, None] * s3
    return direction


def picture_panel(
    mesh: Mesh, cylinder: Cylinder, around: FloatArray, width: float, height: float, share: float = 1.0
) -> tuple[Figure, Axes, Picture]:
    """Return a figure in inches whose left share shows the model, with room for a caption below."""
    figure = Figure(figsize=(width, height))
    tall = height - CAPTION_INCHES
    panel = figure.add_axes((0, CAPTION_INCHES / height, share, tall / height))
    picture = portrait(mesh, cylinder, (int(tall * DPI), int(share * width * DPI)), around)
    show(panel, picture)
    return figure, panel, picture


def arguments() -> dict[str, Any]:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mesh", default="bunny", help="dataset name or mesh file")
    parser.add_argument("--grid", default="84x84", help="columns around x rows along the axis")
    parser.add_argument("--region", default="2,0,80,80", help="first row, first column, rows, columns")
    parser.add_argument("--alpha", type=float, default=1.3)
    parser.add_argument("--out", type=Path, default=OUT)
    given = parser.parse_args()
    columns, rows = map(int, given.grid.split("x"))
    region = tuple(map(int, given.region.split(",")))
    return {
        "name": given.mesh,
        "scheme": Song2002(grid=(columns, rows), region=region, alpha=given.alpha),
        "out": given.out,
    }


if __name__ == "__main__":
    main(**arguments())
