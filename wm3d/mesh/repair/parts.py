"""Parts of a mesh, as objects beside each other: how they are wound, and each alone."""

from typing import NamedTuple, Self

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh.kernels import face_areas
from wm3d.mesh.mesh import Mesh
from wm3d.mesh.places import places
from wm3d.mesh.repair.kernels import face_parts, part_volumes

SPLINTER = 0.01
"""Share of the volume of the largest part, open or not, below which a part stays: no moment feels it."""

LEAST_FACES, LEAST_AREA, MOST_PARTS = 500, 1e-6, 8
"""Which parts `large_parts` returns: of so many faces, and of so much of the surface."""


def part_turns(vertices: FloatArray, faces: IntArray) -> IntArray:
    """Return 1 for faces that stay as they are, −1 for those of parts that must be turned over: (m,).

    The volumes of parts wound against each other, as a file put together of several may hold, would cancel.
    A part that lies in a larger one is a hollow of it or a solid in it, as it was wound, and is turned over
    with it. Open parts stay.

    Parameters
    ----------
    vertices : (n, 3) ndarray
        In different places.
    faces : (m, 3) ndarray of int
    """
    part, parts = face_parts(len(vertices), faces)
    turns = np.ones(parts, dtype=np.int64)
    if parts > 1:
        volume, closed = part_volumes(vertices, faces, part, parts)
        size = np.abs(volume)
        order = np.argsort(-size, kind="stable")
        large = order[closed[order] & (size[order] > SPLINTER * size.max())]
        if np.unique(np.sign(volume[large])).size > 1:
            solids = [_Solid.of(vertices[faces[part == k]]) for k in large]
            for i, one in enumerate(solids):
                around = [k for k, other in zip(large[:i], solids, strict=False) if other.holds(one)]
                turns[large[i]] = (
                    turns[around[-1]] if around else np.sign(volume[large[i]] * volume[large[0]])
                )
    turned: IntArray = turns[part]
    return turned


class Part(NamedTuple):
    """What hangs together of a mesh of several parts, over its vertices, and whether that is closed."""

    mesh: Mesh
    closed: bool


def large_parts(mesh: Mesh) -> list[Part]:
    """Return the parts of a mesh, those of most faces first; none if it is one part.

    Up to `MOST_PARTS` of at least `LEAST_FACES`, for fewer faces carry no mark, and `LEAST_AREA`.
    """
    if face_parts(len(mesh.vertices), mesh.faces)[1] == 1:
        return []
    first, place = places(mesh.vertices)
    corners = place[mesh.faces]
    part, parts = face_parts(len(first), corners)
    if parts == 1:
        return []
    _, closed = part_volumes(mesh.vertices[first], corners, part, parts)
    faces = np.bincount(part)
    area = np.bincount(part, face_areas(mesh.vertices, mesh.faces))
    large = np.flatnonzero((faces >= LEAST_FACES) & (area > LEAST_AREA * area.sum()))
    return [
        Part(Mesh(mesh.vertices, mesh.faces[part == k], mesh.name), bool(closed[k]))
        for k in large[np.argsort(-faces[large], kind="stable")][:MOST_PARTS]
    ]


class _Solid(NamedTuple):
    """Triangles (m, 3, 3) that bound a solid, and the ends (2, 3) of their bounding box."""

    corners: FloatArray
    box: FloatArray

    @classmethod
    def of(cls, corners: FloatArray) -> Self:
        return cls(corners, np.array([corners.min(axis=(0, 1)), corners.max(axis=(0, 1))]))

    def holds(self, other: "_Solid") -> bool:
        """Tell whether another solid, which does not cross this one, lies in it."""
        (low, high), (least, most) = self.box, other.box
        return bool((low <= least).all() and (most <= high).all()) and _is_inside(
            other.corners[0, 0], self.corners
        )


def _is_inside(point: FloatArray, corners: FloatArray) -> bool:
    """Tell whether a point (3,) lies in the solid that triangles (m, 3, 3) bound, however they are wound.

    By the sum of the solid angles that they span (van Oosterom and Strackee 1983), ±4π inside and 0 outside.
    """
    a, b, c = (corners - point).transpose(1, 0, 2)
    length_a, length_b, length_c = (np.linalg.norm(side, axis=1) for side in (a, b, c))
    volume = np.einsum("fi,fi->f", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("fi,fi->f", one, other) for one, other in ((a, b), (b, c), (c, a)))
    angles = np.arctan2(
        volume, length_a * length_b * length_c + ab * length_c + bc * length_a + ca * length_b
    )
    return bool(abs(2 * angles.sum()) > 2 * np.pi)
