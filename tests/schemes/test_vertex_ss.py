"""The floor: what the naive scheme does to the norms, and what removes it."""

import numpy as np
import pytest
from shapes import blob

from wm3d.attacks import LaplacianSmoothing, Simplify, UniformNoise
from wm3d.errors import Wm3dError
from wm3d.schemes import SCHEMES

MESH = blob(0, 4)
SCHEME = SCHEMES.build("vertex-ss", {"signs_used": 100, "alpha": 0.002})


def test_norm_of_vertex_i_changes_by_sign_i_modulo_n():
    center = MESH.vertices.mean(axis=0)
    before = np.linalg.norm(MESH.vertices - center, axis=1)
    after = np.linalg.norm(SCHEME.embed(MESH, 4)[0].vertices - center, axis=1)
    signs = np.resize(SCHEME.signs(4), len(before))
    np.testing.assert_allclose(after - before, 0.002 * before.mean() * signs, atol=1e-12)


def test_statistic_is_the_norms_less_their_neighbours_vertex_by_vertex():
    norms = np.linalg.norm(MESH.vertices - MESH.vertices.mean(axis=0), axis=1)
    neighbours: list[set[int]] = [set() for _ in norms]
    for a, b, c in MESH.faces:
        for i, j in ((a, b), (b, c), (c, a)):
            neighbours[i].add(j)
            neighbours[j].add(i)
    expected = np.zeros(100)
    for i, near in enumerate(neighbours):
        expected[i % 100] += (norms[i] - norms[list(near)].mean()) / norms.mean()
    np.testing.assert_allclose(SCHEME.evidence(MESH).b, expected, atol=1e-12)


def test_it_survives_noise_and_dies_of_a_new_vertex_order():
    marked, _ = SCHEME.embed(MESH, 1)
    rng = np.random.default_rng(0)
    assert SCHEME.score(UniformNoise(percent=0.1)(marked, rng), 1).detected(1e-9)
    assert SCHEME.score(LaplacianSmoothing(iterations=5)(marked, rng), 1).detected(1e-9)
    assert not SCHEME.score(Simplify(ratio=0.9)(marked, rng), 1).detected(1e-6)


def test_too_few_vertices_are_refused_when_marking_but_read():
    small = blob(0, 1)
    with pytest.raises(Wm3dError, match=r"^blob-0: has 42 vertices, too few for 100 signs"):
        SCHEME.embed(small, 1)
    assert (SCHEME.evidence(small).b[42:] == 0).all()
