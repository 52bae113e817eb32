"""Recipes: the face count asked for, and a cache that knows its base and its engines."""

import numpy as np
import pytest
from shapes import box, icosphere

from wm3d.errors import Wm3dError
from wm3d.mesh import datasets, load_mesh, save_mesh, signed_volume, vertex_moments
from wm3d.mesh.recipes import Recipe, with_faces


@pytest.mark.parametrize("count", [500, 1280, 2000, 12000])  # base: 1280 faces
def test_with_faces_gives_the_count_from_finer_and_coarser_bases(count):
    ball = with_faces(icosphere(3), count)
    assert len(ball.faces) == count
    assert np.unique(ball.faces).tolist() == list(range(len(ball.vertices)))
    # quadric error keeps the surface; midpoints of edges lie on it
    assert signed_volume(ball) == pytest.approx(signed_volume(icosphere(3)), rel=0.01)
    assert len(with_faces(icosphere(3), 501).faces) == 500


@pytest.fixture
def base(tmp_path):
    save_mesh(box(), tmp_path / "base.ply")
    return tmp_path / "base.ply"


class Doubling:
    """A step that counts its calls."""

    calls = 0

    def __call__(self, mesh):
        self.calls += 1
        return mesh.with_vertices(mesh.vertices * 2)


def test_result_is_computed_once_for_each_base_edition_and_engine(base, cache, monkeypatch):
    make = Doubling()
    recipe = Recipe(("base",), make, "doubled", ("numpy",))
    first = recipe.cook("double", base, cache)
    assert load_mesh(first).digest() == box((2, 2, 2)).digest()
    assert recipe.cook("double", base, cache) == first
    assert make.calls == 1

    second = Recipe(("base",), make, "doubled", ("numpy",), edition=2).cook("double", base, cache)
    with monkeypatch.context() as patch:
        patch.setattr("wm3d.mesh.recipes.version", lambda _engine: "99")
        third = recipe.cook("double", base, cache)
    save_mesh(box((3, 3, 3)), base)
    fourth = recipe.cook("double", base, cache)
    assert len({first, second, third, fourth}) == make.calls == 4
    assert load_mesh(fourth).digest() == box((6, 6, 6)).digest()


def test_failed_step_leaves_no_file(base, cache):
    def fail(_mesh):
        raise Wm3dError("part: no.")

    with pytest.raises(Wm3dError, match=r"part: no\."):
        Recipe(("base",), fail, "nothing", ()).cook("nothing", base, cache)
    assert list(cache.iterdir()) == []


@pytest.mark.usefixtures("cache")
def test_buddha_at_the_size_of_the_paper(data_mesh, monkeypatch, tmp_path):
    stand_in = data_mesh("happy-buddha-50k")
    save_mesh(stand_in, tmp_path / "happy-buddha-50k.ply")
    monkeypatch.setenv("WM3D_DATA", str(tmp_path))
    buddha = datasets.load("happy-buddha-300k")
    assert len(buddha.faces) == 300_074
    assert buddha.name == "happy-buddha-300k"
    assert datasets.describe("happy-buddha-300k").source.startswith("happy-buddha-50k, ")
    assert signed_volume(buddha) == pytest.approx(signed_volume(stand_in), rel=1e-3)
    assert vertex_moments(buddha).mean == pytest.approx(
        vertex_moments(stand_in).mean, abs=0.02 * buddha.diagonal
    )
