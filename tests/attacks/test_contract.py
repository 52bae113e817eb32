"""What every attack owes: frozen, reproducible from its generator, input untouched, a valid mesh out."""

import numpy as np
import pytest
from pydantic import ValidationError
from shapes import blob, box

from wm3d.attacks import (
    ATTACKS,
    Attack,
    Bend,
    Chain,
    Clean,
    Collusion,
    Crop,
    Draco,
    GaussianNoise,
    HalfSpaceCrop,
    LaplacianSmoothing,
    Owner,
    PrintScan,
    Quantize,
    Remark,
    RoundTrip,
    Shear,
    Similarity,
    Simplify,
    Stretch,
    Subdivide,
    TaubinSmoothing,
    Twist,
    UniformNoise,
    Weld,
)
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

MESH = blob(1, 3)
OWNER = Owner(MESH, lambda mesh, seed: GaussianNoise(percent=0.1)(mesh, np.random.default_rng(seed)))
VARIANTS = [
    *(cls() for cls in ATTACKS.values()),
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
    Clean(),
    GaussianNoise(percent=0),
    GaussianNoise(percent=0, amplitude="per-axis"),
    UniformNoise(percent=0),
    LaplacianSmoothing(iterations=0),
    TaubinSmoothing(iterations=0),
    Crop(percent=0),
    HalfSpaceCrop(percent=0),
    Stretch(percent=0),
    Shear(percent=0),
    Bend(degrees=0),
    Twist(degrees=0),
    PrintScan(layer_percent=0, smoothing=0, noise_percent=0, tilt_degrees=0),
    Weld(),
    *(RoundTrip(format=f) for f in ("ply", "obj", "off")),
    Collusion(copies=1),
    Remark(times=0),
    Chain(),
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
    first = attack.given(OWNER)(MESH, np.random.default_rng(7))
    np.random.seed(6)  # noqa: NPY002
    again = attack.given(OWNER)(MESH, np.random.default_rng(7))
    other = attack.given(OWNER)(MESH, np.random.default_rng(8))
    assert first.digest() == again.digest()
    assert (first.digest() != other.digest()) == attack.random
    assert MESH.digest() == before


@every_attack(VARIANTS)
def test_attacked_mesh_is_a_valid_mesh_of_the_same_name(attack):
    result = attack.given(OWNER)(MESH, np.random.default_rng(9))
    assert Mesh(result.vertices, result.faces).digest() == result.digest()
    assert result.name == MESH.name
    assert np.unique(result.faces).size == len(result.vertices)


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
