"""The picture of a range image that `wm3d scan` writes."""

import io
import warnings

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from wm3d.scanner import RangeImage

MISS_COLOR = "0.8"
"""Grey of a ray that meets nothing; viridis holds no grey."""

WIDTH = 7.0
"""Of the picture, in inches."""


def range_picture(image: RangeImage, title: str) -> bytes:
    """Return a PNG of a range image: columns to the right, rows along s1 upwards, near faces bright.

    Parameters
    ----------
    image : RangeImage
    title : str
        What the heading calls the mesh.
    """
    columns, rows = image.grid
    shape = rows / columns
    figure = Figure(figsize=(WIDTH, min(max(0.8 * WIDTH * shape, 3.0), 12.0) + 1.0), layout="constrained")
    axes = figure.add_subplot()
    drawn = axes.imshow(
        image.ranges / image.cylinder.radius,
        cmap=colormaps["viridis_r"].with_extremes(bad=MISS_COLOR),
        origin="lower",
        interpolation="nearest",
        aspect="equal" if 0.2 < shape < 5 else "auto",
    )
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(integer=True))
    axes.set_title(title, parse_math=False)  # a file name may hold dollars
    axes.set_xlabel("column v, around the axis")
    axes.set_ylabel("row u, along s1")
    figure.colorbar(drawn, label="range l / r")
    if np.isnan(image.ranges).any():
        figure.legend(handles=[Patch(color=MISS_COLOR, label="meets nothing")], loc="outside lower right")
    stream = io.BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings(
            "ignore", message="Glyph .* missing from font"
        )  # of a title in another script
        FigureCanvasAgg(figure)
        # a pixel of the picture for every ray, up to a size that viewers can open
        figure.savefig(stream, format="png", dpi=min(max(150, 1.5 * max(columns, rows) / WIDTH), 1200))
    return stream.getvalue()
