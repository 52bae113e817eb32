"""The triangle mesh that everything works on: vertices, faces, their checks and their content hash."""

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wm3d.errors import Wm3dError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Mesh:
    """An immutable triangle mesh.

    Parameters
    ----------
    vertices : (n, 3) array_like of float
        Coordinates, in the unit of the file. Copied to float64 and made read-only.
    faces : (m, 3) array_like of int
        Vertex indices, counter-clockwise seen from outside. Copied to int64 and made read-only.
    name : str
        What messages and tables call this mesh, for example its file name.

    Raises
    ------
    Wm3dError
        If there are no faces, a coordinate is NaN or infinite, a face names a vertex that does not exist,
        or the faces in use have no extent.

    Notes
    -----
    Unreferenced vertices, open boundaries and non-manifold edges are allowed.
    """

    vertices: FloatArray
    faces: IntArray
    name: str = "mesh"

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", _frozen(self.vertices, np.float64, self.name, "vertices"))
        object.__setattr__(self, "faces", _frozen(self.faces, np.int64, self.name, "faces"))
        self._check_vertices()
        self._check_faces()

    def _check_vertices(self) -> None:
        if not np.isfinite(self.vertices).all():
            bad = int(np.flatnonzero(~np.isfinite(self.vertices).all(axis=1))[0])
            raise Wm3dError(f"{self.name}: vertex {bad} has a coordinate that is NaN or infinite.")
        if self.vertices.size and not np.ptp(self.vertices, axis=0).any():
            raise Wm3dError(f"{self.name}: all vertices lie in one point, so the mesh has no extent.")

    def _check_faces(self) -> None:
        if len(self.faces) == 0:
            raise Wm3dError(f"{self.name}: has no faces; wm3d needs a triangle mesh, not a point cloud.")
        low, high = int(self.faces.min()), int(self.faces.max())
        if low < 0 or high >= len(self.vertices):
            missing = low if low < 0 else high
            raise Wm3dError(
                f"{self.name}: a face names vertex {missing}, but the vertices are 0 to {len(self.vertices) - 1}."
            )

    def with_vertices(self, vertices: ArrayLike) -> "Mesh":
        """Return the same faces over other vertices.

        Parameters
        ----------
        vertices : (n, 3) array_like of float
            New coordinates, one row for each vertex of this mesh.
        """
        moved = _frozen(vertices, np.float64, self.name, "vertices")
        if moved.shape != self.vertices.shape:
            raise Wm3dError(f"{self.name}: expected {self.vertices.shape} vertices, got {moved.shape}.")
        mesh = object.__new__(Mesh)  # the faces were checked once
        for field, value in (("vertices", moved), ("faces", self.faces), ("name", self.name)):
            object.__setattr__(mesh, field, value)
        mesh._check_vertices()
        return mesh

    @property
    def diagonal(self) -> float:
        """Length of the diagonal of the axis-aligned bounding box of all vertices."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    def digest(self) -> str:
        """Return the sha256 (hex) of vertices and faces; the name does not count."""
        content = hashlib.sha256(f"{len(self.vertices)} {len(self.faces)}\n".encode())
        content.update(self.vertices.astype("<f8", copy=False).tobytes())
        content.update(self.faces.astype("<i8", copy=False).tobytes())
        return content.hexdigest()


def _frozen(values: ArrayLike, dtype: type, name: str, what: str) -> NDArray:  # type: ignore[type-arg]
    source = np.asarray(values)
    if source.ndim != 2 or source.shape[1] != 3:
        raise Wm3dError(f"{name}: {what} must be an (n, 3) array, got shape {source.shape}.")
    array = np.array(source, dtype=dtype, order="C")
    array.flags.writeable = False
    return array
