"""Moving the vertices so that the scanner sees the marked range image (eqs. 9–12 of the paper)."""

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.mesh import Mesh, orientation, places
from wm3d.scanner import Cylinder
from wm3d.schemes import kernels


def radial_normals(mesh: Mesh, posed: FloatArray) -> FloatArray:
    """Return the normals of the vertices of a mesh, ``posed`` by a cylinder, along its s2 and s3: (n, 2).

    Outward, weighted by area; vertices in one place have one normal.
    """
    return pooled(posed, kernels.radial_normals(posed, mesh.faces, orientation(mesh)))


def move_vertices(
    mesh: Mesh, posed: FloatArray, normals: FloatArray, cylinder: Cylinder, change: FloatArray
) -> Mesh:
    """Return the mesh whose vertices follow a change of the range image.

    Parameters
    ----------
    mesh : Mesh
    posed : (n, 3) ndarray
        ``cylinder.posed(mesh)``.
    normals : (n, 2) ndarray
        From `radial_normals`.
    cylinder : Cylinder
    change : (N_u, N_v) ndarray
        Δl = l̃ − l (eq. 8), in mesh units; a positive change moves the surface towards the axis.
    """
    moves = kernels.radial_moves(posed, normals, change, cylinder.hmin, cylinder.height)
    return mesh.with_vertices(mesh.vertices + _to_world(moves, cylinder))


def radial_moves_reference(
    posed: FloatArray, normals: FloatArray, change: FloatArray, hmin: float, height: float
) -> FloatArray:
    """Plain numpy twin of `kernels.radial_moves`: eq. 12 term by term, all nine of them."""
    rows, columns = change.shape
    facing = np.where(np.einsum("ij,ij->i", normals, posed[:, 1:]) >= 0, 1.0, -1.0)
    angle = np.arctan2(facing * posed[:, 1], facing * posed[:, 2])
    u = (posed[:, 0] - hmin) / height * rows - 0.5
    v = angle / (2 * np.pi) * columns
    total = np.zeros(len(posed))
    for j in (-1, 0, 1):
        for k in (-1, 0, 1):
            ur, vr = np.rint(u).astype(int) + j, np.rint(v).astype(int) + k
            inside = (ur >= 0) & (ur < rows)
            delta = np.where(inside, change[ur.clip(0, rows - 1), vr % columns], 0.0)
            total += _weight(u - ur) * _weight(v - vr) * delta
    moves: FloatArray = -total[:, None] * np.column_stack([np.sin(angle), np.cos(angle)])
    return moves


def _weight(x: FloatArray) -> FloatArray:
    """f(x) = (1 + cos πx)/2 for |x| < 1, else 0 (eqs. 10 and 11)."""
    return np.where(np.abs(x) < 1, 0.5 * (1 + np.cos(np.pi * x)), 0.0)


def pooled(posed: FloatArray, normals: FloatArray) -> FloatArray:
    """Give vertices in one place one normal, the sum of theirs, so that seams and STL faces move together.

    Parameters
    ----------
    posed : (n, 3) ndarray
    normals : (n, k) ndarray
    """
    first, place = places(posed)
    if len(first) == len(posed):
        return normals
    total = [np.bincount(place, normals[:, k])[place] for k in range(normals.shape[1])]
    return np.column_stack(total)


def _to_world(moves: FloatArray, cylinder: Cylinder) -> FloatArray:
    """Components along s2, s3 to coordinates; written out because BLAS sums in an order of its own."""
    _, s2, s3 = cylinder.axes
    world: FloatArray = moves[:, :1] * s2 + moves[:, 1:] * s3
    return world
