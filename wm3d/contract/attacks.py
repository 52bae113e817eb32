"""The contract of an attack: each function checks one promise and raises `Broken` where it is not kept."""

from collections.abc import Callable
from functools import cache, lru_cache

import numpy as np

from wm3d.attacks import ATTACKS, Attack, GaussianNoise, Owner
from wm3d.contract import samples
from wm3d.contract.check import Broken, global_state
from wm3d.contract.components import check_engines, check_label, check_name, check_parameters
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

STATE = 7
"""Seed of the generator that attacks draw from."""


def has_a_name(attack: Attack) -> None:
    """Its name is fixed, and of lower-case letters, digits and hyphens."""
    check_name(attack)


def parameters_survive_json(attack: Attack) -> None:
    """It is frozen, and its parameters come back from JSON as they were."""
    check_parameters(attack)


def label_is_its_own(attack: Attack) -> None:
    """No other attack has its label."""
    check_label(attack, ATTACKS)


def engines_are_installed(attack: Attack) -> None:
    """The distributions that `engines` names are installed."""
    check_engines(attack)


def same_generator_same_mesh(attack: Attack) -> None:
    """The same generator state gives the same mesh, whatever the global random state."""
    first = _usual(attack)
    with global_state(2):
        again = _attacked(attack, _good())
    if first.digest() != again.digest():
        raise Broken("two calls with the same generator state gave two meshes; draw from `rng` alone.")


def random_says_whether_the_generator_matters(attack: Attack) -> None:
    """Another generator state gives another mesh where `random` is true, and the same where it is false."""
    if _is_neutral(attack):
        return  # neither says anything
    differ = _usual(attack).digest() != _attacked(attack, _good(), STATE + 1).digest()
    if differ and not attack.random:
        raise Broken("`random` is false, but the mesh depends on the generator.")
    if attack.random and not differ:
        raise Broken("two generator states gave one mesh; declare random: ClassVar[bool] = False.")


def input_stays_as_it_is(attack: Attack) -> None:
    """The mesh that is attacked is not changed."""
    mesh = samples.potato(3)
    before = mesh.digest()
    _attacked(attack, mesh)
    if mesh.digest() != before:
        raise Broken("the input mesh was changed; copy its arrays.")


def result_is_a_mesh(attack: Attack) -> None:
    """The result is a `Mesh` with the name of the input and without vertices that no face uses."""
    result = _usual(attack)
    _check_mesh(result)
    if result.name != _good().name:
        raise Broken(f"the result is named {result.name!r}, the input {_good().name!r}; keep the name.")
    loose = len(result.vertices) - np.unique(result.faces).size
    if loose:
        raise Broken(f"{loose} vertices of the result are in no face; they would turn the pose.")


def neutral_parameters_change_nothing(attack: Attack) -> None:
    """With its `neutral` parameters, where it declares them, the mesh stays the same, bit for bit."""
    neutral = type(attack).neutral
    if neutral is None:
        return
    harmless = type(attack).model_validate(neutral)
    good, same = _good(), _attacked(harmless, _good())
    if same.digest() != good.digest():
        moved = ""
        if same.vertices.shape == good.vertices.shape and (same.vertices != good.vertices).any():
            moved = f", its vertices by up to {np.abs(same.vertices - good.vertices).max():.2g}"
        raise Broken(f"with {neutral or 'its defaults'} the mesh is changed{moved}; not a bit may change.")


def open_mesh_is_attacked_or_refused(attack: Attack) -> None:
    """A mesh with a hole is attacked, or refused by a `Wm3dError`."""
    _attacked_or_refused(attack, samples.opened(_good()))


def inward_wound_mesh_is_attacked_or_refused(attack: Attack) -> None:
    """A mesh whose faces are wound inward is attacked, or refused by a `Wm3dError`."""
    _attacked_or_refused(attack, samples.inside_out(_good()))


def tiny_mesh_is_attacked_or_refused(attack: Attack) -> None:
    """A box of twelve faces is attacked, or refused by a `Wm3dError`."""
    _attacked_or_refused(attack, samples.box())


ATTACK_CHECKS: tuple[Callable[[Attack], None], ...] = (
    has_a_name,
    parameters_survive_json,
    label_is_its_own,
    engines_are_installed,
    same_generator_same_mesh,
    random_says_whether_the_generator_matters,
    input_stays_as_it_is,
    result_is_a_mesh,
    neutral_parameters_change_nothing,
    open_mesh_is_attacked_or_refused,
    inward_wound_mesh_is_attacked_or_refused,
    tiny_mesh_is_attacked_or_refused,
)


def _is_neutral(attack: Attack) -> bool:
    neutral = type(attack).neutral
    return bool(neutral) and attack == type(attack).model_validate(attack.parameters() | (neutral or {}))


@cache
def _good() -> Mesh:
    return samples.potato(3)


@lru_cache(maxsize=1)  # several checks look at it, and some attacks take seconds
def _usual(attack: Attack) -> Mesh:
    with global_state(1):
        return _attacked(attack, _good())


def _attacked(attack: Attack, mesh: Mesh, state: int = STATE) -> Mesh:
    """Attack with other marks at hand; for these, noise is as good as a scheme."""
    owner = Owner(mesh, lambda mesh, seed: GaussianNoise(percent=0.1)(mesh, np.random.default_rng(seed)))
    return attack.given(owner)(mesh, np.random.default_rng(state))


def _attacked_or_refused(attack: Attack, mesh: Mesh) -> None:
    try:
        result = _attacked(attack, mesh)
    except Wm3dError as refusal:
        if not str(refusal).strip() or "\n" in str(refusal):
            raise Broken(f"the refusal is not one sentence: {str(refusal)!r}.") from None
        return
    _check_mesh(result)


def _check_mesh(result: object) -> None:
    if not isinstance(result, Mesh):
        raise Broken(f"the result is a {type(result).__name__}, not a wm3d.Mesh.")
    try:
        Mesh(result.vertices, result.faces)
    except Wm3dError as fault:
        raise Broken(f"the result is not a valid mesh: {fault}") from None
