"""The contract of a scheme: each function checks one promise and raises `Broken` where it is not kept."""

import json
from collections.abc import Callable
from functools import cache, lru_cache

import numpy as np
from scipy.stats import kstest

from wm3d.contract import samples
from wm3d.contract.check import Broken, global_state
from wm3d.contract.components import check_engines, check_label, check_name, check_parameters
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import snr
from wm3d.schemes import SCHEMES, Key, Scheme
from wm3d.stats import RademacherSum

FALSE_ALARM = 1e-6
"""Probability with which a statistical check fails a scheme that keeps its promise."""

SIGMAS = 5
"""Standard errors that a mean and a variance may be off: 6e-7 each."""

WRONG_KEYS = 200
SEED = 7


def has_a_name(scheme: Scheme) -> None:
    """Its name is fixed, and of lower-case letters, digits and hyphens."""
    check_name(scheme)


def parameters_survive_json(scheme: Scheme) -> None:
    """It is frozen, and its parameters come back from JSON as they were."""
    check_parameters(scheme)


def label_is_its_own(scheme: Scheme) -> None:
    """No other scheme has its label."""
    check_label(scheme, SCHEMES)


def engines_are_installed(scheme: Scheme) -> None:
    """The distributions that `engines` names are installed."""
    check_engines(scheme)


def embedding_is_deterministic(scheme: Scheme) -> None:
    """The same seed gives the same marked mesh, whatever the global random state."""
    first, its = _usual(scheme)
    with global_state(2):
        again, same = scheme.embed(samples.potato(5), SEED)  # another object, of which nothing was kept
    if first.digest() != again.digest() or its != same:
        raise Broken("the same seed was embedded twice with two results; draw signs from the seed alone.")


def other_seeds_mark_otherwise(scheme: Scheme) -> None:
    """Two seeds give two marked meshes, and neither is the input."""
    first, other = (marked.digest() for marked, _ in (_usual(scheme), scheme.embed(_good(), SEED + 1)))
    if _good().digest() in (first, other):
        raise Broken("embedding leaves the mesh as it is.")
    if first == other:
        raise Broken("two seeds gave the same marked mesh.")


def faces_stay(scheme: Scheme) -> None:
    """The marked mesh has the faces, the number of vertices and the name of the input, which stays."""
    mesh = samples.potato(5)
    before = mesh.digest()
    marked, _ = scheme.embed(mesh, SEED)
    if mesh.digest() != before:
        raise Broken("the input mesh was changed; copy its arrays.")
    if len(marked.vertices) != len(mesh.vertices) or not np.array_equal(marked.faces, mesh.faces):
        raise Broken("the marked mesh has other vertices or faces; use mesh.with_vertices(moved).")
    if marked.name != mesh.name:
        raise Broken(f"the marked mesh is named {marked.name!r}, the input {mesh.name!r}; keep the name.")


def evidence_has_a_weight_for_each_sign(scheme: Scheme) -> None:
    """`evidence` is a `RademacherSum` of `capacity` weights, the same each time."""
    marked, its = _usual(scheme)
    evidence = _read(its, _good(), marked)
    if not isinstance(evidence, RademacherSum):
        raise Broken(f"evidence is a {type(evidence).__name__}, not a wm3d.stats.RademacherSum.")
    if its.capacity < 1 or evidence.b.shape != (its.capacity,):
        raise Broken(f"evidence has {evidence.b.size} weights, and capacity is {its.capacity}.")
    if not np.array_equal(_read(its, _good(), marked).b, evidence.b):
        raise Broken("the same mesh was read twice with two results.")


def right_key_is_found(scheme: Scheme) -> None:
    """The key that was embedded is found in the marked mesh at Pf = 1e-6."""
    marked, its = _usual(scheme)
    score = _read(its, _good(), marked).score(its.signs(SEED))
    if not score.detected(FALSE_ALARM):
        raise Broken(f"on a closed mesh of 20480 faces it has only log10 p = {score.log10_p:.2f}.")


def unmarked_mesh_shows_no_mark(scheme: Scheme) -> None:
    """A key is not found in the mesh before it was marked, at Pf = 1e-6."""
    _, its = _usual(scheme)
    score = _read(its, _good(), _good()).score(its.signs(SEED))
    if score.detected(FALSE_ALARM):
        raise Broken(f"it is found with log10 p = {score.log10_p:.2f}; evidence must not know the seed.")


