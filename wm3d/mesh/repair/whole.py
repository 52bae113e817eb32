"""The whole surface: a broken mesh as its surface is meant."""

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh.mesh import Mesh
from wm3d.mesh.moments import is_balanced
from wm3d.mesh.places import places
from wm3d.mesh.repair.flaps import flap_turns
from wm3d.mesh.repair.holes import caps
from wm3d.mesh.repair.parts import part_turns
from wm3d.mesh.repair.repeats import first_of_each, is_doubled
from wm3d.mesh.repair.sides import Sides
from wm3d.mesh.repair.winding import winding_turns


def whole_surface(mesh: Mesh) -> Mesh:
    """Return the surface that a mesh stands for, over the same vertices; the same object if nothing is amiss.

    An integral over a surface, as that of a volume, takes every face for a part of the boundary of one solid.
    So faces that lie on others count once, each part that hangs together is wound alike, flaps are taken off,
    small holes covered, and closed parts that lie apart wound as the largest. What a viewer sees hardly
    changes. Vertices in one place count as one, so the faces of an unwelded mesh hang together. The rim of a
    large hole stays.
    """
    doubled = is_doubled(mesh)
    if is_balanced(mesh) and not doubled:
        return _with_faces(mesh, _parts_alike(mesh.faces, mesh.vertices, mesh.faces))
    faces = mesh.faces[first_of_each(mesh)] if doubled else mesh.faces
    first, place = places(mesh.vertices)
    sides = Sides.of(place[faces])
    if sides.at_variance:
        faces, sides = _turned(faces, sides, winding_turns(sides, _cones(mesh, faces)))
    faces, sides = _turned(faces, sides, flap_turns(sides))
    covers = caps(place[faces], sides, mesh.vertices[first])
    if len(covers):
        faces = np.vstack([faces, first[covers]])
    return _with_faces(mesh, _parts_alike(faces, mesh.vertices[first], place[faces]))


def _with_faces(mesh: Mesh, faces: IntArray) -> Mesh:
    return mesh if faces is mesh.faces else Mesh(mesh.vertices, faces, mesh.name)


def _parts_alike(faces: IntArray, vertices: FloatArray, corners: IntArray) -> IntArray:
    """Turn over the faces of parts wound against others; `corners` (m, 3) are theirs among the vertices."""
    turned = part_turns(vertices, corners) < 0
    return np.where(turned[:, None], faces[:, ::-1], faces) if turned.any() else faces


def _turned(faces: IntArray, sides: Sides, turns: IntArray) -> tuple[IntArray, Sides]:
    """Leave out the faces where ``turns`` (m,) is 0, turn over those where it is −1."""
    if (turns == 1).all():
        return faces, sides
    return np.where((turns < 0)[:, None], faces[:, ::-1], faces)[turns != 0], sides.turned(turns)


def _cones(mesh: Mesh, faces: IntArray) -> FloatArray:
    """Return signed volumes of the tetrahedra from the middle to the faces, in some unit."""
    a, b, c = ((mesh.vertices - mesh.middle) / mesh.diagonal)[faces.T]
    cones: FloatArray = np.einsum("fi,fi->f", a, np.cross(b, c))
    return cones
