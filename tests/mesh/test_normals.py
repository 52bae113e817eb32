"""Vertex normals: of a cylinder, for either winding, of a vertex without a face."""

import numpy as np
from shapes import inside_out, uv_cylinder

from wm3d.mesh import Mesh, vertex_normals


def test_normals_of_a_cylinder_point_away_from_its_axis_for_either_winding() -> None:
    mesh = uv_cylinder(around=64, along=16)
    side = (np.abs(mesh.vertices[:, 2]) < 0.9) & (np.hypot(*mesh.vertices.T[:2]) > 0.5)
    wanted = mesh.vertices[side] * [1, 1, 0]
    np.testing.assert_allclose(vertex_normals(mesh)[side], wanted, atol=1e-12)
    np.testing.assert_allclose(vertex_normals(inside_out(mesh))[side], wanted, atol=1e-12)


def test_a_vertex_without_a_face_has_no_normal() -> None:
    mesh = uv_cylinder(around=8, along=2)
    lone = Mesh(np.vstack([mesh.vertices, [[5, 5, 5]]]), mesh.faces)
    assert (vertex_normals(lone)[-1] == 0).all()
