"""Parts that the pictures of models share: cylinder, range image, wanted change."""

import io
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from wm3d import Mesh
from wm3d.arrays import FloatArray
from wm3d.bench.figures import COLORS, STYLE
from wm3d.bench.render import Picture, View, render, upright
from wm3d.imagemarks import DctAdditive
from wm3d.mesh import datasets, write_whole
from wm3d.scanner import Cylinder, RangeImage, scan
from wm3d.schemes import Song2002
from wm3d.schemes.movement import move_vertices, radial_normals

TURN, TILT = 15.0, 12.0
"""Side of the cylinder that faces the viewer, and how far the viewer looks down, in degrees."""

BLUE, RED = COLORS[:2]
GREY = "#70757a"
DPI = 200

PAPER_STYLE: dict[str, Any] = STYLE | {
    "axes.grid": False,
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "font.size": 8,
}
mpl.rcParams.update(PAPER_STYLE)


def wall(cylinder: Cylinder, heights: ArrayLike, angles: ArrayLike, radius: float = 1.0) -> FloatArray:
    """Return points on a cylinder, (..., 3): heights along s1 from m, angles from s3 towards s2."""
    h, phi = np.broadcast_arrays(np.asarray(heights, float), np.asarray(angles, float))
    s1, s2, s3 = cylinder.axes
    around = np.cos(phi)[..., None] * s3 + np.sin(phi)[..., None] * s2
    return cylinder.center + h[..., None] * s1 + radius * cylinder.radius * around


def outline(cylinder: Cylinder) -> FloatArray:
    """Return points that a view of the whole cylinder must contain."""
    phi = np.linspace(0, 2 * np.pi, 73)
    return np.vstack([wall(cylinder, height, phi) for height in (cylinder.hmin, cylinder.hmax)])


def portrait(
    mesh: Mesh, cylinder: Cylinder, size: tuple[int, int], around: FloatArray | None = None, **looks: Any
) -> Picture:
    """Render a model upright; `around` is what the view must contain, by default the model."""
    axes = upright(cylinder, TURN, TILT)
    view = View.around(mesh.vertices if around is None else around, axes, size, margin=0.01)
    return render(mesh, view, **looks)


def show(panel: Axes, picture: Picture) -> None:
    """Put a rendered model into a panel whose coordinates are the picture's pixels."""
    height, width = picture.view.size
    panel.imshow(few_levels(picture.image), extent=(0, width, height, 0), interpolation="none")
    panel.set(xlim=(0, width), ylim=(height, 0))
    panel.set_axis_off()


def few_levels(image: FloatArray) -> NDArray[np.uint8]:
    """Return the image with 64 levels a channel: no eye sees it, and files are half as large."""
    return (255 / 63 * np.rint(63 * image)).astype(np.uint8)


def draw(
    panel: Axes, picture: Picture, points: FloatArray, hidden: dict[str, Any] | None = None, **style: Any
) -> None:
    """Draw a polyline of space; what the model hides is left out, or drawn in the style `hidden`."""
    seen = picture.view.project(points)[:, :2]
    behind = picture.hides(points)
    panel.plot(*np.where(behind[:, None], np.nan, seen).T, **style)
    if hidden is not None:
        # from the last visible point to the first, so that the two parts meet
        near = behind | np.roll(behind, 1) | np.roll(behind, -1)
        panel.plot(*np.where(near[:, None], seen, np.nan).T, **(style | hidden))


def draw_cylinder(panel: Axes, picture: Picture, cylinder: Cylinder, **style: Any) -> None:
    """Draw the ends of the cylinder and the two sides of its outline; the far half is thinner."""
    look = {"color": GREY, "linewidth": 0.9, "solid_capstyle": "round"} | style
    _, _, toward = picture.view.axes
    _, s2, s3 = cylinder.axes
    facing = np.arctan2(toward @ s2, toward @ s3)
    for height in (cylinder.hmin, cylinder.hmax):
        near, far = (
            wall(cylinder, height, facing + side + np.linspace(-1, 1, 181) * np.pi / 2) for side in (0, np.pi)
        )
        panel.plot(*picture.view.project(near)[:, :2].T, **look)
        draw(panel, picture, far, **(look | {"linewidth": 0.5 * look["linewidth"]}))
    for side in (-np.pi / 2, np.pi / 2):
        ends = wall(cylinder, [cylinder.hmin, cylinder.hmax], facing + side)
        panel.plot(*picture.view.project(ends)[:, :2].T, **look)


def show_ranges(panel: Axes, image: RangeImage, region: tuple[int, int, int, int] | None = None) -> AxesImage:
    """Show a range image, near bright, rows upwards as along s1; rays that miss are pale blue."""
    grey = ListedColormap(mpl.colormaps["gray_r"](np.linspace(0.05, 0.9, 256))).with_extremes(bad="#cfe4f3")
    rows, columns = image.ranges.shape
    shown = panel.imshow(
        image.ranges / image.cylinder.radius, cmap=grey, origin="lower", interpolation="nearest",
        extent=(0, columns, 0, rows),
    )  # fmt: skip
    if region is not None:
        top, left, height, width = region
        panel.add_patch(Rectangle((left, top), width, height, fill=False, edgecolor=BLUE, linewidth=1.4))
    return shown


def wanted_change(scheme: Song2002, mesh: Mesh, seed: int) -> tuple[RangeImage, FloatArray, Mesh]:
    """Mark a mesh step by step (section III-A), with the readings `far-wall` and `region`.

    Returns
    -------
    image : RangeImage
        l, of the mesh as it is.
    change : (N_u, N_v) ndarray
        Δl = l̃ − l (eq. 8), in mesh units; 0 outside the region.
    marked : Mesh
        The mesh whose vertices followed.
    """
    image = scan(mesh, scheme.grid)
    top, left, height, width = scheme.region
    window = (slice(top, top + height), slice(left, left + width))
    ranges = np.nan_to_num(image.ranges, nan=2 * image.cylinder.radius)[window]
    level = np.ptp(ranges) / 255
    grey = (ranges - ranges.min()) / level
    mark = DctAdditive(alpha=scheme.alpha, detector=scheme.detector)
    change = np.zeros_like(image.ranges)
    change[window] = (mark.embed(grey, scheme.signs(seed)) - grey) * level
    posed = image.cylinder.posed(mesh)
    marked = move_vertices(mesh, posed, radial_normals(mesh, posed), image.cylinder, change)
    return image, change, marked


def credit_line(name: str) -> str:
    """Return the credit that a caption must carry, as a sentence; empty where none is owed."""
    owed = datasets.credit(name)
    return f"Model: {owed}." if owed else ""


def save(figure: Figure, path: Path) -> None:
    """Write a figure in the format of its ending, the same bytes for the same figure."""
    buffer = io.BytesIO()
    if path.suffix == ".png":
        figure.savefig(buffer, format="png")
        smaller = Image.open(buffer).convert("RGB")
        smaller.save(buffer := io.BytesIO(), format="png", optimize=True)
    else:
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        figure.savefig(buffer, format="svg", metadata=nothing)
    write_whole(path, buffer.getvalue())
