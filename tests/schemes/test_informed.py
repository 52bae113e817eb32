"""Informed embedding: what it climbs, what it keeps, and what it gains over the pattern of the key."""

from unittest.mock import patch

import numpy as np
import pytest
from plain import plain_z
from shapes import blob, soup

from wm3d.attacks import GaussianNoise, LaplacianSmoothing, Simplify
from wm3d.mesh import Mesh, surface_area
from wm3d.metrics import snr
from wm3d.schemes import SCHEMES, informed
from wm3d.schemes.informed import change_of, informed_moves, pattern_moves, pulled
from wm3d.schemes.volume_host import host_of
from wm3d.stats import key_signs

MESH = blob(0, 5)
SCHEME = SCHEMES.build("range-dct", {})


@pytest.fixture(scope="module")
def host():
    return host_of(MESH, None)


@pytest.fixture(scope="module")
def signs(host):
    return key_signs(1, host.mark.amplitude.size)


def test_slope_along_the_moves_is_the_adjoint_of_the_change_of_the_image(host):
    rng = np.random.default_rng(0)
    along, slope = rng.normal(size=len(host.posed)), rng.normal(size=host.mark.received.shape)
    assert (slope * change_of(host, along)).sum() == pytest.approx(pulled(host, slope) @ along, rel=1e-9)


@pytest.mark.parametrize("size", [1e-4, 6e-3, 0.05])
def test_moves_have_the_size_that_is_asked_for(host, signs, size):
    for along in (pattern_moves(host, signs, size), informed_moves(host, signs, size)):
        moves = host.moves(along)
        assert np.sqrt((moves**2).sum(axis=1).mean()) == pytest.approx(size, rel=1e-12)
        assert host.size(along) == pytest.approx(size, rel=1e-12)


def test_area_and_share_are_those_of_the_surface_and_of_its_vertices(host):
    posed = host.posed[host.place]
    assert host.area.sum() == pytest.approx(surface_area(Mesh(posed, MESH.faces)), rel=1e-12)
    assert host.share[host.place] * len(MESH.vertices) == pytest.approx(
        (host.directions[host.place] ** 2).sum(axis=1), rel=1e-12
    )


def test_more_signs_are_read_than_from_the_pattern_at_the_same_size(host, signs):
    def agreeing(along):
        return ((host.mark.received + change_of(host, along)) * signs.reshape(-1, 63) > 0).mean()

    size = 6e-3
    pattern, moved = pattern_moves(host, signs, size), informed_moves(host, signs, size)
    assert agreeing(moved) > agreeing(pattern) + 0.02
    # neighbours still move alike: in the metric of the area no vertex is worth a spike
    assert np.abs(moved).max() < 1.5 * np.abs(pattern).max()


@pytest.mark.parametrize(
    "attack",
    [None, GaussianNoise(percent=0.6), Simplify(ratio=0.25), LaplacianSmoothing(iterations=10)],
    ids=lambda attack: attack.label() if attack else "clean",
)
def test_mark_is_stronger_than_the_pattern_at_the_same_snr(attack):
    z = []
    for steps in (0, informed.STEPS):
        with patch.object(informed, "STEPS", steps):
            marked, scheme = SCHEME.embed(MESH, 2)
        assert snr(MESH, marked) == pytest.approx(44.01, abs=0.01)
        attacked = attack(marked, np.random.default_rng(2)) if attack else marked
        z.append(plain_z(scheme, attacked, 2))
    assert z[1] > 1.03 * z[0]


def test_an_unwelded_mesh_moves_as_the_welded_one(signs):
    apart = host_of(soup(MESH), None)
    moves = apart.moves(informed_moves(apart, signs, 6e-3))
    whole = host_of(MESH, None)
    together = whole.moves(informed_moves(whole, signs, 6e-3))
    # six copies of a vertex count six times in the size, nearly all have six
    cosine = (moves * together[MESH.faces.ravel()]).sum() / np.sqrt(
        (moves**2).sum() * (together[MESH.faces.ravel()] ** 2).sum()
    )
    assert cosine > 0.999
