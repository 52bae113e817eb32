"""Smoothing: a plane stays, a tetrahedron shrinks by a known factor, Taubin's steps keep the volume."""

import numpy as np
import pytest
from shapes import blob, box, icosphere, tetrahedron

from wm3d.attacks import LaplacianSmoothing, TaubinSmoothing
from wm3d.mesh import Mesh, signed_volume

RNG = np.random.default_rng(0)


def test_one_step_is_that_of_its_definition():
    mesh = blob(1, 2)
    neighbours = [
        set(mesh.faces[(mesh.faces == i).any(axis=1)].ravel()) - {i} for i in range(len(mesh.vertices))
    ]
    means = np.array([mesh.vertices[sorted(near)].mean(axis=0) for near in neighbours])
    expected = mesh.vertices + 0.1 * (means - mesh.vertices)
    np.testing.assert_allclose(LaplacianSmoothing(iterations=1)(mesh, RNG).vertices, expected, atol=1e-15)


def test_steps_on_a_tetrahedron_shrink_it_by_one_minus_four_thirds_lambda():
    mesh = tetrahedron()
    center = mesh.vertices.mean(axis=0)
    smooth = LaplacianSmoothing(iterations=7, weight=0.1)(mesh, RNG)
    np.testing.assert_allclose(
        smooth.vertices - center, (1 - 0.4 / 3) ** 7 * (mesh.vertices - center), atol=1e-15
    )


def test_inside_of_a_regular_grid_stays():
    side = 6
    x, y = (axis.ravel().astype(float) for axis in np.meshgrid(np.arange(side), np.arange(side)))
    corners = [r * side + c for r in range(side - 1) for c in range(side - 1)]
    faces = [[i, i + 1, i + side] for i in corners] + [[i + 1, i + side + 1, i + side] for i in corners]
    mesh = Mesh(np.column_stack([x, y, 0 * x]), faces)
    inside = (x > 0) & (x < side - 1) & (y > 0) & (y < side - 1)
    once = LaplacianSmoothing(iterations=1)(mesh, RNG)
    np.testing.assert_allclose(once.vertices[inside], mesh.vertices[inside], atol=1e-15)
    assert np.abs(once.vertices[~inside] - mesh.vertices[~inside]).max() > 0.01


def test_a_vertex_without_faces_stays():
    mesh = Mesh(np.vstack([box().vertices, [[5, 5, 5]]]), box().faces)
    np.testing.assert_array_equal(LaplacianSmoothing()(mesh, RNG).vertices[-1], [5, 5, 5])


def test_taubin_steps_keep_the_volume_that_laplacian_steps_lose():
    mesh = icosphere(3)
    volume = signed_volume(mesh)
    assert signed_volume(TaubinSmoothing(iterations=25)(mesh, RNG)) == pytest.approx(volume, rel=0.03)
    assert signed_volume(LaplacianSmoothing(iterations=25, weight=0.5)(mesh, RNG)) < 0.85 * volume
