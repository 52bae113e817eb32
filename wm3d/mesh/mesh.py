"""The triangle mesh that everything works on: vertices, faces, their checks and their content hash."""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wm3d.arrays import BoolArray, FloatArray, IntArray
from wm3d.errors import Wm3dError
from wm3d.mesh import kernels

#: Largest coordinate, and one over the least extent: their fifth powers, as in volume moments, stay finite.
LARGEST = 1e50


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """An immutable triangle mesh.

    Parameters
    ----------
    vertices : (n, 3) array_like of float
        Coordinates, in the unit of the file. Copied to float64 and made read-only; an array that is both
        already, and owns its data, is kept.
    faces : (m, 3) array_like of int
        Vertex indices, counter-clockwise seen from outside. Copied to int64 and made read-only.
    name : str
        What messages and tables call this mesh, for example its file name.

    Raises
    ------
    Wm3dError
        If there are no faces, a coordinate is NaN, infinite or beyond `LARGEST`, a face names a vertex that
        does not exist, or all vertices lie in one point.

    Notes
    -----
    Unreferenced vertices, open boundaries and non-manifold edges are allowed.
    """

    vertices: FloatArray
    faces: IntArray
    name: str = "mesh"

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _frozen_vertices(self.vertices, self.name))
        object.__setattr__(self, "faces", _frozen_faces(self.faces, self.name))
        self._check_vertices()
        self._check_faces()

    def __repr__(self) -> str:
        return f"Mesh({self.name!r}, {len(self.vertices)} vertices, {len(self.faces)} faces)"

    def _check_vertices(self) -> None:
        if self.vertices.size == 0:
            return
        low, high, finite = self._bounds
        if not finite:
            bad = int(np.flatnonzero(~np.isfinite(self.vertices).all(axis=1))[0])
            raise Wm3dError(f"{self.name}: vertex {bad} has a coordinate that is NaN or infinite.")
        if (largest := max(-low.min(), high.max())) > LARGEST:
            raise Wm3dError(f"{self.name}: a coordinate is {largest:g}; rescale it to below {LARGEST:g}.")
        if (high - low).max() < 1 / LARGEST:
            raise Wm3dError(f"{self.name}: all vertices lie in one point, so the mesh has no extent.")

    def _check_faces(self) -> None:
        if len(self.faces) == 0:
            raise Wm3dError(f"{self.name}: has no faces; wm3d needs a triangle mesh, not a point cloud.")
        low, high = int(self.faces.min()), int(self.faces.max())
        if low < 0 or high >= len(self.vertices):
            missing = low if low < 0 else high
            last = len(self.vertices) - 1
            raise Wm3dError(f"{self.name}: a face names vertex {missing}, but the vertices are 0 to {last}.")

    def with_vertices(self, vertices: ArrayLike) -> "Mesh":
        """Return the same faces over other vertices.

        Parameters
        ----------
        vertices : (n, 3) array_like of float
            New coordinates, one row for each vertex of this mesh.
        """
        moved = _frozen_vertices(vertices, self.name)
        if moved.shape != self.vertices.shape:
            raise Wm3dError(f"{self.name}: expected {self.vertices.shape} vertices, got {moved.shape}.")
        mesh = object.__new__(Mesh)  # the faces were checked once
        for field, value in (("vertices", moved), ("faces", self.faces), ("name", self.name)):
            object.__setattr__(mesh, field, value)
        mesh.__dict__["used"] = self.used  # by the same faces
        mesh._check_vertices()
        return mesh

    @cached_property
    def _bounds(self) -> tuple[FloatArray, FloatArray, bool]:
        low, high, finite = kernels.bounds(self.vertices)
        return low, high, finite

    @cached_property
    def vertex_mean(self) -> FloatArray:
        """Mean m (3,) of all vertices, used or not, in the unit of the mesh, as the paper has it."""
        return _frozen_mean(self.vertices)

    @cached_property
    def middle(self) -> FloatArray:
        """Mean (3,) of the vertices that a face uses, in the unit of the mesh."""
        return self.vertex_mean if self.used.all() else _frozen_mean(self.vertices[self.used])

    @cached_property
    def used(self) -> BoolArray:
        """Which vertices a face uses: (n,)."""
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.faces] = True
        used.flags.writeable = False
        return used

    @cached_property
    def diagonal(self) -> float:
        """Length of the diagonal of the axis-aligned bounding box of the vertices that a face uses.

        Of all vertices where the faces use but one point.
        """
        low, high, _ = self._bounds
        if not self.used.all():
            near, far, _ = kernels.bounds(self.vertices[self.used])
            low, high = (near, far) if (far - near).max() >= 1 / LARGEST else (low, high)
        return float(np.linalg.norm(high - low))

    def digest(self) -> str:
        """Return the sha256 (hex) of vertices and faces; the name does not count."""
        content = hashlib.sha256(f"{len(self.vertices)} {len(self.faces)}\n".encode())
        content.update(self.vertices.astype("<f8", copy=False).tobytes())
        content.update(self.faces.astype("<i8", copy=False).tobytes())
        return content.hexdigest()


def _frozen_mean(vertices: FloatArray) -> FloatArray:
    mean: FloatArray = kernels.vertex_mean(vertices)
    mean.flags.writeable = False
    return mean


def _frozen_vertices(values: ArrayLike, name: str) -> FloatArray:
    rows = _rows(values, name, "vertices")
    shared = rows.flags.owndata and not rows.flags.writeable
    vertices = np.array(rows, dtype=np.float64, order="C", copy=None if shared else True)
    vertices.flags.writeable = False
    return vertices


def _frozen_faces(values: ArrayLike, name: str) -> IntArray:
    rows = _rows(values, name, "faces")
    with np.errstate(invalid="ignore"):
        faces = np.array(rows, dtype=np.int64, order="C")
    if not np.array_equal(faces, rows):
        raise Wm3dError(f"{name}: faces must hold whole numbers, the indices of vertices.")
    faces.flags.writeable = False
    return faces


def _rows(values: ArrayLike, name: str, what: str) -> NDArray[Any]:
    try:
        rows = np.asarray(values)
    except ValueError as error:  # rows of different lengths
        raise Wm3dError(f"{name}: {what} must be an (n, 3) array of numbers.") from error
    if rows.ndim != 2 or rows.shape[1] != 3 or rows.dtype.kind not in "iuf":
        raise Wm3dError(f"{name}: {what} must be an (n, 3) array of numbers, got {rows.dtype} {rows.shape}.")
    return rows
