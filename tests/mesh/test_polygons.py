"""Polygons as triangles: fans that do not fold, where there are any."""

import numpy as np
import pytest

from wm3d.mesh import load_mesh
from wm3d.mesh.polygons import triangulated

ELL = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]], float)  # an L of area 3
DART = np.array([[0, 0, 0], [2, 0, 0], [0.5, 0.5, 0], [0, 2, 0]], float)  # concave at its third corner
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
RIM = [(0, 0), (1, 1), (2, 0), (3, 1), (4, 0), (4, 3), (3, 2), (2, 3), (1, 2), (0, 3)]
COMB = np.array([(*point, 0) for point in RIM], float)  # no corner sees all others; of area 8
BOW = np.array([[0, 0, 0], [2, 2, 0], [2, 0, 0], [0, 1, 0]], float)  # crosses itself


def areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return np.cross(b - a, c - a)[:, 2] / 2


@pytest.mark.parametrize("first", range(6))
@pytest.mark.parametrize(("polygon", "area"), [(ELL, 3.0), (DART, 1.0)], ids=["L", "dart"])
def test_triangles_of_a_concave_polygon_do_not_fold_whichever_corner_comes_first(polygon, area, first):
    corners = np.roll(np.arange(len(polygon)), first)
    parts = areas(polygon, triangulated(polygon, corners, np.array([len(polygon)])))
    assert (parts > 0).all()
    assert parts.sum() == pytest.approx(area)


def test_a_corner_that_is_there_twice_hinders_nothing():
    corners = np.array([1, 2, 2, 3, 0])
    parts = areas(DART, triangulated(DART, corners, np.array([5])))
    assert sorted(parts) == pytest.approx([0, 0.5, 0.5])


def test_a_convex_polygon_is_split_from_its_first_corner_and_one_that_crosses_itself_too():
    for polygon in (SQUARE, BOW):
        faces = triangulated(polygon, np.arange(len(polygon)), np.array([len(polygon)]))
        assert faces.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize("turns", range(4))
def test_ears_are_cut_off_a_polygon_without_a_fan_however_it_lies(turns):
    tilted = np.column_stack([COMB[:, 0], COMB[:, 1], COMB[:, 0] + 2 * COMB[:, 1]])  # normal (-1, -2, 1)
    corners = np.arange(len(COMB))[:: (-1) ** turns]
    vertices = np.roll(tilted, turns, axis=1)
    faces = triangulated(vertices, corners, np.array([len(COMB)]))
    a, b, c = vertices[faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a) / 2
    expected = 8 * np.roll([-1, -2, 1], turns) * (-1) ** turns
    assert (normals @ expected > 0).all()
    assert normals.sum(axis=0) == pytest.approx(expected)


def test_polygons_of_all_sizes_keep_their_order():
    vertices = np.vstack([SQUARE, DART + 5])
    corners = np.array([5, 6, 7, 4, 0, 1, 2, 0, 1, 2, 3])
    faces = triangulated(vertices, corners, np.array([4, 3, 4]))
    assert faces.tolist() == [[6, 7, 4], [6, 4, 5], [0, 1, 2], [0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize("ending", ["obj", "off", "ply"])
def test_every_format_splits_alike(ending, tmp_path):
    file = tmp_path / f"ell.{ending}"
    points = [" ".join(map(str, point)) for point in ELL]
    order = [1, 2, 3, 4, 5, 0]
    text = {
        "obj": "\n".join([*(f"v {p}" for p in points), "f " + " ".join(str(k + 1) for k in order)]),
        "off": "\n".join(["OFF", "6 1 0", *points, "6 " + " ".join(map(str, order))]),
        "ply": "\n".join(
            [
                *("ply", "format ascii 1.0", "element vertex 6"),
                *(f"property double {axis}" for axis in "xyz"),
                *("element face 1", "property list uchar int vertex_indices", "end_header"),
                *points,
                "6 " + " ".join(map(str, order)),
            ]
        ),
    }[ending]
    file.write_text(text + "\n")
    mesh = load_mesh(file)
    assert (areas(mesh.vertices, mesh.faces) > 0).all()
