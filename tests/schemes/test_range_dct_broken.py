"""The robust scheme on broken files and on symmetric models: the mark is read as from a sound, odd one."""

import numpy as np
import pytest
from plain import plain_z
from shapes import blob, fine_box, icosphere, inside_out, together

from wm3d.attacks import (
    Attack,
    Chain,
    DropFaces,
    FlipFaces,
    GaussianNoise,
    RepeatFaces,
    RoundTrip,
    Similarity,
)
from wm3d.mesh import Mesh, signed_volume
from wm3d.schemes import SCHEMES

SCHEME = SCHEMES.build("range-dct", {})
MESH = blob(0, 5)


def stored_beside(mesh: Mesh) -> Mesh:
    """Return the mesh with a copy of itself next to nothing away."""
    moved = mesh.vertices + 1e-9 * mesh.diagonal
    return Mesh(np.vstack([mesh.vertices, moved]), np.vstack([mesh.faces, mesh.faces + len(moved)]))


@pytest.mark.parametrize(
    "broken",
    [
        DropFaces(percent=10),
        FlipFaces(percent=50),
        RepeatFaces(percent=100),
        RepeatFaces(percent=100, turned=True),
        Chain(then=(RoundTrip(format="stl"), FlipFaces(percent=50), DropFaces(percent=5))),
        lambda mesh, _: stored_beside(mesh),
    ],
    ids=lambda attack: attack.label() if isinstance(attack, Attack) else "stored beside itself",
)
def test_reading_is_nearly_the_same_from_a_broken_file(broken, embedded):
    marked, scheme = embedded
    z = plain_z(scheme, broken(marked, np.random.default_rng(4)), 1)
    assert z == pytest.approx(plain_z(scheme, marked, 1), rel=0.03)


def test_an_original_whose_winding_says_nothing_is_marked_as_well(evidence):
    flipped = FlipFaces(percent=50)(MESH, np.random.default_rng(5))
    marked, scheme = SCHEME.embed(flipped, 1)
    np.testing.assert_array_equal(marked.faces, flipped.faces)
    assert scheme.score(marked, 1).z == pytest.approx(evidence.score(scheme.signs(1)).z, rel=0.05)


def beside_a_ball_wound_inwards(mesh: Mesh) -> Mesh:
    """Return the mesh and a ball as large, wound the other way: the two volumes nearly cancel."""
    ball = inside_out(icosphere(4, np.cbrt(signed_volume(mesh) / signed_volume(icosphere(4)))))
    return together(mesh, ball.with_vertices(ball.vertices + 1.2 * mesh.diagonal))


def test_objects_wound_against_each_other_are_marked_and_read(embedded):
    marked, scheme = SCHEME.embed(beside_a_ball_wound_inwards(MESH), 1)
    assert scheme.score(marked, 1).detected()
    marked, scheme = embedded
    assert plain_z(scheme, beside_a_ball_wound_inwards(marked), 1) > 0.9 * plain_z(scheme, marked, 1)


def test_mark_of_a_symmetric_mesh_is_found_from_any_side():
    marked, scheme = SCHEME.embed(fine_box(), 1)
    assert scheme.reference.ways == 24
    clean = plain_z(scheme, marked, 1)
    assert clean > 10
    assert scheme.evidence(marked).tries == 24
    for seed in range(4):
        turned = Chain(then=(GaussianNoise(percent=0.2), Similarity()))(marked, np.random.default_rng(seed))
        assert plain_z(scheme, turned, 1) > 0.8 * clean
