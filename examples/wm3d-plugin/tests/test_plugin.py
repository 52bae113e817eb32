"""The plug-in keeps the contract of wm3d and does what it says."""

import numpy as np
import pytest
from wm3d_plugin.bands import LatitudeBands
from wm3d_plugin.dents import Dents

from wm3d.contract import ATTACK_CHECKS, SCHEME_CHECKS, examine
from wm3d.contract.samples import potato
from wm3d.scanner import VertexPca

MESH = potato(4)


COMPONENTS = [(LatitudeBands(), SCHEME_CHECKS), (Dents(), ATTACK_CHECKS)]


@pytest.mark.parametrize(("component", "checks"), COMPONENTS)
def test_contract(component, checks):
    assert [outcome for outcome in examine(component, checks) if outcome.fault] == []


def test_distances_from_the_centre_change_by_alpha():
    marked, _ = LatitudeBands(alpha=0.01).embed(MESH, 3)
    centre = VertexPca()(MESH).center
    before, after = (np.linalg.norm(mesh.vertices - centre, axis=1) for mesh in (MESH, marked))
    np.testing.assert_allclose(np.abs(after / before - 1), 0.01, rtol=1e-9)


def test_statistic_is_the_correlation_of_the_docstring():
    scheme, neighbours = LatitudeBands(bands=40), [set() for _ in MESH.vertices]
    for face in MESH.faces:
        for a, b in zip(face, np.roll(face, 1), strict=True):
            neighbours[a].add(b)
            neighbours[b].add(a)
    distance, band = scheme._polar(MESH)
    signs = scheme.signs(5)

    def outstanding(values):
        return values - np.array([values[list(near)].mean() for near in neighbours])

    expected = outstanding(distance) @ outstanding(signs[band]) / MESH.diagonal
    assert scheme.score(MESH, 5).statistic == pytest.approx(expected, rel=1e-9)


def test_a_dent_is_as_deep_as_it_says():
    dented = Dents(count=1, percent=1)(MESH, np.random.default_rng(2))
    moved = np.linalg.norm(dented.vertices - MESH.vertices, axis=1)
    assert moved.max() == pytest.approx(0.01 * MESH.diagonal, rel=1e-9)
    assert 0 < (moved > 0).mean() < 0.1