def wrong_keys_follow_the_null(scheme: Scheme) -> None:
    """The z of 200 wrong keys have mean 0 and variance 1, and their p-values are not too small."""
    marked, its = _usual(scheme)
    evidence = _read(its, _good(), marked)
    wrong = [evidence.score(its.signs(seed)) for seed in range(1000, 1000 + WRONG_KEYS)]
    z = np.array([score.z for score in wrong])
    if abs(z.mean()) > SIGMAS / np.sqrt(WRONG_KEYS) or abs(z.var() - 1) > SIGMAS * np.sqrt(2 / WRONG_KEYS):
        raise Broken(f"their z has mean {z.mean():.2f} and variance {z.var():.2f}; signs must be fair.")
    # one-sided: p-values of few signs are coarse, and lie above the uniform ones
    too_small = kstest([score.p_value for score in wrong], "uniform", alternative="greater").pvalue
    if too_small < FALSE_ALARM:
        raise Broken(f"their p-values are too small (Kolmogorov-Smirnov: probability {too_small:.1g}).")


def key_survives_json(scheme: Scheme) -> None:
    """A key that comes back from its JSON scores as before."""
    marked, its = _usual(scheme)
    written = json.loads(Key(its, SEED).encode())["scheme"]
    rebuilt = type(its).model_validate(written)
    before, after = (_read(s, _good(), marked).score(s.signs(SEED)).z for s in (its, rebuilt))
    if before != after:
        raise Broken(f"z is {before:g} before and {after:g} after; let `embed` return all that it needs.")


def strength_sets_the_distortion(scheme: Scheme) -> None:
    """Half the `strength` gives a higher SNR."""
    try:
        scheme.strength_field()
    except Wm3dError as error:
        raise Broken(str(error)) from None
    field = scheme.strength
    half = scheme.model_copy(update={field: getattr(scheme, field) / 2})
    full_snr, half_snr = (snr(_good(), marked) for marked, _ in (_usual(scheme), half.embed(_good(), SEED)))
    if not half_snr > full_snr:
        raise Broken(f"the SNR is {full_snr:.2f} dB with all of {field}, and {half_snr:.2f} dB with half.")


def open_mesh_is_marked_or_refused(scheme: Scheme) -> None:
    """A mesh with a hole is marked and read, or refused by a `Wm3dError`."""
    _marked_or_refused(scheme, samples.opened(_good()))


def inward_wound_mesh_is_marked_or_refused(scheme: Scheme) -> None:
    """A mesh whose faces are wound inward is marked and read, or refused by a `Wm3dError`."""
    _marked_or_refused(scheme, samples.inside_out(_good()))


def odd_meshes_are_marked_or_refused(scheme: Scheme) -> None:
    """A sheet, a sphere and a box of twelve faces are marked and read, or refused by a `Wm3dError`."""
    for mesh in (samples.sheet(), samples.sphere(), samples.box()):
        _marked_or_refused(scheme, mesh)


SCHEME_CHECKS: tuple[Callable[[Scheme], None], ...] = (
    has_a_name,
    parameters_survive_json,
    label_is_its_own,
    engines_are_installed,
    embedding_is_deterministic,
    other_seeds_mark_otherwise,
    faces_stay,
    evidence_has_a_weight_for_each_sign,
    right_key_is_found,
    unmarked_mesh_shows_no_mark,
    wrong_keys_follow_the_null,
    key_survives_json,
    strength_sets_the_distortion,
    open_mesh_is_marked_or_refused,
    inward_wound_mesh_is_marked_or_refused,
    odd_meshes_are_marked_or_refused,
)


@cache
def _good() -> Mesh:
    return samples.potato(5)


@lru_cache(maxsize=1)  # most checks look at it
def _usual(scheme: Scheme) -> tuple[Mesh, Scheme]:
    with global_state(1):
        return scheme.embed(_good(), SEED)


def _read(scheme: Scheme, original: Mesh, mesh: Mesh) -> RademacherSum:
    return scheme.with_original(original).evidence(mesh)


def _marked_or_refused(scheme: Scheme, mesh: Mesh) -> None:
    try:
        marked, its = scheme.embed(mesh, SEED)
        evidence = _read(its, mesh, marked)
    except Wm3dError:
        return
    except Exception as error:  # what foreign code may raise; a run would call it a fault of the program
        raise Broken(f"{mesh.name}: it raises {type(error).__name__} ({error}), not Wm3dError.") from error
    if evidence.b.shape != (its.capacity,):
        raise Broken(f"{mesh.name}: evidence has {evidence.b.size} weights, capacity is {its.capacity}.")
