"""The verbs of the Python interface: embed and detect."""

import operator
from typing import Any

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.schemes import SCHEMES, Key, Scheme
from wm3d.stats import Score

DEFAULT_SCHEME = "song2002"


def embed(
    mesh: Mesh,
    *,
    seed: int,
    scheme: str | Scheme = DEFAULT_SCHEME,
    snr: float | None = None,
    **parameters: Any,
) -> tuple[Mesh, Key]:
    """Mark a mesh.

    Parameters
    ----------
    mesh : Mesh
    seed : int
        The secret; 0 ≤ seed < 2^256.
    scheme : str or Scheme
        A scheme, or its name with `parameters`.
    snr : float, optional
        Wanted signal-to-noise ratio in dB (eq. 13); the strength of the scheme follows from it.
    **parameters
        Parameters of the scheme, for example ``alpha=0.9, grid=(84, 120)``.

    Returns
    -------
    marked : Mesh
        Same faces, moved vertices.
    key : Key
        What `detect` needs; the key in memory also has the original at hand where the scheme is not blind.

    Raises
    ------
    Wm3dError
        If a parameter is wrong or the mesh cannot carry the mark.
    """
    if isinstance(scheme, Scheme):
        if parameters:
            raise Wm3dError(
                f"parameters {sorted(parameters)} go with the name of a scheme, not with a scheme."
            )
        chosen = scheme
    else:
        chosen = SCHEMES.build(scheme, parameters)
    seed = _checked_seed(seed)
    if snr is not None:
        chosen = chosen.at_snr(mesh, seed, snr)
    marked, chosen = chosen.embed(mesh, seed)
    return marked, Key(chosen, seed)


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
        If the mesh cannot be read, or the original is missing or another mesh.
    """
    return (key if original is None else key.with_original(original)).score(mesh)
