"""Cho, Prost and Jung: moments land where the paper wants them; what is read, and what is refused."""

from itertools import pairwise

import numpy as np
import pytest
from shapes import blob, icosphere

from wm3d.attacks import Simplify, Subdivide
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import snr
from wm3d.schemes import SCHEMES

MESH = blob(0, 5)
BOTH = pytest.mark.parametrize("name", ["cho2007-mean", "cho2007-variance"])


def bins_by_hand(mesh: Mesh, center: np.ndarray, bins: int) -> list[np.ndarray]:
    rho = np.linalg.norm(mesh.vertices - center, axis=1)
    edges = np.linspace(rho.min(), rho.max(), bins + 1)
    return [(rho[(rho >= a) & (rho <= b)] - a) / (b - a) for a, b in pairwise(edges)]


@BOTH
def test_every_bin_reaches_its_target_and_none_loses_a_vertex(name):
    scheme = SCHEMES.build(name, {"bits": 32, "alpha": 0.06})
    signs, center = scheme.signs(5), MESH.vertices.mean(axis=0)
    before = bins_by_hand(MESH, center, 32)
    after = bins_by_hand(scheme.embed(MESH, 5)[0], center, 32)
    assert [len(t) for t in before] == [len(t) for t in after]
    for w, old, new in zip(signs, before, after, strict=True):
        moment, neutral = (np.mean, 0.5) if "mean" in name else (lambda t: np.mean((2 * t - 1) ** 2), 1 / 3)
        off = w * (moment(new) - neutral)
        if w * (moment(old) - neutral) >= 0.06:
            np.testing.assert_allclose(new, old, atol=1e-9)
        else:
            assert off == pytest.approx(0.06, abs=1e-6)


@BOTH
def test_vertices_move_along_their_rays(name):
    center = MESH.vertices.mean(axis=0)
    marked, _ = SCHEMES.build(name, {}).embed(MESH, 1)
    moved, arms = marked.vertices - MESH.vertices, MESH.vertices - center
    assert np.abs(np.cross(moved, arms)).max() < 1e-14
    assert 0 < np.linalg.norm(moved, axis=1).max() < 0.05


@BOTH
def test_statistic_is_the_soft_reading_of_the_papers_decision(name):
    scheme = SCHEMES.build(name, {"bits": 16})
    bins = bins_by_hand(MESH, MESH.vertices.mean(axis=0), 16)
    if "mean" in name:
        expected = [np.sqrt(12 * len(t)) * (t.mean() - 0.5) for t in bins]
    else:
        expected = [np.sqrt(45 / 4 * len(t)) * (((2 * t - 1) ** 2).mean() - 1 / 3) for t in bins]
    evidence = scheme.evidence(MESH)
    np.testing.assert_allclose(evidence.b, expected, atol=1e-9)
    assert evidence.log10_p_least == pytest.approx(16 * np.log10(0.5))


@BOTH
def test_weak_marks_have_a_floor_of_distortion(name):
    # a bin on the wrong side of neutral must cross it however small α is
    small, smaller = (snr(MESH, SCHEMES.build(name, {"alpha": a}).embed(MESH, 1)[0]) for a in (1e-4, 1e-8))
    assert smaller - small < 0.2
    with pytest.raises(Wm3dError, match=r"cannot be set to an SNR of 150 dB"):
        SCHEMES.build(name, {}).at_snr(MESH, 1, 150.0)


def test_open_meshes_carry_it_and_simplification_removes_it():
    half = Mesh(MESH.vertices, MESH.faces[: len(MESH.faces) // 2], "open blob")
    scheme = SCHEMES.build("cho2007-mean", {})
    marked, _ = scheme.embed(half, 1)
    assert scheme.score(marked, 1).detected(1e-12)
    thinned = Simplify(ratio=0.3)(scheme.embed(MESH, 1)[0], np.random.default_rng(0))
    assert not scheme.score(thinned, 1).detected(1e-6)


def test_area_version_survives_simplification_and_subdivision():
    scheme = SCHEMES.build("radial-area", {"bits": 32})
    marked, _ = scheme.embed(MESH, 1)
    for attack in (Simplify(ratio=0.3), Subdivide()):
        evidence = scheme.evidence(attack(marked, np.random.default_rng(0)))
        assert evidence.bit_error_rate(scheme.signs(1)) <= 1 / 16
        assert evidence.score(scheme.signs(1)).detected(1e-6)


def test_area_version_meets_its_means_and_moves_less_than_power_maps():
    scheme = SCHEMES.build("radial-area", {"bits": 16})
    signs = scheme.signs(1)
    off = signs * (scheme.spread(scheme.embed(MESH, 1)[0]).moments(scheme.moment) - 0.5)
    assert off.min() > 0.9 * scheme.alpha
    before = signs * (scheme.spread(MESH).moments(scheme.moment) - 0.5)
    np.testing.assert_allclose(off, np.maximum(before, scheme.alpha), atol=0.01)


@pytest.mark.parametrize(
    ("name", "parameters", "sentence"),
    [
        ("cho2007-mean", {"alpha": 0.5}, "alpha = 0.5: input should be less than 0.5"),
        ("cho2007-variance", {"alpha": 0}, "alpha = 0: input should be greater than 0"),
        ("cho2007-mean", {"bits": 0}, "bits = 0: input should be greater than or equal to 1"),
    ],
)
def test_wrong_parameters_are_named(name, parameters, sentence):
    with pytest.raises(Wm3dError) as refusal:
        SCHEMES.build(name, parameters)
    assert sentence in str(refusal.value)


@pytest.mark.parametrize(
    ("name", "mesh", "bits", "sentence"),
    [
        ("cho2007-mean", icosphere(3), 64, "icosphere: all vertices are equally far"),
        ("radial-area", icosphere(4), 64, "icosphere: its surface is equally far"),
        ("cho2007-mean", blob(0, 2), 512, r"blob-0: cho2007-mean 512 finds too little in \d+ of 512 bins"),
        ("radial-area", blob(0, 2), 128, r"blob-0: its faces are too large for 128 bins"),
    ],
)
def test_mesh_that_cannot_carry_the_mark_is_refused(name, mesh, bits, sentence):
    with pytest.raises(Wm3dError, match=f"^{sentence}"):
        SCHEMES.build(name, {"bits": bits}).embed(mesh, 1)
