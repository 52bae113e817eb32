"""Files and welding: what each format keeps, and which vertices merge."""

import numpy as np
import pytest
from shapes import blob, box, icosphere

from wm3d.attacks import Draco, Reorder, RoundTrip, Weld
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, is_closed, load_mesh, save_mesh, surface_area

RNG = np.random.default_rng(0)
MESH = blob(1, 3)


@pytest.mark.parametrize("ending", ["ply", "obj", "stl", "off", "glb"])
def test_round_trip_is_that_through_a_file(ending, tmp_path):
    save_mesh(MESH, tmp_path / f"mesh.{ending}")
    assert RoundTrip(format=ending)(MESH, RNG).digest() == load_mesh(tmp_path / f"mesh.{ending}").digest()


def test_stl_comes_apart_and_welding_puts_it_together():
    apart = RoundTrip(format="stl")(MESH, RNG)
    assert len(apart.vertices) == 3 * len(MESH.faces)
    assert not is_closed(apart)
    whole = RoundTrip(format="stl", weld=True)(MESH, RNG)
    assert is_closed(whole)
    assert len(whole.vertices) == len(MESH.vertices)
    assert whole.digest() == Weld()(apart, RNG).digest()


def test_a_mesh_too_far_out_for_float32_is_refused():
    far = Mesh(MESH.vertices + 1e6, MESH.faces, name="far")
    with pytest.raises(Wm3dError, match=r"^far\.stl: cannot be written; STL holds float32"):
        RoundTrip(format="stl")(far, RNG)


def test_weld_merges_what_chains_of_short_steps_connect():
    x = [0.0, 0.004, 0.008, 0.5, 1.0]
    strip = Mesh([[v, k % 2, 0] for k, v in enumerate(x)] + [[v, k % 2 + 1e-3, 0] for k, v in enumerate(x)],
                 [[0, 1, 2], [2, 3, 4], [5, 6, 7], [7, 8, 9], [0, 3, 7]])  # fmt: skip
    result = Weld(percent=100 * 0.009 / strip.diagonal)(strip, RNG)
    # 0, 2, 5 and 7 become 0; 1 and 6; 3 and 8; 4 and 9
    np.testing.assert_array_equal(result.vertices, strip.vertices[[0, 3, 4]])
    np.testing.assert_array_equal(result.faces, [[0, 1, 2], [0, 1, 2]])


def test_weld_that_leaves_nothing_is_refused():
    flat = Mesh([[0, 0, 0], [1e-6, 0, 0], [1, 1, 1]], [[0, 1, 2]], name="flat")
    with pytest.raises(Wm3dError, match=r"^flat: welding at .* leaves no face"):
        Weld(percent=0.1)(flat, RNG)


def test_draco_refuses_a_mesh_that_its_encoder_does():
    pytest.importorskip("DracoPy")
    speck = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 1, 1]], name="speck")
    with pytest.raises(Wm3dError, match=r"^speck: draco 14 cannot encode it; see that a face has an area"):
        Draco()(speck, RNG)


def test_draco_keeps_the_surface():
    pytest.importorskip("DracoPy")
    sphere = icosphere(4)
    result = Draco(bits=14)(sphere, RNG)
    assert is_closed(result)
    assert surface_area(result) == pytest.approx(surface_area(sphere), rel=1e-4)
    assert not np.array_equal(result.faces, sphere.faces)  # it orders them anew


def test_reorder_keeps_every_face_where_it_is():
    result = Reorder()(box(), np.random.default_rng(1))

    def corners(mesh):  # fmt: skip
        return sorted(tuple(map(tuple, mesh.vertices[face])) for face in mesh.faces)

    assert corners(result) == corners(box())
    assert not np.array_equal(result.vertices, box().vertices)
    assert not np.array_equal(result.vertices[result.faces], box().vertices[box().faces])
