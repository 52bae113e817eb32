"""What every attack owes: `wm3d.contract` for many parameters, and where they change nothing."""

import numpy as np
import pytest
from shapes import blob, box

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
    RoundTrip,
    Similarity,
    Simplify,
    Subdivide,
    Weld,
)
from wm3d.contract import ATTACK_CHECKS, examine
from wm3d.errors import Wm3dError

MESH = blob(1, 3)
OWNER = Owner(MESH, lambda mesh, seed: GaussianNoise(percent=0.1)(mesh, np.random.default_rng(seed)))
COARSE = {"screened-poisson": {"depth": 5}, "marching-cubes": {"cells": 24}}  # the defaults take seconds
VARIANTS = [
    *(ATTACKS.build(name, COARSE.get(name, {})) for name in ATTACKS),
    GaussianNoise(percent=2, amplitude="per-axis"),
    Similarity(min_scale=3, max_scale=3, translation=0),
    Simplify(ratio=0.2, simplifier="pymeshlab-quadric"),
    Simplify(ratio=0.3, simplifier="clustering"),
    Quantize(bits=8, grid="cubic"),
    Subdivide(rule="loop"),
    Subdivide(rule="sqrt3"),
    *(RoundTrip(format=f) for f in ("obj", "off", "glb")),
    RoundTrip(format="stl", weld=True),
    Weld(percent=1),
    Draco(bits=8),
    Chain(then=(Weld(), Similarity(), Simplify(ratio=0.5))),
    Chain(then=(Remark(), Quantize(bits=8))),
]
IDENTITIES = [
    GaussianNoise(percent=0, amplitude="per-axis"),
    *(RoundTrip(format=f) for f in ("obj", "off")),
    *(Simplify(ratio=1, simplifier=s) for s in ("pymeshlab-quadric", "clustering")),
]


def every_attack(attacks: list[Attack]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("attack", attacks, ids=lambda attack: attack.label())


@every_attack(VARIANTS)
def test_attack_keeps_its_contract(attack):
    assert [outcome for outcome in examine(attack, ATTACK_CHECKS) if outcome.fault] == []


def test_every_attack_that_can_be_none_says_so():
    strengths = {"percent", "iterations", "degrees", "copies", "times"}
    can_be_none = {name for name, cls in ATTACKS.items() if strengths & cls.model_fields.keys()}
    assert can_be_none <= {name for name, cls in ATTACKS.items() if cls.neutral is not None} | {
        "isotropic-remesh"  # even one iteration at the old edge length remeshes
    }


@every_attack(IDENTITIES)
def test_zero_strength_is_the_identity(attack):
    assert attack.given(OWNER)(MESH, np.random.default_rng(9)).digest() == MESH.digest()


@every_attack(VARIANTS)
def test_a_mesh_of_twelve_faces_survives_or_is_refused(attack):
    run = attack.given(OWNER)
    if attack.name in {"screened-poisson", "collusion"}:  # eight normals are too few; copies of another mesh
        with pytest.raises(Wm3dError, match=f"^box: {attack.label()}"):
            run(box(), np.random.default_rng(1))
    else:
        assert len(run(box(), np.random.default_rng(1)).faces) >= 4


@pytest.mark.parametrize("attack", [Collusion(), Remark(), Chain(then=(Weld(), Remark()))])
def test_an_attack_that_needs_other_marks_says_so(attack):
    assert attack.marks
    with pytest.raises(Wm3dError, match="needs the scheme"):
        attack(MESH, np.random.default_rng(1))


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
