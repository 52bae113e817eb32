"""The tail of a sum of some hundred signs from its distribution on a grid: never below the truth."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.stats.weights import tie_slack

MOST_SIGNS = 256
"""Beyond them the grid is too coarse, and the saddlepoint good enough."""

CELLS = 1 << 17
"""Of the grid, from 0 to Σ a."""


class Costs(NamedTuple):
    """Law of what the signs that are down take from the largest sum, with weights rounded to the grid.

    Attributes
    ----------
    share : ndarray
        P(cost ≤ k cells) for k = 0, 1, ... up to half of the largest cost and a little more.
    cell : float
        Width of a cell.
    reach : float
        Largest sum, of rounded weights.
    error : float
        By how much rounding can change a sum at most: Σ |a_k − rounded a_k|.
    """

    share: FloatArray
    cell: float
    reach: float
    error: float


def grid_log10(a: FloatArray, z: FloatArray) -> FloatArray:
    """Return a bound from above of log10 P(Σ ± a_k ≥ z) for unit weights and (m,) thresholds within ±Σ a.

    A sum reaches z only if the sum of rounded weights reaches z less what rounding changes at most. For 64
    weights that is about 0.001 and for 256 about 0.008, so the bound is above the truth by 1 and 6 % at
    z = 7. Where weights are all but equal, sums form clusters, and within one the bound may be farther off.
    """
    costs = _costs(a.tobytes())
    error = costs.error + tie_slack(a)
    up = z >= 0
    reached = np.floor((costs.reach - z + error) / costs.cell)
    passed = np.ceil((costs.reach + z - error) / costs.cell) - 1  # for sure, −z < 0 by the other signs
    cells = np.where(up, reached, passed).astype(np.int64)
    share = np.where(cells < 0, 0.0, costs.share[np.clip(cells, 0, len(costs.share) - 1)])
    bound: FloatArray = np.log10(np.minimum(np.where(up, share, 1.0 - share), 1.0))
    return bound


@lru_cache(maxsize=8)  # many keys are scored on one mesh
def _costs(weights: bytes) -> Costs:
    a = np.sort(np.frombuffer(weights))
    cell = float(a.sum()) / CELLS
    steps: IntArray = np.rint(2 * a / cell).astype(np.int64)
    mass, end = np.zeros(CELLS + len(a)), 1
    mass[0] = 1.0
    for step in steps:
        half = mass[:end] / 2
        end = min(end + int(step), len(mass))
        mass[: len(half)] = half
        if step < end:
            mass[step:end] += half[: end - step]
    rounded = steps * cell / 2
    return Costs(np.cumsum(mass), cell, float(rounded.sum()), float(np.abs(a - rounded).sum()))
