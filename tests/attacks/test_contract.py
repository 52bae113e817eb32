"""What every attack owes: frozen, reproducible from its generator, input untouched, a valid mesh out."""

import numpy as np
import pytest
from pydantic import ValidationError
from shapes import blob, box

from wm3d.attacks import ATTACKS, Attack, Clean, GaussianNoise, Similarity, Simplify
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

MESH = blob(1, 3)
VARIANTS = [
    *(cls() for cls in ATTACKS.values()),
    GaussianNoise(percent=2, amplitude="per-axis"),
    Similarity(min_scale=3, max_scale=3, translation=0),
    Simplify(ratio=0.2, simplifier="pymeshlab-quadric"),
    Simplify(ratio=0.3, simplifier="clustering"),
]
RANDOM = {"gaussian-noise", "similarity"}
IDENTITIES = [
    Clean(),
    GaussianNoise(percent=0),
    GaussianNoise(percent=0, amplitude="per-axis"),
    *(Simplify(ratio=1, simplifier=s) for s in ("fast-simplification", "pymeshlab-quadric", "clustering")),
]


def every_attack(attacks: list[Attack]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("attack", attacks, ids=lambda attack: attack.label())


@every_attack(VARIANTS)
def test_attack_is_a_frozen_value_that_its_parameters_rebuild(attack):
    field = next(iter(type(attack).model_fields))
    with pytest.raises(ValidationError, match="frozen"):
        setattr(attack, field, getattr(attack, field))
    assert ATTACKS.build(attack.name, attack.parameters()) == attack
    assert hash(attack) == hash(attack.model_copy())


@every_attack(VARIANTS)
def test_same_generator_state_gives_the_same_mesh_and_nothing_else_is_random(attack):
    before = MESH.digest()
    np.random.seed(5)  # noqa: NPY002 (to see that no attack draws from the global state)
    first = attack(MESH, np.random.default_rng(7))
    np.random.seed(6)  # noqa: NPY002
    again = attack(MESH, np.random.default_rng(7))
    other = attack(MESH, np.random.default_rng(8))
    assert first.digest() == again.digest()
    assert (first.digest() != other.digest()) == (attack.name in RANDOM)
    assert MESH.digest() == before


@every_attack(VARIANTS)
def test_attacked_mesh_is_a_valid_mesh_of_the_same_name(attack):
    result = attack(MESH, np.random.default_rng(9))
    assert Mesh(result.vertices, result.faces).digest() == result.digest()
    assert result.name == MESH.name
    assert np.unique(result.faces).size == len(result.vertices)


@every_attack(IDENTITIES)
def test_zero_strength_is_the_identity(attack):
    assert attack(MESH, np.random.default_rng(9)).digest() == MESH.digest()


@every_attack(VARIANTS)
def test_a_mesh_of_twelve_faces_survives(attack):
    assert len(attack(box(), np.random.default_rng(1)).faces) >= 4


@pytest.mark.parametrize(
    ("name", "parameters", "sentence"),
    [
        ("gaussian-noise", {"percent": -1}, "attack gaussian-noise: percent = -1: "),
        ("gaussian-noise", {"percent": float("nan")}, "attack gaussian-noise: percent = nan: "),
        ("gaussian-noise", {"precent": 1}, "unknown parameter 'precent', did you mean 'percent'?"),
        ("gaussian-noise", {"amplitude": "peak"}, "amplitude = 'peak': input should be 'rms-vector' or"),
        ("simplify", {"ratio": 0}, "attack simplify: ratio = 0: "),
        ("simplify", {"ratio": 1.5}, "attack simplify: ratio = 1.5: "),
        ("similarity", {"min_scale": 0}, "attack similarity: min_scale = 0: "),
        ("similarity", {"min_scale": 2, "max_scale": 1}, "min_scale"),
        ("noise", {}, "unknown attack 'noise'"),
    ],
)  # fmt: skip
def test_wrong_parameters_are_named_in_one_sentence(name, parameters, sentence):
    with pytest.raises(Wm3dError) as refusal:
        ATTACKS.build(name, parameters)
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)
