"""An unwelded mesh is the same surface: attacks and metrics that look at neighbours do the same to it."""

import numpy as np
import pytest
from shapes import blob, soup

from wm3d.attacks import (
    GaussianNoise,
    IsotropicRemesh,
    LaplacianSmoothing,
    PrintScan,
    Simplify,
    Subdivide,
    TaubinSmoothing,
    UniformNoise,
)
from wm3d.mesh import Mesh, places, sewn, surface_area
from wm3d.metrics import msdm, msdm2
from wm3d.schemes import SCHEMES

WHOLE = blob(1, 3)
UNWELDED = soup(WHOLE)


def rng() -> np.random.Generator:
    return np.random.default_rng(4)


def test_sewing_keeps_the_order_and_a_mesh_without_seams():
    surface, place = sewn(UNWELDED)
    np.testing.assert_array_equal(surface.vertices[place], UNWELDED.vertices)
    np.testing.assert_array_equal(surface.vertices[surface.faces], WHOLE.vertices[WHOLE.faces])
    np.testing.assert_array_equal(
        np.unique(place, return_index=True)[1], np.sort(places(UNWELDED.vertices)[0])
    )
    assert sewn(WHOLE).mesh is WHOLE


@pytest.mark.parametrize("far", [0.0, 1e7])
def test_vertices_far_from_the_origin_share_no_place(far):
    assert len(places(WHOLE.vertices + far * WHOLE.diagonal)[0]) == len(WHOLE.vertices)


@pytest.mark.parametrize("attack", [LaplacianSmoothing(iterations=10), TaubinSmoothing()])
def test_smoothing_moves_an_unwelded_surface_as_a_welded_one(attack):
    wanted = attack(WHOLE, rng()).vertices[WHOLE.faces]
    np.testing.assert_allclose(attack(UNWELDED, rng()).vertices.reshape(-1, 3, 3), wanted, atol=1e-12)


@pytest.mark.parametrize("attack", [GaussianNoise(percent=1), UniformNoise(percent=1), PrintScan()])
def test_noise_tears_no_seam(attack):
    noisy = attack(UNWELDED, rng())
    assert len(places(noisy.vertices)[0]) == len(WHOLE.vertices)
    np.testing.assert_array_equal(sewn(noisy).mesh.faces, sewn(UNWELDED).mesh.faces)


@pytest.mark.parametrize(
    "attack",
    [
        Simplify(ratio=0.3),
        Simplify(ratio=0.3, simplifier="pymeshlab-quadric"),
        Simplify(ratio=0.3, simplifier="clustering"),
        Subdivide(rule="loop"),
        Subdivide(rule="sqrt3"),
        IsotropicRemesh(),
    ],
    ids=lambda attack: attack.label(),
)
def test_what_makes_another_mesh_makes_it_of_the_welded_one(attack):
    wanted, made = attack(WHOLE, rng()), attack(UNWELDED, rng())
    assert len(made.faces) == pytest.approx(len(wanted.faces), rel=0.05)  # the order of vertices matters
    assert len(sewn(made).mesh.vertices) == len(made.vertices)
    assert surface_area(made) == pytest.approx(surface_area(wanted), rel=0.01)


@pytest.mark.parametrize("metric", [msdm, msdm2])
def test_perceptual_metrics_see_the_welded_surface(metric):
    moved = GaussianNoise(percent=0.5)(WHOLE, rng())
    torn = Mesh(moved.vertices[WHOLE.faces].reshape(-1, 3), UNWELDED.faces)
    assert metric(UNWELDED, torn) == pytest.approx(metric(WHOLE, moved), rel=1e-6)


def test_radial_area_tears_no_seam():
    marked, _ = SCHEMES.build("radial-area", {"bits": 16}).embed(UNWELDED, 1)
    assert len(places(marked.vertices)[0]) == len(WHOLE.vertices)
