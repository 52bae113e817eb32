"""Analytic meshes for the tests: outward wound, closed, with known volume, area and moments."""

import numpy as np
import trimesh

from wm3d.arrays import FloatArray
from wm3d.mesh.mesh import Mesh


def tetrahedron() -> Mesh:
    """Right-angled corner of the unit cube: volume 1/6, centroid (1/4, 1/4, 1/4)."""
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    return Mesh(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], name="tetrahedron")


def box(extents: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Mesh:
    """Box centred on the origin: 8 vertices, 12 faces; vertex i has the signs of the bits of i (x, y, z)."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = [triangle for a, b, c, d in quads for triangle in ([a, b, c], [a, c, d])]
    return Mesh(corners * np.asarray(extents), faces, name="box")


def fine_box() -> Mesh:
    """Box of sides 3, 2 and 1 with 12,288 faces; still the same from 24 sides, but for a linear map."""
    coarse = box((3, 2, 1))
    vertices, faces = coarse.vertices, coarse.faces
    for _ in range(5):
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    return Mesh(vertices, faces, name="box")


def icosphere(subdivisions: int = 3, radius: float = 1.0) -> Mesh:
    """Sphere about the origin with 20 * 4**subdivisions faces; every vertex lies on the sphere."""
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return Mesh(sphere.vertices, sphere.faces, name="icosphere")


def uv_cylinder(radius: float = 1.0, height: float = 2.0, around: int = 64, along: int = 32) -> Mesh:
    """Capped cylinder about the z axis, centred on the origin: `along` + 1 rings of `around` vertices."""
    angle = 2 * np.pi * np.arange(around) / around
    ring = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    levels = np.linspace(-height / 2, height / 2, along + 1)
    side = np.column_stack([np.tile(ring, (along + 1, 1)), np.repeat(levels, around)])
    vertices = np.vstack([side, [[0, 0, -height / 2], [0, 0, height / 2]]])

    here, beside = np.arange(around), (np.arange(around) + 1) % around
    faces = []
    for level in range(along):
        low, high = level * around, (level + 1) * around
        faces.append(np.column_stack([low + here, low + beside, high + beside]))
        faces.append(np.column_stack([low + here, high + beside, high + here]))
    bottom, top, last = len(side), len(side) + 1, along * around
    faces.append(np.column_stack([np.full(around, bottom), beside, here]))
    faces.append(np.column_stack([np.full(around, top), last + here, last + beside]))
    return Mesh(vertices, np.vstack(faces), name="cylinder")


def blob(seed: int = 0, subdivisions: int = 5) -> Mesh:
    """Smooth star-shaped random surface for scheme tests, in a random pose.

    The semi-axes 1, 0.72 and 0.5 keep the principal axes apart, and a skew along the first two keeps their
    signs apart. `subdivisions` 5 gives 10242 vertices and 20480 faces, 6 gives 40962 and 81920.
    """
    rng = np.random.default_rng(seed)
    sphere = icosphere(subdivisions)
    direction = sphere.vertices
    relief = np.zeros(len(direction))
    for _ in range(12):
        wave, phase = rng.normal(size=3) * 2.0, rng.uniform(0, 2 * np.pi)
        relief += rng.uniform(0.01, 0.03) * np.cos(direction @ wave + phase)
    skew = 0.15 * direction[:, 0] + 0.14 * direction[:, 1]
    vertices = (1 + relief + skew)[:, None] * direction * [1.0, 0.72, 0.5]
    return Mesh(vertices @ rotation(seed).T, sphere.faces, name=f"blob-{seed}")


def rotation(seed: int) -> FloatArray:
    """Random rotation matrix (3, 3), determinant +1."""
    q, r = np.linalg.qr(np.random.default_rng([seed, 3]).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def together(*meshes: Mesh) -> Mesh:
    """Return meshes as the parts of one."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = [mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)]
    return Mesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces))


def inside_out(mesh: Mesh) -> Mesh:
    """Return the same surface with every face wound the other way."""
    return Mesh(mesh.vertices, mesh.faces[:, ::-1], name=mesh.name)


def lathe(heights: FloatArray, radii: FloatArray, around: int) -> Mesh:
    """Closed surface of revolution about the z axis, from pole to pole: both ends of `radii` are 0.

    Ring k has `around` vertices at the angles 2πj/around, at the height and radius k + 1 of the arguments.
    """
    angle = 2 * np.pi * np.arange(around) / around
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    rings = [np.column_stack([r * circle, np.full(around, z)]) for z, r in zip(heights, radii, strict=True)]
    vertices = np.vstack([rings[0][:1], *rings[1:-1], rings[-1][:1]])
    here, beside = np.arange(around), (np.arange(around) + 1) % around
    lowest, highest, top = 1 + here, len(vertices) - 1 - around + here, len(vertices) - 1
    faces = [np.column_stack([np.zeros(around, int), np.roll(lowest, -1), lowest])]
    for low in range(1, top - around, around):
        high = low + around
        faces.append(np.column_stack([low + here, low + beside, high + beside]))
        faces.append(np.column_stack([low + here, high + beside, high + here]))
    faces.append(np.column_stack([highest, np.roll(highest, -1), np.full(around, top)]))
    return Mesh(vertices, np.vstack(faces), name="lathe")


def soup(mesh: Mesh) -> Mesh:
    """The same surface as an STL file has it: three vertices of its own for every face."""
    return Mesh(
        mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(mesh.faces.size).reshape(-1, 3), mesh.name
    )
