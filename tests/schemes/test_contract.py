"""What every scheme owes: one marked mesh for one seed, a key that is all, silence to other keys."""

import json

import numpy as np
import pytest
from shapes import blob

from wm3d.attacks import Reorder, Similarity
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import snr
from wm3d.schemes import SCHEMES, Key, Scheme
from wm3d.stats import log10_tail

MESH = blob(0, 5)
DECIBELS = 55.0

every_scheme = pytest.mark.parametrize("name", SCHEMES)


@pytest.fixture(scope="module")
def embedded():
    """Scheme by name with the mesh it marked with seed 1, at its default strength; each is made once."""
    made = {}

    def get(name):
        if name not in made:
            made[name] = SCHEMES.build(name, {}).embed(MESH, 1)
        return made[name]

    return get


@every_scheme
def test_embedding_is_deterministic_and_keeps_the_faces(name, embedded):
    marked, scheme = embedded(name)
    SCHEMES.build(name, {}).embed(blob(1, 4), 1)  # what was marked before does not matter
    unseen = Mesh(MESH.vertices, MESH.faces, MESH.name)
    again, same = SCHEMES.build(name, {}).embed(unseen, 1)
    other, _ = SCHEMES.build(name, {}).embed(MESH, 2)
    assert again.digest() == marked.digest()
    assert same == scheme
    assert hash(same) == hash(scheme)
    assert other.digest() != marked.digest()
    assert marked.faces is MESH.faces
    assert marked.name == MESH.name


@every_scheme
def test_clean_mark_is_found_and_a_message_is_read_without_errors(name, embedded):
    marked, scheme = embedded(name)
    evidence = scheme.evidence(marked)
    assert evidence.b.shape == (scheme.capacity,) == scheme.signs(1).shape
    score = evidence.score(scheme.signs(1))
    assert score.log10_p < -12
    assert scheme.score(marked, 1).z == score.z
    assert evidence.log10_p_least <= score.log10_p
    if scheme.message:
        assert evidence.bit_error_rate(scheme.signs(1)) == 0


@every_scheme
def test_other_keys_and_the_unmarked_mesh_are_silent(name, embedded):
    marked, scheme = embedded(name)
    evidence = scheme.evidence(marked)
    keys = np.array([scheme.signs(seed) for seed in range(1000, 2000)])
    z = keys @ evidence.b / evidence.scale
    # five standard errors each: 6e-7 false alarms, and the p-value of the largest of 1000 keys: 1e-6
    assert abs(z.mean()) < 5 / np.sqrt(1000)
    kurtosis = 3 - 2 * np.sum(evidence.b**4) / evidence.scale**4
    assert abs(z.var() - 1) < 5 * np.sqrt((kurtosis - 1) / 1000)
    assert log10_tail(evidence.b, z.max()) > -9
    assert scheme.score(MESH, 1).log10_p > -6  # 1e-6


@every_scheme
def test_pose_and_size_do_not_matter(name, embedded):
    marked, scheme = embedded(name)
    moved = Similarity(min_scale=0.1, max_scale=10)(marked, np.random.default_rng(3))
    expected, evidence = scheme.evidence(marked), scheme.evidence(moved)
    np.testing.assert_allclose(evidence.b / evidence.scale, expected.b / expected.scale, atol=2e-4)


@every_scheme
def test_order_of_the_file_does_not_matter_but_to_the_floor(name, embedded):
    marked, scheme = embedded(name)
    shuffled = Reorder()(marked, np.random.default_rng(3))
    log10_p = scheme.score(shuffled, 1).log10_p
    assert log10_p > -6 if name == "vertex-ss" else log10_p < -12


@every_scheme
def test_key_file_is_all_that_detection_needs(name, embedded, tmp_path):
    marked, scheme = embedded(name)
    key = Key(scheme, 1)
    key.save(tmp_path / "key.json")
    loaded = Key.load(tmp_path / "key.json")
    assert loaded == key
    assert json.loads((tmp_path / "key.json").read_text())["scheme"]["name"] == name
    if scheme.blind:
        assert loaded.score(marked).z == key.score(marked).z
        assert loaded.with_original(MESH) == loaded
    else:
        with pytest.raises(Wm3dError, match=r"needs the original"):
            loaded.score(marked)
        with pytest.raises(Wm3dError, match=r"is not the mesh that was marked"):
            loaded.with_original(marked)
        assert loaded.with_original(MESH).score(marked).z == key.score(marked).z


@every_scheme
def test_strength_is_set_from_a_wanted_snr(name):
    scheme = SCHEMES.build(name, {}).at_snr(MESH, 1, DECIBELS)
    marked, read = scheme.embed(MESH, 1)
    assert snr(MESH, marked) == pytest.approx(DECIBELS, abs=0.05)
    assert read.score(marked, 1).detected(1e-9)


@every_scheme
def test_label_of_the_embedded_scheme_is_that_of_the_config(name, embedded):
    assert isinstance(embedded(name)[1], Scheme)
    assert embedded(name)[1].label() == SCHEMES.build(name, {}).label()
