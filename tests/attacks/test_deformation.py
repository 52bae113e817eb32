"""Deformations: exact on an axis-parallel column, volume kept where calculus says so, the centre fixed."""

import numpy as np
import pytest
from shapes import box, uv_cylinder

from wm3d.attacks import Bend, Shear, Stretch, Twist
from wm3d.mesh import Mesh, signed_volume

RNG = np.random.default_rng(0)
COLUMN = uv_cylinder(radius=0.2, height=2.0, around=96, along=96)
ALL = [Stretch(percent=20), Shear(percent=20), Bend(degrees=40), Twist(degrees=40)]


def test_stretch_is_along_its_axis_alone():
    result = Stretch(percent=-25, axis="y")(box((3, 2, 1)), RNG)
    np.testing.assert_allclose(np.ptp(result.vertices, axis=0), [3, 1.5, 1], rtol=1e-15)


def test_shear_slides_x_in_proportion_to_z():
    mesh = box((1, 1, 1))
    moved = Shear(percent=30)(mesh, RNG).vertices - mesh.vertices
    np.testing.assert_allclose(moved, 0.3 * mesh.vertices[:, [2]] * [1, 0, 0], atol=1e-15)


def test_twist_keeps_the_axis_the_heights_and_the_radii_and_turns_the_ends():
    result = Twist(degrees=90)(COLUMN, RNG)
    np.testing.assert_array_equal(result.vertices[-2:], COLUMN.vertices[-2:])  # the poles of the axis
    np.testing.assert_array_equal(result.vertices[:, 2], COLUMN.vertices[:, 2])
    complex_in, complex_out = (m.vertices[:-2, 0] + 1j * m.vertices[:-2, 1] for m in (COLUMN, result))
    # 90° over a height of 2, from −45° to 45°
    np.testing.assert_allclose(
        complex_out, complex_in * np.exp(1j * np.radians(45) * COLUMN.vertices[:-2, 2]), atol=1e-14
    )


def test_bend_puts_the_axis_on_an_arc_of_its_length():
    result = Bend(degrees=90)(COLUMN, RNG)
    radius = 2.0 / (np.pi / 2)
    ends, half = result.vertices[-2:], np.pi / 4
    across = radius * (1 - np.cos(half))
    expected = [[across, 0, -radius * np.sin(half)], [across, 0, radius * np.sin(half)]]
    np.testing.assert_allclose(ends, expected, atol=1e-14)
    # every distance from the centre of the arc, in the plane of the arc, is the old one from its axis
    distance = np.hypot(result.vertices[:, 0] - radius, result.vertices[:, 2])
    np.testing.assert_allclose(distance, radius - COLUMN.vertices[:, 0], atol=1e-14)


def test_a_slight_bend_is_a_parabola():
    result = Bend(degrees=1e-6)(COLUMN, RNG)
    sag = 0.5 * (np.radians(1e-6) / 2) * COLUMN.vertices[:, 2] ** 2
    np.testing.assert_allclose(result.vertices[:, 0] - COLUMN.vertices[:, 0], sag, atol=1e-16, rtol=1e-6)


@pytest.mark.parametrize("attack", ALL, ids=lambda attack: attack.label())
def test_volume_changes_by_the_determinant(attack):
    # the axis of the column is its line of gravity, so bending keeps its volume (Pappus)
    factor = 1.2 if isinstance(attack, Stretch) else 1.0
    assert signed_volume(attack(COLUMN, RNG)) == pytest.approx(factor * signed_volume(COLUMN), rel=1e-3)


@pytest.mark.parametrize("attack", ALL, ids=lambda attack: attack.label())
def test_axes_are_alike_and_the_place_does_not_matter(attack):
    mesh = box((3, 2, 1))
    place = np.array([5.0, -7, 9])
    for k, axis in enumerate("xyz"):
        turned = np.roll(mesh.vertices, k + 1, axis=1)  # the axis z becomes x, then y, then z
        result = attack.model_copy(update={"axis": axis})(Mesh(turned + place, mesh.faces), RNG)
        expected = np.roll(attack(mesh, RNG).vertices, k + 1, axis=1)
        np.testing.assert_allclose(result.vertices - place, expected, atol=1e-14)


@pytest.mark.parametrize("attack", ALL, ids=lambda attack: attack.label())
def test_a_sheet_across_the_axis_is_no_special_case(attack):
    sheet = Mesh(box().vertices * [1, 1, 0], box().faces)
    np.testing.assert_allclose(attack(sheet, RNG).vertices, sheet.vertices, atol=1e-15)
