"""Chains and marks of other keys: composition, one generator, and what a chain says of itself."""

import numpy as np
import pytest
from shapes import blob

from wm3d.attacks import (
    ATTACKS,
    Attack,
    Chain,
    Collusion,
    Draco,
    GaussianNoise,
    Owner,
    Quantize,
    Remark,
    Similarity,
    Simplify,
    Weld,
)
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

MESH = blob(1, 3)
LINKS = (GaussianNoise(percent=0.2), Similarity(), Simplify(ratio=0.5))


def marked(mesh: Mesh, seed: int) -> Mesh:
    signs = np.where(np.random.default_rng(seed).random(mesh.vertices.shape) < 0.5, -1.0, 1.0)
    return mesh.with_vertices(mesh.vertices + 1e-3 * signs)


OWNER = Owner(MESH, marked)


def test_chain_is_composition_with_one_generator():
    rng, mesh = np.random.default_rng(5), MESH
    for link in LINKS:
        mesh = link(mesh, rng)
    assert Chain(then=LINKS)(MESH, np.random.default_rng(5)).digest() == mesh.digest()


def test_chain_is_what_its_links_are():
    chain = Chain(then=LINKS)
    assert (chain.random, chain.turns, chain.marks) == (True, True, False)
    assert chain.engines == ("fast-simplification",)
    assert chain.label() == "gaussian-noise 0.2 rms-vector → similarity → simplify 0.5 fast-simplification"
    still = Chain(then=(Weld(), Quantize()))
    assert (still.random, still.turns, still.marks, still.engines) == (False, False, False, ())
    assert Chain(then=(Weld(), Collusion())).marks
    assert Chain(then=(Weld(),)).label() == "chain weld 0"  # tables put together what has the same label


def test_identity_holds_the_versions_of_the_links(monkeypatch):
    chain = Chain(then=LINKS)
    before = chain.identity()
    monkeypatch.setattr(GaussianNoise, "version", GaussianNoise.version + 1)
    assert chain.identity() != before


def test_chain_is_built_from_plain_data_and_names_its_faults():
    data = {"then": [{"name": "weld"}, {"name": "quantize", "bits": 8}]}
    assert ATTACKS.build("chain", data) == Chain(then=(Weld(), Quantize(bits=8)))
    with pytest.raises(Wm3dError, match=r"attack chain: then\.1\.quantize\.bits = 0: "):
        ATTACKS.build("chain", {"then": [{"name": "weld"}, {"name": "quantize", "bits": 0}]})
    with pytest.raises(Wm3dError, match="unknown name 'chain'"):
        ATTACKS.build("chain", {"then": [{"name": "chain"}]})


def test_collusion_averages_copies_of_the_original():
    subject, copies = marked(MESH, 1), 400
    result = Collusion(copies=copies).given(OWNER)(subject, np.random.default_rng(2))
    offset = (result.vertices - MESH.vertices) / 1e-3
    own = np.sign(subject.vertices - MESH.vertices)
    # a mean of 400 signs has deviation 1/20; the own mark keeps 1/400. 1926 coordinates: five deviations of
    # the deviation and of the correlation, false alarm 1e-6 each
    assert offset.std() == pytest.approx(1 / 20, rel=0.081)
    assert (offset * own).mean() == pytest.approx(1 / copies, abs=5 / 20 / np.sqrt(own.size))
    two = Collusion(copies=2).given(OWNER)(subject, np.random.default_rng(2))
    np.testing.assert_allclose(np.unique(np.round(np.abs(two.vertices - MESH.vertices), 9)), [0, 1e-3])


def test_collusion_needs_copies_of_one_connectivity():
    half = Simplify(ratio=0.5)(MESH, np.random.default_rng(0))
    with pytest.raises(Wm3dError, match="needs copies of the same connectivity"):
        Collusion().given(OWNER)(half, np.random.default_rng(0))


def test_remark_adds_marks_of_other_keys_to_what_it_gets():
    subject = marked(MESH, 1)
    result = Remark(times=2).given(OWNER)(subject, np.random.default_rng(3))
    moved = np.round((result.vertices - subject.vertices) / 1e-3).astype(int)
    assert set(moved.ravel()) == {-2, 0, 2}
    in_chain = Chain(then=(Remark(times=2),)).given(OWNER)(subject, np.random.default_rng(3))
    assert in_chain.digest() == result.digest()


def test_an_absent_draco_is_no_engine(monkeypatch):
    monkeypatch.setattr("wm3d.attacks.exchange.find_spec", lambda name: None)  # noqa: ARG005
    assert Chain(then=(Draco(),)).engines == ()


@pytest.mark.parametrize("cls", ATTACKS.values(), ids=ATTACKS)
def test_flags_are_those_of_the_class_or_of_the_links(cls):
    attack: Attack = cls()
    assert all(isinstance(getattr(attack, flag), bool) for flag in ("random", "turns", "marks"))
