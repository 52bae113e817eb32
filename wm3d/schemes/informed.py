"""Informed embedding: the moves that make a volume image say the signs of a key, at a given size.

The embedder knows the host and how the image answers every move, so it need not add a fixed pattern and bear
what the host and the neighbours of a cell do to it (Cox, Miller and McKellips, "Watermarking as
communications with side information", 1999). It climbs from that pattern, by accelerated gradient steps (Beck
and Teboulle's FISTA, 2009), to where more coefficients say their sign, and say it with a margin. What it
climbs is not concave, so this is a better place and not the best.
"""

import math

import numpy as np

from wm3d.arrays import FloatArray, SignArray
from wm3d.imagemarks.blocks import AC, block_dct, inverse_block_dct
from wm3d.imagemarks.shaped_dct import Agreement
from wm3d.schemes import kernels
from wm3d.schemes.volume_host import Host

STEPS = 30
"""Steps from the pattern; with more, z still grows where nothing was lost and no longer under attacks."""

_POWERS = 8
"""Rounds of the power iteration that finds how long a step may be."""


def informed_moves(host: Host, signs: SignArray, size: float) -> FloatArray:
    """Return how far the places of a mesh move along their directions to carry a key: (p,), in mesh units.

    Steps are taken in the metric of the surface's area, so that neighbours move alike whatever their
    triangles; after each the moves are scaled back to their size where they exceed it. In the metric of the
    size, which counts vertices, moves would grow where triangles are large.

    Parameters
    ----------
    host : Host
    signs : (63 · blocks,) array of ±1
    size : float
        Root mean square move of the vertices, in mesh units.
    """
    along = pattern_moves(host, signs, size)
    agreement = Agreement.of(host.mark, signs, change_of(host, along))
    if agreement is None:
        return along
    step = 1.0 / _stiffness(host, agreement, along)
    ahead, momentum = along, 1.0
    for _ in range(STEPS):
        slope = agreement.gradient(host.mark.received + change_of(host, ahead))
        new = ahead + step * _per_area(host, pulled(host, slope))
        new *= min(1.0, size / host.size(new))
        faster = (1.0 + math.sqrt(1.0 + 4.0 * momentum**2)) / 2.0
        ahead = new + (momentum - 1.0) / faster * (new - along)
        along, momentum = new, faster
    return along * (size / host.size(along))


def pattern_moves(host: Host, signs: SignArray, size: float) -> FloatArray:
    """Return the moves that know of the host only its scale: the pattern of the key, read at each place."""
    pattern = inverse_block_dct(host.mark.pattern(signs), host.image.volumes.shape)
    along: FloatArray = kernels.image_at(host.posed, pattern, host.layout.hmin, host.layout.height)
    return along * (size / host.size(along))


def change_of(host: Host, along: FloatArray) -> FloatArray:
    """Return by how much moves (p,) change the AC coefficients, if the image is linear: (blocks, 63)."""
    image: FloatArray = (host.jacobian @ along).reshape(host.image.volumes.shape)
    return block_dct(image)[:, 1:]


def pulled(host: Host, slope: FloatArray) -> FloatArray:
    """Return the slope (p,) along moves of one (blocks, 63) along coefficients: adjoint of `change_of`."""
    full = np.zeros((len(slope), AC + 1))
    full[:, 1:] = slope
    image = inverse_block_dct(full, host.image.volumes.shape)
    pulled: FloatArray = host.jacobian.T @ image.ravel()
    return pulled


def _per_area(host: Host, slope: FloatArray) -> FloatArray:
    return np.divide(slope, host.area, out=np.zeros_like(slope), where=host.area > 0)


def _stiffness(host: Host, agreement: Agreement, start: FloatArray) -> float:
    """Largest curvature of the agreement in the metric of the area; a little below, as its bound is above."""
    moves, largest = start, 0.0
    for _ in range(_POWERS):
        moves = _per_area(host, pulled(host, agreement.curvature * change_of(host, moves)))
        largest = math.sqrt(float((host.area * moves**2).sum()))
        moves = moves / largest
    return largest
