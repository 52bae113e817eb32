"""The surface under test as evenly spread points, and where it lies nearest to given places."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, orientation, surface_area, surface_points
from wm3d.metrics.surface import boxes, tree_order
from wm3d.scanner.registration import kernels

POINTS = 30_000
"""Points on the surface; a fifth to a third of a cell apart from each other."""

NEIGHBOURS = 8
"""Points whose mean stands for the surface at a place: it lies amid the folds that noise makes."""


class _Tree(NamedTuple):
    """Points and their normals (m, 3) in the order of a tree, neighbours near each other, and its boxes."""

    points: FloatArray
    normals: FloatArray
    boxes: FloatArray

    @classmethod
    def of(cls, points: FloatArray, normals: FloatArray) -> Self:
        order = tree_order(points)
        points = points[order]
        return cls(points, normals[order], boxes(points[:, None]))


@dataclass(frozen=True, eq=False)
class Surface:
    """Evenly spread points of a surface, relative to their mean and in units of their root mean square.

    Attributes
    ----------
    points, normals : (`POINTS`, 3) ndarray
        The normals are outward and of unit length.
    middle : (3,) ndarray
        The mean, in the coordinates of the mesh.
    size : float
        The unit, in that of the mesh.
    tree : _Tree
        In which the nearest of them are searched.
    """

    points: FloatArray
    normals: FloatArray
    middle: FloatArray
    size: float
    tree: _Tree

    @classmethod
    def of(cls, mesh: Mesh) -> "Surface":
        """Spread points over the faces of a mesh.

        Raises
        ------
        Wm3dError
            If the faces have no area.
        """
        if not surface_area(mesh) > 0:
            raise Wm3dError(f"{mesh.name}: its faces have no area, so there is no surface to look at.")
        points, normals = surface_points(mesh.vertices, mesh.faces, POINTS)
        middle = points.mean(axis=0)
        points = points - middle
        size = float(np.sqrt((points**2).sum(axis=1).mean()))
        points /= size
        normals = orientation(mesh) * normals
        return cls(points, normals, middle, size, _Tree.of(points, normals))

    def placed(self, vertices: FloatArray) -> FloatArray:
        """Return vertices (n, 3) of the mesh in the coordinates of the points."""
        placed: FloatArray = (vertices - self.middle) / self.size
        return placed

    def near(self, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the mean point and the mean normal of the surface next to each of (k, 3) places."""
        points, normals = kernels.means_near(places, *self.tree, NEIGHBOURS)
        return points, normals
