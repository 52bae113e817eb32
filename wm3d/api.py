"""The verbs of the Python interface: embed and detect."""

import operator
import secrets
from collections.abc import Collection
from typing import Any

from wm3d.errors import Wm3dError, shown
from wm3d.mesh import Mesh
from wm3d.schemes import SCHEMES, Key, Scheme
from wm3d.stats import Score

DEFAULT_SCHEME = "range-dct"
PAPER_SCHEME = "song2002"
PAPER_PARAMETERS = {"grid", "region", "miss", "normalize"}
"""Parameters by which a caller who names no scheme asks for the paper's."""

SEED_BITS = 128
"""Size of the random secret of `embed`: beyond any search, and short enough to copy."""


def default_scheme(parameters: Collection[str]) -> str:
    """Return the scheme of a caller who names none: the robust one, or the paper's if a parameter is its."""
    return DEFAULT_SCHEME if PAPER_PARAMETERS.isdisjoint(parameters) else PAPER_SCHEME


def embed(
    mesh: Mesh,
    *,
    seed: int | None = None,
    scheme: str | Scheme | None = None,
    snr: float | None = None,
    **parameters: Any,
) -> tuple[Mesh, Key]:
    """Mark a mesh.

    Parameters
    ----------
    mesh : Mesh
    seed : int, optional
        The secret, 0 ≤ seed < 2^256; `SEED_BITS` random bits if omitted.
    scheme : str or Scheme, optional
        A scheme, or its name with `parameters`; `default_scheme` if omitted.
    snr : float, optional
        Wanted signal-to-noise ratio in dB (eq. 13); the strength of the scheme follows from it.
    **parameters
        Parameters of the scheme, for example ``alpha=0.9``.

    Returns
    -------
    marked : Mesh
        Same faces, moved vertices.
    key : Key
        What `detect` needs; the key in memory also has the original at hand where the scheme is not blind.

    Raises
    ------
    Wm3dError
        If a parameter is wrong, `mesh` is no `Mesh`, or it cannot carry the mark.
    """
    chosen = _chosen(scheme, parameters)
    _check(mesh, Mesh, "the mesh", "wm3d.load_mesh reads one from a file")
    seed = secrets.randbits(SEED_BITS) if seed is None else _checked_seed(seed)
    if snr is not None:
        if chosen.strength in parameters:
            raise Wm3dError(f"{chosen.strength} and snr both set the strength of the mark; give one of them.")
        chosen = chosen.at_snr(mesh, seed, _checked_snr(snr))
    marked, chosen = chosen.embed(mesh, seed)
    return marked, Key(chosen, seed)


def _chosen(scheme: Any, parameters: dict[str, Any]) -> Scheme:
    if "name" in parameters:
        raise Wm3dError(f"name={shown(parameters['name'])}: is no parameter; name a scheme by scheme=.")
    if isinstance(scheme, Scheme):
        if parameters:
            raise Wm3dError(
                f"parameters {sorted(parameters)} go with the name of a scheme, not with a scheme."
            )
        return scheme
    if scheme is None:
        scheme = default_scheme(parameters)
    if not isinstance(scheme, str):
        given = scheme.__name__ if isinstance(scheme, type) else shown(scheme)
        raise Wm3dError(f"the scheme is {given}; give the name of a scheme, or one built of it.")
    return SCHEMES.build(scheme, parameters)


def _check(value: object, wanted: type, what: str, remedy: str) -> None:
    if not isinstance(value, wanted):
        raise Wm3dError(f"{what} is a {type(value).__name__}, not a wm3d.{wanted.__name__}; {remedy}.")


def _checked_seed(seed: Any) -> int:
    try:
        value = int(operator.index(seed))
    except TypeError:
        value = -1
    if not 0 <= value < 1 << 256:
        raise Wm3dError(f"the seed is {shown(seed)}; it must be an integer from 0 to 2^256 − 1.")
    return value


def _checked_snr(snr: Any) -> float:
    try:
        return float(snr)
    except (TypeError, ValueError, OverflowError):
        raise Wm3dError(f"the SNR is {shown(snr)}; it must be a number of decibels.") from None


def detect(mesh: Mesh, key: Key, *, original: Mesh | None = None) -> Score:
    """Look for a key in a mesh.

    Parameters
    ----------
    mesh : Mesh
    key : Key
    original : Mesh, optional
        The mesh before it was marked. A blind scheme does not look at it; for another it must be given with a
        key that comes from a file.

    Returns
    -------
    Score
        With ``statistic``, ``z``, ``log10_p``, ``p_value`` and ``detected(pf)``.

    Raises
    ------
    Wm3dError
        If `mesh` or `original` is no `Mesh` or `key` no `Key`, the mesh cannot be read, or the original that
        the scheme reads against is missing or another mesh.
    """
    _check(mesh, Mesh, "the mesh", "wm3d.load_mesh reads one from a file")
    _check(key, Key, "the key", "wm3d.Key.load reads one from a file")
    if original is not None:
        _check(original, Mesh, "the original", "wm3d.load_mesh reads one from a file")
        key = key.with_original(original)
    return key.score(mesh)
