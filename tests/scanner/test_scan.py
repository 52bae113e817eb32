"""The range image belongs to the shape: not to its place, size, vertex order, face order or winding."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import blob, inside_out, rotation

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.scanner import VertexPca, scan

SHAPE = blob(3, 4)


def relative_ranges(mesh: Mesh) -> np.ndarray:
    image = scan(mesh, (36, 40))
    return image.ranges / image.cylinder.radius


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    turn=st.integers(0, 2**32),
    log_scale=st.floats(-12, 12),
    shift=st.tuples(*[st.floats(-100, 100)] * 3),
)
def test_similar_meshes_have_the_same_relative_range_image(turn, log_scale, shift):
    moved = Mesh(10**log_scale * (SHAPE.vertices @ rotation(turn).T + shift), SHAPE.faces)
    np.testing.assert_allclose(relative_ranges(moved), relative_ranges(SHAPE), rtol=0, atol=1e-10)


def test_bunny_is_ranged_alike_in_another_position(bunny):
    moved = Mesh(3 * bunny.vertices @ rotation(1).T + [9, 8, 7], bunny.faces)
    here, there = relative_ranges(bunny), relative_ranges(moved)
    assert (np.isnan(here) == np.isnan(there)).all()
    np.testing.assert_allclose(here, there, rtol=0, atol=1e-10)


def test_order_of_vertices_and_faces_and_winding_do_not_matter():
    rng = np.random.default_rng(1)
    order = rng.permutation(len(SHAPE.vertices))
    place = np.argsort(order)
    shuffled = Mesh(SHAPE.vertices[order], place[rng.permutation(SHAPE.faces)])
    np.testing.assert_allclose(relative_ranges(shuffled), relative_ranges(SHAPE), rtol=0, atol=1e-12)
    reordered = Mesh(SHAPE.vertices, rng.permutation(SHAPE.faces))
    np.testing.assert_array_equal(relative_ranges(reordered), relative_ranges(SHAPE))
    np.testing.assert_allclose(relative_ranges(inside_out(SHAPE)), relative_ranges(SHAPE), rtol=0, atol=1e-14)


def test_unused_vertices_move_the_paper_pose_but_not_the_surface():
    stray = Mesh(np.vstack([SHAPE.vertices, [[2, 2, 2]] * 50]), SHAPE.faces)
    cylinder = VertexPca()(SHAPE)
    assert VertexPca()(stray).axis_deviation(cylinder) > 1
    np.testing.assert_array_equal(scan(stray, (36, 40), cylinder).ranges, scan(SHAPE, (36, 40)).ranges)


def test_mirrored_columns_belong_to_the_mirrored_shape():
    # columns run from s3 towards s2; a mirror image runs the other way under mirrored axes
    cylinder = VertexPca()(SHAPE)
    s1, s2, s3 = cylinder.axes
    mirror = np.eye(3) - 2 * np.outer(s2, s2)
    mirrored = Mesh((SHAPE.vertices - cylinder.center) @ mirror + cylinder.center, SHAPE.faces[:, ::-1])
    turned = dataclasses.replace(cylinder, axes=np.array([s1, s2, s3]))
    ranges = scan(SHAPE, (36, 40), cylinder).ranges
    np.testing.assert_allclose(
        scan(mirrored, (36, 40), turned).ranges, np.roll(ranges[:, ::-1], 1, axis=1), rtol=0, atol=1e-12
    )


@pytest.mark.parametrize(("u", "v"), [(0, 0), (7, 9), (20, 30), (39, 35)])
def test_ray_of_row_u_and_column_v_starts_where_the_paper_says(u, v):
    # a small triangle in front of q(u, v), wound both ways, changes this pixel and no other
    image = scan(SHAPE, (36, 40))
    assert image.grid == (36, 40)
    cylinder = image.cylinder
    s1, s2, s3 = cylinder.axes
    e_v = np.cos(2 * np.pi * v / 36) * s3 + np.sin(2 * np.pi * v / 36) * s2
    q = cylinder.center + (cylinder.hmin + (u + 0.5) * cylinder.height / 40) * s1 + cylinder.radius * e_v
    target = q - 0.01 * cylinder.radius * e_v
    up, across = 1e-3 * cylinder.radius * s1, 1e-3 * cylinder.radius * np.cross(s1, e_v)
    corners = [target + up, target - up + across, target - up - across]
    triangle = len(SHAPE.vertices) + np.array([[0, 1, 2], [2, 1, 0]])
    marked = Mesh(np.vstack([SHAPE.vertices, corners]), np.vstack([SHAPE.faces, triangle]))
    ranges = scan(marked, (36, 40), cylinder).ranges
    assert np.argwhere(ranges != image.ranges).tolist() == [[u, v]]
    assert ranges[u, v] == pytest.approx(0.01 * cylinder.radius, rel=1e-12)


@pytest.mark.parametrize("grid", [(0, 84), (84, 0), (84, 40000), (-1, 3)])
def test_empty_or_huge_grid_is_refused(grid):
    with pytest.raises(Wm3dError, match=f"a grid of {grid[0]}x{grid[1]} is not between 1x1 and 32768x32768"):
        scan(SHAPE, grid)
