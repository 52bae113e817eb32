"""The heat map: the numbers of the table in their places, colours that mean lost and found."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PatchCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from wm3d.bench.heatmap import BETWEEN, FOUND, LOST, REFUSED, UNTRIED, heatmap_figure

PF = 1e-6
MESHES = "longer than its columns", "cow"
Z_AT_PF = 4.753424


def detection(*lines: tuple[str, str, str, float, float]) -> pd.DataFrame:
    """Table of (mesh, scheme, attack, Pd, d')."""
    table = pd.DataFrame(lines, columns=["mesh", "scheme", "attack", "pd_1e-06", "d_prime"])
    return table.assign(trials=8, sigma_percent=np.nan)


def texts(figure: Figure, panel: int) -> list[str]:
    """Numbers of a panel, line by line."""
    return [text.get_text() for text in figure.axes[panel].texts]


def colors(figure: Figure, panel: int) -> list[str]:
    (cells,) = (c for c in figure.axes[panel].collections if isinstance(c, PatchCollection))
    return [to_hex(color) for color in cells.get_facecolor()]


def headings(figure: Figure) -> list[str]:
    return [label.get_text() for label in figure.axes[0].get_xticklabels()]


def test_cells_hold_the_numbers_of_the_table_and_the_colours_of_the_verdict():
    table = detection(
        ("m", "s", "clean", 1.0, 20.0),
        ("m", "s", "noise", 0.999, Z_AT_PF),
        ("m", "s", "crop", 0.0, -0.01),
        ("m", "s", "failed", np.nan, np.nan),
    )
    figure = heatmap_figure(table, PF, {})
    assert texts(figure, 0) == ["1", "0.99", "0", "–"]  # 1 is said only where no key was missed
    assert texts(figure, 1) == ["20.0", "4.8", "0.0", "–"]
    assert colors(figure, 0)[::2] == [FOUND, LOST]
    assert colors(figure, 1) == [FOUND, pytest.approx(BETWEEN), LOST, UNTRIED]


def test_a_mesh_that_was_refused_is_not_shown_as_a_mark_that_was_lost():
    table = detection(("m", "s", "clean", 1.0, 20.0), ("n", "s", "clean", 0.0, 0.0)).assign(refused=[0, 8])
    figure = heatmap_figure(table, PF, {})
    assert texts(figure, 0) == ["1", REFUSED]
    assert colors(figure, 1) == [FOUND, UNTRIED]


def test_schemes_on_one_mesh_stand_side_by_side_and_what_was_not_tried_is_blank():
    table = detection(
        ("bun", "a", "clean", 0.11, 1.0),
        ("cow", "a", "clean", 0.12, 2.0),
        ("bun", "b", "clean", 0.21, 3.0),
        ("cow", "b", "crop", 0.22, 4.0),
    )
    figure = heatmap_figure(table, PF, {})
    assert headings(figure) == ["a", "b", "a", "b"]
    assert texts(figure, 0) == ["0.11", "0.21", "0.12", "–", "–", "–", "–", "0.22"]
    (groups,) = figure.axes[0].child_axes
    assert [label.get_text() for label in groups.get_xticklabels()] == ["bun", "cow"]


@pytest.mark.parametrize(
    ("meshes", "schemes", "wanted"),
    [
        (["bun", "cow"], ["s"], ["bun", "cow"]),
        (["bun"], ["s", "t"], ["s", "t"]),
        (MESHES, ["s", "t"], [f"{m}, {s}" for m in MESHES for s in "st"]),
    ],
    ids=["one scheme", "one mesh", "no room for groups"],
)
def test_columns_are_named_by_what_tells_them_apart(meshes, schemes, wanted):
    lines = [(mesh, scheme, "clean", 1.0, 9.0) for mesh in meshes for scheme in schemes]
    assert headings(heatmap_figure(detection(*lines), PF, {})) == wanted


def test_noise_is_named_with_its_range_over_the_meshes():
    table = detection(("bun", "s", "noise 0.5", 1.0, 9.0), ("cow", "s", "noise 0.5", 1.0, 9.0))
    figure = heatmap_figure(table.assign(sigma_percent=[0.0772, 0.0722]), PF, {})
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["noise 0.5 (σ 0.072–0.077 %)"]
