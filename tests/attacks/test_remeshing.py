"""Remeshing: the surface stays where it was, the triangles do not."""

import numpy as np
import pytest
from scipy.spatial import KDTree
from shapes import box, icosphere, inside_out

from wm3d.attacks import IsotropicRemesh, MarchingCubes, ScreenedPoisson
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, is_balanced, is_closed, signed_volume

RNG = np.random.default_rng(0)
SPHERE = icosphere(4)
OPEN = Mesh(SPHERE.vertices, SPHERE.faces[:-40], name="cup")
SOUP = Mesh(SPHERE.vertices[SPHERE.faces].reshape(-1, 3), np.arange(SPHERE.faces.size).reshape(-1, 3), "soup")

BOX = box()
MORE = BOX.vertices[2:] + np.array([1.0, 1.0, 0.0])
TOUCHING = Mesh(  # two boxes: corners 6 and 7 of the first are 0 and 1 of the second
    np.vstack([BOX.vertices, MORE]), np.vstack([BOX.faces, BOX.faces + 6]), "touching"
)


@pytest.mark.parametrize("cells", [16, 40])
def test_marching_cubes_stay_within_a_cell_of_a_sphere(cells):
    result = MarchingCubes(cells=cells)(SPHERE, RNG)
    cell = SPHERE.diagonal / cells
    radius = np.linalg.norm(result.vertices, axis=1)
    # linear interpolation of a distance of curvature 1 errs by at most cell²/8 an edge, and chords likewise
    assert np.abs(radius - 1).max() < 0.5 * cell**2
    assert is_closed(result)
    assert signed_volume(result) == pytest.approx(4 / 3 * np.pi, rel=cell**2)
    edges = np.linalg.norm(np.diff(result.vertices[result.faces], axis=1), axis=2)
    assert edges.max() <= np.sqrt(3) * cell * (1 + 1e-6)


def test_marching_cubes_refuse_what_has_no_inside():
    with pytest.raises(Wm3dError, match=r"needs a closed surface.*close its holes, or use screened-poisson"):
        MarchingCubes()(OPEN, RNG)


def test_marching_cubes_take_an_unwelded_mesh():
    welded, unwelded = (MarchingCubes(cells=16)(mesh, RNG) for mesh in (SPHERE, SOUP))
    np.testing.assert_allclose(unwelded.vertices, welded.vertices)


def test_marching_cubes_take_two_boxes_that_share_an_edge():
    result = MarchingCubes(cells=96)(TOUCHING, RNG)
    assert is_balanced(TOUCHING)
    assert not is_closed(TOUCHING)
    assert signed_volume(result) == pytest.approx(2, rel=0.02)


@pytest.mark.parametrize("attack", [MarchingCubes(cells=32), ScreenedPoisson(depth=5), IsotropicRemesh()])
def test_a_mesh_wound_inwards_stays_so(attack):
    outward, inward = attack(SPHERE, RNG), attack(inside_out(SPHERE), RNG)
    assert signed_volume(inward) == pytest.approx(-signed_volume(outward), rel=1e-6)


def test_poisson_closes_a_hole():
    result = ScreenedPoisson(depth=6)(OPEN, RNG)
    assert is_closed(result)
    assert signed_volume(result) == pytest.approx(4 / 3 * np.pi, rel=0.03)
    assert np.median(np.abs(np.linalg.norm(result.vertices, axis=1) - 1)) < 2e-3


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_isotropic_edges_come_to_the_wanted_length(ratio):
    result = IsotropicRemesh(edge_ratio=ratio)(SPHERE, RNG)
    length, wanted = (
        np.linalg.norm(m.vertices[m.faces] - m.vertices[np.roll(m.faces, -1, axis=1)], axis=2)
        for m in (result, SPHERE)
    )
    assert length.mean() == pytest.approx(ratio * wanted.mean(), rel=0.15)
    assert is_closed(result)
    assert np.abs(np.linalg.norm(result.vertices, axis=1) - 1).max() < wanted.max() ** 2
    assert (KDTree(SPHERE.vertices).query(result.vertices)[0] > 1e-6).mean() > 0.3  # they moved along it


def test_a_mesh_of_few_normals_is_refused_by_poisson():
    with pytest.raises(Wm3dError, match=r"^box: screened-poisson 8 leaves no face; the mesh is too coarse"):
        ScreenedPoisson()(box(), RNG)
