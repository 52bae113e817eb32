"""A base glued on: where the box lies, and that it is wound like the model."""

import numpy as np
import pytest
from shapes import box, inside_out

from wm3d.attacks.pedestal import MARGIN, Pedestal
from wm3d.mesh import Mesh, is_closed, signed_volume


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_model_stands_on_a_box_of_the_given_height(axis):
    model = box((2, 3, 4))
    result = Pedestal(percent=20, axis="xyz"[axis])(model, np.random.default_rng(0))
    np.testing.assert_array_equal(result.vertices[:8], model.vertices)
    np.testing.assert_array_equal(result.faces[:12], model.faces)
    extent = np.array([2.0, 3.0, 4.0])
    expected = (1 + 2 * MARGIN) * extent
    expected[axis] = 0.2 * extent[axis]
    added = result.vertices[8:]
    np.testing.assert_allclose(np.ptp(added, axis=0), expected)
    assert added[:, axis].max() == pytest.approx(-extent[axis] / 2 + MARGIN * expected[axis])
    pedestal = Mesh(added, result.faces[12:] - 8)
    assert is_closed(pedestal)
    assert signed_volume(pedestal) == pytest.approx(expected.prod())


def test_base_of_an_inward_wound_model_is_wound_inward():
    result = Pedestal()(inside_out(box()), np.random.default_rng(0))
    assert signed_volume(Mesh(result.vertices[8:], result.faces[12:] - 8)) < 0
