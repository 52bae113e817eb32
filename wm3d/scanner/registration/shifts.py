"""Shifts that the search tries: in whole cells, on an even grid, in runs that are looked up side by side."""

import itertools
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from wm3d.arrays import FloatArray, IntArray
from wm3d.scanner.registration.search_kernels import CELL, RUN

REACH = 1.7
"""How far from the middle of the landmarks that of the surface is looked for, in what these spread in the
same direction."""

FINENESS = 1e-6
"""Distances are told apart to that."""


def even_shifts(points: FloatArray, step: int) -> IntArray:
    """Return places amid points of middle 0, in cells and a step apart: (b, 3), the nearest to it first."""
    most = int(REACH / CELL / step)
    grid = step * np.array(list(itertools.product(range(-most, most + 1), repeat=3)))
    spread = np.cov(points.T) / CELL**2 + np.eye(3)  # a cell at least, as of a flat sheet
    far = np.einsum("bi,ij,bj->b", grid, np.linalg.inv(spread), grid)
    order = np.argsort(far, kind="stable")
    shifts: IntArray = grid[order[far[order] <= REACH**2]]
    return shifts


class Runs(NamedTuple):
    """Shifts and a cube of distances as `search_kernels.nearest_tried` takes them.

    Attributes
    ----------
    starts : (c, 3) ndarray
    rank : (c, `RUN`) ndarray
        Which of the shifts each is; -1 where a run has fewer.
    distance : (x, y, step, z) ndarray
    """

    starts: IntArray
    rank: IntArray
    distance: NDArray[np.int32]

    @classmethod
    def of(cls, shifts: IntArray, step: int, cube: FloatArray) -> Self:
        """Lay (b, 3) shifts, multiples of a step and as far both ways, in runs along a cube's last axis."""
        most = np.abs(shifts).max(axis=0)
        lines, line = np.unique(shifts[:, :2], axis=0, return_inverse=True)
        along = (shifts[:, 2] + most[2]) // step
        runs, run = np.unique(np.column_stack([line.ravel(), along // RUN]), axis=0, return_inverse=True)
        rank = np.full((len(runs), RUN), -1)
        rank[run.ravel(), along % RUN] = np.arange(len(shifts))
        starts = np.column_stack([lines[runs[:, 0]] + most[:2], RUN * runs[:, 1]])
        return cls(starts, rank, _interleaved(cube, most, step))


def _interleaved(cube: FloatArray, most: IntArray, step: int) -> NDArray[np.int32]:
    """Return a cube in whole numbers, with room for shifts and runs, every step-th cell beside the other."""
    room = np.column_stack([most, most])
    room[2, 1] += RUN * step
    room[2, 1] += -(cube.shape[2] + room[2].sum()) % step
    whole = np.pad(np.rint(cube / FINENESS).astype(np.int32), room, mode="edge")
    apart = whole.reshape(*whole.shape[:2], -1, step).swapaxes(2, 3)
    return np.ascontiguousarray(apart)
