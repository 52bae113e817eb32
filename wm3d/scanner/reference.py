"""Plain numpy twin of the ray casting: every face of a row against every ray, by Plücker side tests."""

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.scanner.kernels import directions


def cast_reference(
    posed: FloatArray, faces: IntArray, planes: FloatArray, columns: int, radius: float, outward: int
) -> FloatArray:
    """Return what `kernels.cast` returns, by another route and about a hundred times slower.

    The line through (plane, 0, 0) along e meets a closed triangle if its side products with the three
    directed edges, det(a − o, b − o, e), do not differ in sign; the range there is eq. 7 of the paper.
    Parameters and result as for `wm3d.scanner.kernels.cast`.
    """
    e2, e1 = directions(columns)
    ranges = np.full((len(planes), columns), np.nan)
    corner_heights = posed[faces, 0]
    low, high = corner_heights.min(axis=1), corner_heights.max(axis=1)
    for row, plane in enumerate(planes):
        touched = faces[(low <= plane) & (plane <= high)]
        if len(touched) == 0:
            continue
        a, b, c = (posed[touched[:, k]] - [plane, 0.0, 0.0] for k in range(3))
        normal = -outward * np.cross(b - a, c - a)  # minus: s1, s2, s3 are left-handed
        facing = normal[:, 1, None] * e1 + normal[:, 2, None] * e2
        sides = np.stack([_side(p, q, e1, e2) for p, q in ((a, b), (b, c), (c, a))])
        met = ((sides >= 0).all(axis=0) | (sides <= 0).all(axis=0)) & (facing > 0)
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = np.einsum("ij,ij->i", a, normal)[:, None] / facing
        nearest = np.where(met, distance, -np.inf).max(axis=0)
        ranges[row] = np.where(nearest == -np.inf, np.nan, radius - nearest)
    return ranges


def _side(p: FloatArray, q: FloatArray, e1: FloatArray, e2: FloatArray) -> FloatArray:
    """det(p, q, e) for every directed edge pq and direction e: (faces, columns); exactly odd in p, q."""
    across = p[:, 2] * q[:, 0] - p[:, 0] * q[:, 2]
    depth = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    return across[:, None] * e1 + depth[:, None] * e2
