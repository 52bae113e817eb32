"""Quantization: levels, error and idempotence on both grids; float32 by its definition."""

import sys
from collections import Counter

import numpy as np
import pytest
from shapes import blob, box

from wm3d.attacks import Draco, Float32, Quantize
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

RNG = np.random.default_rng(0)
MESH = blob(3, 5)
EXTENT = np.ptp(MESH.vertices, axis=0)


@pytest.mark.parametrize("bits", [4, 7, 11])
@pytest.mark.parametrize(
    ("grid", "levels", "step"),
    [
        ("per-axis", lambda r: 2**r + 1, lambda r: EXTENT / 2**r),
        ("cubic", lambda r: 2**r, lambda r: np.full(3, EXTENT.max() / (2**r - 1))),
    ],
)
def test_coordinates_lie_on_the_levels_at_most_half_a_step_away(grid, bits, levels, step):
    result = Quantize(bits=bits, grid=grid)(MESH, RNG)
    offset = (result.vertices - MESH.vertices.min(axis=0)) / step(bits)
    np.testing.assert_allclose(offset, np.round(offset), atol=1e-9)
    assert offset.max() < levels(bits)
    assert (np.abs(result.vertices - MESH.vertices) <= step(bits) * (0.5 + 1e-9)).all()
    np.testing.assert_array_equal(result.faces, MESH.faces)


def test_bounding_box_stays_and_a_second_time_changes_nothing():
    once = Quantize(bits=8)(MESH, RNG)
    np.testing.assert_allclose(np.ptp(once.vertices, axis=0), EXTENT, rtol=1e-12)
    np.testing.assert_allclose(Quantize(bits=8)(once, RNG).vertices, once.vertices, atol=1e-12)


def test_a_flat_axis_keeps_its_one_level():
    flat = Mesh(box().vertices * [1, 1, 0] + [0, 0, 0.3], box().faces)
    assert set(Quantize(bits=3)(flat, RNG).vertices[:, 2]) == {0.3}


def test_draco_moves_vertices_as_the_cubic_grid_does():
    pytest.importorskip("DracoPy")
    by_codec, by_grid = Draco(bits=10)(MESH, RNG), Quantize(bits=10, grid="cubic")(MESH, RNG)
    assert by_codec.faces.shape == MESH.faces.shape
    step = EXTENT.max() / 1023
    of_codec, of_grid = (
        Counter(map(tuple, np.round((mesh.vertices - MESH.vertices.min(axis=0)) / step).astype(int)))
        for mesh in (by_codec, by_grid)
    )
    # float32 before the grid: a coordinate halfway between levels may go either way
    assert (of_codec & of_grid).total() > 0.998 * len(MESH.vertices)


def test_draco_that_is_not_installed_is_refused_with_a_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "DracoPy", None)
    with pytest.raises(Wm3dError, match=r"pip install DracoPy"):
        Draco()(MESH, RNG)


def test_float32_rounds_to_the_nearest():
    result = Float32()(MESH, RNG)
    np.testing.assert_array_equal(result.vertices, MESH.vertices.astype(np.float32).astype(float))
    assert np.abs(result.vertices / MESH.vertices - 1).max() <= 2.0**-24
