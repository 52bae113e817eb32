"""The verbs of the Python interface: embed and detect."""

import operator
from collections.abc import Collection
from typing import Any

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.schemes import SCHEMES, Key, Scheme
from wm3d.stats import Score

DEFAULT_SCHEME = "range-dct"
PAPER_SCHEME = "song2002"
PAPER_PARAMETERS = {"grid", "region", "miss", "normalize"}
"""Parameters by which a caller who names no scheme asks for the paper's."""


def default_scheme(parameters: Collection[str]) -> str:
    """Return the scheme of a caller who names none: the robust one, or the paper's if a parameter is its."""
    return DEFAULT_SCHEME if PAPER_PARAMETERS.isdisjoint(parameters) else PAPER_SCHEME


def embed(
    mesh: Mesh,
    *,
    seed: int,
    scheme: str | Scheme | None = None,
    snr: float | None = None,
    **parameters: Any,
) -> tuple[Mesh, Key]:
    """Mark a mesh.

    Parameters
    ----------
    mesh : Mesh
    seed : int
        The secret; 0 ≤ seed < 2^256.
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
    if isinstance(scheme, Scheme):
        if parameters:
            raise Wm3dError(
                f"parameters {sorted(parameters)} go with the name of a scheme, not with a scheme."
            )
        chosen = scheme
    else:
        chosen = SCHEMES.build(scheme or default_scheme(parameters), parameters)
    _check(mesh, Mesh, "the mesh", "wm3d.load_mesh reads one from a file")
    seed = _checked_seed(seed)
    if snr is not None:
        chosen = chosen.at_snr(mesh, seed, snr)
    marked, chosen = chosen.embed(mesh, seed)
    return marked, Key(chosen, seed)


def _check(value: object, wanted: type, what: str, remedy: str) -> None:
    if not isinstance(value, wanted):
        raise Wm3dError(f"{what} is a {type(value).__name__}, not a wm3d.{wanted.__name__}; {remedy}.")


def _checked_seed(seed: Any) -> int:
    try:
        value = int(operator.index(seed))
    except TypeError:
        value = -1
    if not 0 <= value < 1 << 256:
        raise Wm3dError(f"the seed is {seed!r}; it must be an integer from 0 to 2^256 − 1.")
    return value


def detect(mesh: Mesh, key: Key, *, original: Mesh | None = None) -> Score:
    """Look for a key in a mesh.

    Parameters
    ----------
    mesh : Mesh
    key : Key
    original : Mesh, optional
        The mesh before it was marked. A blind scheme does not need it; for another it must be given with a
        key that comes from a file.

    Returns
    -------
    Score
        With ``statistic``, ``z``, ``log10_p``, ``p_value`` and ``detected(pf)``.

    Raises
    ------
    Wm3dError
        If `mesh` is no `Mesh` or `key` no `Key`, the mesh cannot be read, or the original is missing or
        another mesh.
    """
    _check(mesh, Mesh, "the mesh", "wm3d.load_mesh reads one from a file")
    _check(key, Key, "the key", "wm3d.Key.load reads one from a file")
    return (key if original is None else key.with_original(original)).score(mesh)
