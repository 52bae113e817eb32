"""Parts added: where base and ball lie, and that they are wound like the model."""

import numpy as np
import pytest
from shapes import box, inside_out

from wm3d.attacks import Attack
from wm3d.attacks.added import MARGIN, Companion, Pedestal
from wm3d.mesh import Mesh, is_closed, signed_volume


def added_to(model: Mesh, attack: Attack) -> Mesh:
    """Return what an attack adds to a box, which itself must stay."""
    result = attack(model, np.random.default_rng(0))
    np.testing.assert_array_equal(result.vertices[:8], model.vertices)
    np.testing.assert_array_equal(result.faces[:12], model.faces)
    return Mesh(result.vertices[8:], result.faces[12:] - 8)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_model_stands_on_a_box_of_the_given_height(axis):
    pedestal = added_to(box((2, 3, 4)), Pedestal(percent=20, axis="xyz"[axis]))
    extent = np.array([2.0, 3.0, 4.0])
    expected = (1 + 2 * MARGIN) * extent
    expected[axis] = 0.2 * extent[axis]
    np.testing.assert_allclose(np.ptp(pedestal.vertices, axis=0), expected)
    assert pedestal.vertices[:, axis].max() == pytest.approx(-extent[axis] / 2 + MARGIN * expected[axis])
    assert is_closed(pedestal)
    assert signed_volume(pedestal) == pytest.approx(expected.prod())


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_ball_of_the_given_diameter_lies_behind_the_model(axis):
    model = box((2, 3, 4))
    ball = added_to(model, Companion(percent=200, axis="xyz"[axis]))
    radius = model.diagonal
    assert np.ptp(ball.vertices, axis=0) == pytest.approx(3 * [2 * radius], rel=1e-3)
    assert signed_volume(ball) == pytest.approx(4 / 3 * np.pi * radius**3, rel=2e-3)
    middle = np.zeros(3)
    middle[axis] = (2, 3, 4)[axis] / 2 + MARGIN * model.diagonal + radius
    np.testing.assert_allclose((ball.vertices.min(axis=0) + ball.vertices.max(axis=0)) / 2, middle, atol=1e-3)


def test_what_is_added_to_an_inward_wound_model_is_wound_inward():
    for attack in (Pedestal(), Companion()):
        assert signed_volume(added_to(inside_out(box()), attack)) < 0
