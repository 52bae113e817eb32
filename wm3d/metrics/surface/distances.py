"""Distances between two surfaces, whatever their connectivity: Hausdorff, MRMS and the deviation of normals.

All three are two-sided and take exact distances of points on one surface from the faces of the other. The
points are the vertices, and three in each cell: the faces are bisected into cells until no edge is longer
than `SPACING`. The three points, half-way from the centroid to the corners, integrate squares exactly.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics.surface import kernels
from wm3d.metrics.surface.nearest import Surface
from wm3d.threads import two_threads

SPACING = 0.01
"""Longest edge of a cell, over the diagonal of the original's bounding box."""

TOLERANCE = 2e-4
"""Wanted error of the Hausdorff distance, over the same diagonal."""

MOST_CELLS = 200_000
"""Cells that are split at most to bring the error of the Hausdorff distance down to `TOLERANCE`."""

MOST_CUT, MOST_CUT_A_FACE = 2_000_000, 3
"""Cells that a surface may be cut into, and more for each face, by the estimate: some 2.5 GB, and a minute.
Faces that are not cut cost what the mesh does, and do not count."""


class OneWay(NamedTuple):
    """What lies between one surface and the nearest points of the other, in mesh units.

    The true greatest distance lies between `farthest` and `farthest` + `farthest_error`, the true root mean
    square within `rms` ± `rms_error`. `angle` is the mean angle between the normals, in degrees. `rms` and
    `angle` are NaN for a surface without area.
    """

    farthest: float
    farthest_error: float
    rms: float
    rms_error: float
    angle: float


def hausdorff(original: Mesh, other: Mesh) -> float:
    """Two-sided Hausdorff distance, the greatest distance of any point of one surface from the other.

    Returns
    -------
    float
        In mesh units; never above the true distance, and below it by at most `hausdorff_error`.
    """
    return max(way.farthest for way in both_ways(original, other))


def hausdorff_error(original: Mesh, other: Mesh) -> float:
    """Bound on how far `hausdorff` is below the true distance, in mesh units.

    `TOLERANCE` of the diagonal, unless that would take more than `MOST_CELLS` cells: where wide parts of the
    surfaces are equally far from each other and differ in tessellation.
    """
    ways = both_ways(original, other)
    return max(way.farthest + way.farthest_error for way in ways) - hausdorff(original, other)


def mrms(original: Mesh, other: Mesh) -> float:
    """Maximum of the two root mean square distances, each over the area of one surface from the other.

    Returns
    -------
    float
        In mesh units; off the true value by at most `SPACING` / 6 of the diagonal, and in practice far less:
        the rule is exact where the distance to a plane of the other surface is taken over a whole cell.

    Raises
    ------
    Wm3dError
        If a surface has no area.
    """
    _check_area(original, other)
    return max(way.rms for way in both_ways(original, other))


def normal_deviation(original: Mesh, other: Mesh) -> float:
    """Mean angle between the face normals at nearest points of the two surfaces, in degrees.

    For each point of a surface, the nearest point of the other; the mean is over the area and both
    directions. Normals follow the winding of the faces. Where the nearest point lies on an edge, the normal
    is that of one of its faces.

    Raises
    ------
    Wm3dError
        If a surface has no area.
    """
    _check_area(original, other)
    there, back = both_ways(original, other)
    return (there.angle + back.angle) / 2


# the metrics of one pair are asked for one after the other, and share nearly all of their work
@lru_cache(maxsize=1)
def both_ways(original: Mesh, other: Mesh) -> tuple[OneWay, OneWay]:
    """Measure from the original to the other surface and back, on `two_threads`.

    Raises
    ------
    Wm3dError
        If a surface is so large, over the diagonal of the original, that it would make too many cells.
    """
    check_size(original, other)
    origin, unit = original.middle, original.diagonal
    with two_threads() as pool:
        a, b = pool.map(lambda mesh: Surface((mesh.vertices - origin) / unit, mesh.faces), (original, other))
        there, back = pool.map(_one_way, (a, b), (b, a), (unit, unit))
    return there, back


