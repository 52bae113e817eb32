"""PSNR and the change of volume: analytic values."""

import math

import numpy as np
import pytest
from shapes import box, icosphere, inside_out

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import psnr, volume_change


def test_psnr_of_a_shift() -> None:
    """A cube of side 1 has the diagonal √3; a shift by √3 / 10 is 20 dB below it."""
    shifted = box().with_vertices(box().vertices + np.array([math.sqrt(3) / 10, 0, 0]))
    assert psnr(box(), shifted) == pytest.approx(20)
    assert psnr(box(), box()) == math.inf


def test_vertices_that_no_face_uses_are_no_part_of_the_surface() -> None:
    stray = Mesh(np.vstack([box().vertices, np.full((24, 3), 0.5)]), box().faces)
    moved = np.where(np.arange(32)[:, None] < 8, [math.sqrt(3) / 10, 0, 0], 0.0)
    assert psnr(stray, stray.with_vertices(stray.vertices + moved)) == pytest.approx(20)


def test_psnr_needs_the_same_vertices() -> None:
    with pytest.raises(Wm3dError, match="8 vertices and icosphere has 642"):
        psnr(box(), icosphere())


def test_volume_change_is_that_of_the_scale_for_either_winding() -> None:
    larger = box((1.1, 1, 1))
    assert volume_change(box(), larger) == pytest.approx(10)
    assert volume_change(inside_out(box()), inside_out(larger)) == pytest.approx(10)
    assert volume_change(larger, box()) == pytest.approx(-100 / 11)
    assert volume_change(box(), inside_out(box())) == pytest.approx(-200)


def test_volume_change_needs_a_volume() -> None:
    sheet = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], name="sheet")
    with pytest.raises(Wm3dError, match="sheet: its faces enclose no volume"):
        volume_change(sheet, box())
