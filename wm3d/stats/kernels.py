"""Compiled kernel of the Hadamard-key Monte Carlo, and its plain numpy twin."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

LANES = 16
"""Transforms that run side by side; their values alternate in memory, so every butterfly is a vector."""

MIN_ORDER = 16
"""Least Hadamard order: the count adds eight rows at a time, after the order may have been halved."""

_CACHED = 512 * LANES  # floats: 32 KB, within a first-level cache

Counts = NDArray[np.int32]


@njit(cache=True, nogil=True)
def _sign_table() -> NDArray[np.float32]:
    """Row `byte` holds the eight signs of its bits."""
    signs = np.empty((256, 8), np.float32)
    for byte in range(256):
        for bit in range(8):
            signs[byte, bit] = 1 - 2 * ((byte >> bit) & 1)
    return signs


@njit(cache=True, nogil=True)
def _draw_keys(
    x: NDArray[np.float32],
    weights: NDArray[np.float32],
    bits: NDArray[np.uint16],
    signs: NDArray[np.float32],
) -> None:
    """Fill row k of x with ±weights[k], the sign of lane l from bit l of bits[k]."""
    for k in range(weights.size):
        row = x[k * LANES : (k + 1) * LANES]
        low, high = signs[bits[k] & 255], signs[bits[k] >> 8]
        for lane in range(8):
            row[lane] = weights[k] * low[lane]
        for lane in range(8):
            row[8 + lane] = weights[k] * high[lane]


@njit(cache=True, nogil=True)
def _one_stage(x: NDArray[np.float32]) -> None:
    """One butterfly stage between the halves of x; slices let the loop vectorize."""
    p, q = x[: x.size // 2], x[x.size // 2 :]
    for i in range(p.size):
        p[i], q[i] = p[i] + q[i], p[i] - q[i]


@njit(cache=True, nogil=True)
def _two_stages(x: NDArray[np.float32], width: int) -> None:
    """Two butterfly stages in one pass on each run of 4 `width` values."""
    for start in range(0, x.size, 4 * width):
        p, q = x[start : start + width], x[start + width : start + 2 * width]
        r, s = x[start + 2 * width : start + 3 * width], x[start + 3 * width : start + 4 * width]
        for i in range(width):
            a, b, c, d = p[i] + q[i], p[i] - q[i], r[i] + s[i], r[i] - s[i]
            p[i], q[i], r[i], s[i] = a + c, b + d, a - c, b - d


@njit(cache=True, nogil=True)
def _count(x: NDArray[np.float32], thresholds: NDArray[np.float32], counts: Counts) -> None:
    """Add to counts (T, LANES) how many values of each lane reach each of the ascending thresholds."""
    found = np.empty(LANES, np.int32)
    for t in range(thresholds.size):
        found[:] = 0
        for start in range(0, x.size, 8 * LANES):
            rows = x[start : start + 8 * LANES]
            for lane in range(LANES):
                hits = np.int32(0)
                for j in range(8):
                    hits += rows[j * LANES + lane] >= thresholds[t]
                found[lane] += hits
        counts[t] += found
        if not found.any():  # nor does any value reach a higher threshold
            return


@njit(cache=True, nogil=True)
def hadamard_exceedances(
    weights: NDArray[np.float32], bits: NDArray[np.uint16], thresholds: NDArray[np.float32]
) -> Counts:
    """Count, over the keys of each transform, the statistics that reach each threshold.

    Parameters
    ----------
    weights : (N,) ndarray of float32
        Weights, N a power of two of at least `MIN_ORDER`.
    bits : (groups, N) ndarray of uint16
        Bit l of bits[g, k] is the random sign d_k of transform l in group g.
    thresholds : (T,) ndarray of float32
        Ascending.

    Returns
    -------
    (groups, T, LANES) ndarray of int32
        Counts over the N keys h∘d, h the rows of the Hadamard matrix, one transform each.
    """
    counts = np.zeros((bits.shape[0], thresholds.size, LANES), np.int32)
    signs = _sign_table()
    x = np.empty(weights.size * LANES, np.float32)
    for group in range(bits.shape[0]):
        _draw_keys(x, weights, bits[group], signs)
        width = x.size
        if not weights.size & 0x55555555:  # an odd power of two
            _one_stage(x)
            width //= 2
        while width > _CACHED:
            width //= 4
            _two_stages(x, width)
        for start in range(0, x.size, width):
            part, inner = x[start : start + width], width
            while inner > LANES:
                inner //= 4
                _two_stages(part, inner)
            _count(part, thresholds, counts[group])
    return counts


def hadamard_exceedances_numpy(
    weights: NDArray[np.float32], bits: NDArray[np.uint16], thresholds: NDArray[np.float32]
) -> Counts:
    """Do what `hadamard_exceedances` does, in plain numpy and float64."""
    counts = np.empty((bits.shape[0], thresholds.size, LANES), np.int32)
    for group, words in enumerate(bits):
        down = (words[:, None] >> np.arange(LANES)) & 1
        x = np.where(down, -1.0, 1.0) * weights[:, None].astype(np.float64)
        width = len(weights) // 2
        while width:
            pairs = x.reshape(-1, 2, width, LANES)
            x = np.stack([pairs[:, 0] + pairs[:, 1], pairs[:, 0] - pairs[:, 1]], axis=1)
            width //= 2
        x = x.reshape(-1, LANES)
        counts[group] = (x[:, None, :] >= thresholds[:, None]).sum(axis=0)
    return counts