def check_size(original: Mesh, other: Mesh) -> None:
    """Refuse surfaces that are too large over the diagonal of the original, before they take hours.

    Raises
    ------
    Wm3dError
        If either would make far more cells than it has faces.
    """
    for mesh in (original, other):
        _check_one(original, mesh)


def _check_one(original: Mesh, mesh: Mesh) -> None:
    cut = kernels.cells_cut(mesh.vertices[mesh.faces], SPACING * original.diagonal)
    if cut <= MOST_CUT + MOST_CUT_A_FACE * len(mesh.faces):
        return
    ratio = mesh.diagonal / original.diagonal
    if ratio > 2:
        raise Wm3dError(
            f"{mesh.name}: is {ratio:,.0f} times as large as {original.name}; bring them to one unit."
        )
    raise Wm3dError(
        f"{mesh.name}: its surface is too folded to be measured, in some {cut:.0e} cells of {SPACING:.0%} of "
        "the diagonal; smooth it first."
    )


def _check_area(*meshes: Mesh) -> None:
    for mesh, way in zip(meshes, both_ways(*meshes), strict=True):
        if math.isnan(way.rms):
            raise Wm3dError(f"{mesh.name}: its faces have no area, which a mean over the surface needs.")


def _one_way(source: Surface, target: Surface, unit: float) -> OneWay:
    cells, face = kernels.cells(source.corners, SPACING)
    centroids, areas, reach, spread = kernels.moments(cells)
    found = target.nearest(((cells + centroids[:, None]) / 2).reshape(-1, 3))
    distances = found.distance.reshape(-1, 3)
    farthest = max(distances.max(), target.nearest(source.points).distance.max())
    # from one of the points to the farthest corner it is at most 3/2 of the way from the centroid
    upper = distances.min(axis=1) + 1.5 * reach
    farthest, error = _refine(cells, upper, found.face.reshape(-1, 3), target, farthest)
    total = areas.sum()
    if total == 0:
        return OneWay(farthest * unit, error * unit, math.nan, math.nan, math.nan)
    rms = np.sqrt(areas @ (distances**2).mean(axis=1) / total)
    # the points of a third of a cell's area lie within a third of the mean square about the centroid
    rms_error = np.sqrt(areas @ spread / total / 3)
    angles = kernels.angles(source.normals, target.normals, np.repeat(face, 3), found.face)
    angle = areas @ angles.reshape(-1, 3).mean(axis=1) / total
    return OneWay(farthest * unit, error * unit, rms * unit, rms_error * unit, math.degrees(angle))


def _refine(
    cells: FloatArray, upper: FloatArray, faces: IntArray, target: Surface, farthest: float
) -> tuple[float, float]:
    """Split the cells (k, 3, 3) that may hold a point beyond `farthest`; return the farthest and its error.

    `upper` (k,) bounds the distance of all points of each cell; `faces` (k, s) are target faces nearby.
    """
    ceiling, spent, spacing = farthest, 0, SPACING
    while True:
        may = np.flatnonzero(upper > farthest + TOLERANCE)
        for near in faces[may].T:
            corners = kernels.farthest_corner(cells[may], target.corners, near)
            upper[may] = np.minimum(upper[may], np.sqrt(corners))
        may = may[upper[may] > farthest + TOLERANCE]
        spent += len(may)
        if len(may) == 0 or spent > MOST_CELLS:
            return farthest, max(ceiling, upper.max()) - farthest
        ceiling = max(ceiling, upper[upper <= farthest + TOLERANCE].max(initial=0.0))
        spacing *= 0.6
        cells, _ = kernels.cells(cells[may], spacing)
        centroids, _, reach, _ = kernels.moments(cells)
        found = target.nearest(centroids)
        farthest = max(farthest, found.distance.max())
        # the distance from a surface grows no faster than the way gone
        upper, faces = found.distance + reach, found.face[:, None]
