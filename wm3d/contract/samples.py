"""Meshes to check components on: a good one, the same one spoilt, and some that few schemes can mark."""

import numpy as np
import trimesh

from wm3d.mesh import Mesh


def potato(subdivisions: int) -> Mesh:
    """Return a smooth closed surface without symmetry, of 20 · 4^subdivisions faces, wound outward."""
    ball = trimesh.creation.icosphere(subdivisions=subdivisions)
    x, y, z = ball.vertices.T
    relief = 0.03 * np.cos(5 * x + 2 * y) + 0.03 * np.sin(4 * y - 3 * z) + 0.02 * np.cos(3 * x - 7 * z + 1)
    radius = 1 + relief + 0.15 * x + 0.14 * y
    return Mesh(radius[:, None] * ball.vertices * [1.0, 0.72, 0.5], ball.faces, "potato")


def opened(mesh: Mesh) -> Mesh:
    """Return the mesh without the faces of one side, and without the vertices that these leave behind."""
    corners = mesh.vertices[mesh.faces].mean(axis=1)
    faces = mesh.faces[corners[:, 1] < np.quantile(corners[:, 1], 0.9)]
    kept, faces = np.unique(faces, return_inverse=True)
    return Mesh(mesh.vertices[kept], faces.reshape(-1, 3), f"open {mesh.name}")


def inside_out(mesh: Mesh) -> Mesh:
    """Return the mesh with every face wound the other way."""
    return Mesh(mesh.vertices, mesh.faces[:, ::-1], f"inward-wound {mesh.name}")


def box() -> Mesh:
    """Return a box of twelve faces."""
    cuboid = trimesh.creation.box(extents=(3.0, 2.0, 1.0))
    return Mesh(cuboid.vertices, cuboid.faces, "box")


def sphere() -> Mesh:
    """Return a sphere, which has no pose."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    return Mesh(ball.vertices, ball.faces, "sphere")


def sheet() -> Mesh:
    """Return a flat open grid of 9 × 9 vertices."""
    side = 9
    x, y = np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float) ** 1.1)
    low = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    faces = np.vstack(
        [np.column_stack([low, low + 1, low + side + 1]), np.column_stack([low, low + side + 1, low + side])]
    )
    return Mesh(np.column_stack([x.ravel(), y.ravel(), np.zeros(side**2)]), faces, "sheet")
