"""Settling: the small moves that bring coefficients from where informed embedding left them to fine signs.

The image is all but linear in the moves, so what brings many coefficients to their places at once, by moves
as small as can be, is a damped least-squares problem (Paige and Saunders, ACM TOMS 8(1), 1982). A few rounds
of it, each from the image as it has become, leave most coefficients within some hundredths of a step.
Others resist: their moves would be large, and they are left where they are.
"""

import numpy as np

from wm3d.arrays import FloatArray, SignArray
from wm3d.imagemarks.fine_signs import FineSigns
from wm3d.schemes.informed import change_of, pulled
from wm3d.schemes.volume_host import Host

ROUNDS = 3
"""Rounds of least squares; the first takes the image to be linear from the original on."""

SOLVER_STEPS = 12
"""Steps of the solver in a round; with more, z grows by some percent where nothing was lost."""

DAMPING = 0.1
"""What a move costs, over the mean of what it does to the coefficients."""

RESISTS = 0.3
"""How far a coefficient may be from its place after the second round, in steps, to be brought nearer."""

_LATER = 0.006
"""By how much the size grows after the first round, as on the bunny and the Buddha; elsewhere by 0 to 2 %.
What it is off, all moves are scaled by in the end, and 0.3 % costs the third layer some of its z."""


def settled_moves(
    host: Host, fine: FineSigns, signs: SignArray, along: FloatArray, size: float
) -> FloatArray:
    """Return moves near to those of an informed embedder that say fine signs as well.

    Parameters
    ----------
    host : Host
    fine : FineSigns
    signs : (fine.capacity,) array of ±1
    along : (p,) ndarray
        Moves of the places along their directions, in mesh units.
    size : float
        Root mean square move of the vertices, in mesh units: of `along`, and of the result.
    """
    predicted = host.mark.received + change_of(host, along)
    moves = along + _brought(host, fine.nearest(predicted, signs) - predicted)
    # places do not shrink with the moves, so those are chosen for which the size comes out right
    start = along * (size / host.size(moves) / (1.0 + _LATER))
    seen = host.coefficients(moves)
    places = fine.nearest(seen - change_of(host, moves - start), signs)
    moves = moves + _brought(host, places - seen)
    for _ in range(ROUNDS - 2):
        left = places - host.coefficients(moves)
        moves = moves + _brought(host, np.where(np.abs(left) < RESISTS * fine.step, left, 0.0))
    return moves * (size / host.size(moves))


def _brought(host: Host, wanted: FloatArray) -> FloatArray:
    """Return moves (p,) that change the coefficients by about what is wanted: damped least squares.

    In units in which the area of the surface counts the moves, and that of its block each coefficient. The
    steps are those of CGLS, which LSQR takes too, but all sums are numpy's: BLAS makes those of long vectors
    depend on its threads, and SciPy's LSQR stops early where the unit of the mesh is large.
    """
    read = host.mark.carries
    weight = 1.0 / np.sqrt(host.mark.area[read])
    root = np.sqrt(np.divide(1.0, host.area, out=np.zeros_like(host.area), where=host.area > 0))

    def back(coefficients: FloatArray) -> FloatArray:
        full = np.zeros_like(wanted)
        full[read] = coefficients * weight
        return root * pulled(host, full)

    left = wanted[read] * weight
    moves, slope = np.zeros_like(root), back(left)
    size = _square(slope)
    if size == 0.0:
        return moves
    damping, way = DAMPING * size / _square(left), slope
    for _ in range(SOLVER_STEPS):
        seen = change_of(host, root * way)[read] * weight
        step = size / (_square(seen) + damping * _square(way))
        moves, left = moves + step * way, left - step * seen
        slope = back(left) - damping * moves
        before, size = size, _square(slope)
        way = slope + size / before * way
    return root * moves


def _square(values: FloatArray) -> float:
    return float((values**2).sum())
