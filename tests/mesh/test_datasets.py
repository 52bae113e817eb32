"""Named meshes: where a name leads, what wins, what needs no network, and what an unknown name gives."""

import subprocess
import sys

import pytest
from shapes import box, icosphere, tetrahedron

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, datasets, is_closed, orientation, save_mesh
from wm3d.mesh.catalog import DATASETS, STANFORD, Dataset
from wm3d.mesh.recipes import Recipe
from wm3d.mesh.sources import Download

pytestmark = pytest.mark.usefixtures("cache")


@pytest.fixture
def data(cache, tmp_path, monkeypatch):  # noqa: ARG001 (the cache unsets WM3D_DATA first)
    """Folder of WM3D_DATA."""
    folder = tmp_path / "data"
    folder.mkdir()
    monkeypatch.setenv("WM3D_DATA", str(folder))
    return folder


def test_bundled_bunny_is_a_closed_outward_mesh_with_its_name(bunny):
    assert bunny.name == "bunny"
    assert (len(bunny.vertices), len(bunny.faces)) == (DATASETS["bunny"].vertices, DATASETS["bunny"].faces)
    assert is_closed(bunny)
    assert orientation(bunny) == 1


def test_bunny_is_found_without_importing_pymeshlab():
    code = "import sys, wm3d.mesh; wm3d.mesh.datasets.load('bunny'); print('pymeshlab' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "False\n"


def test_any_mesh_file_of_the_data_folder_answers_to_its_stem(data):
    save_mesh(tetrahedron(), data / "Part-7.off")
    (data / "notes.txt").write_text("not a mesh")
    (data / "folder.ply").mkdir()
    assert datasets.load("Part-7").digest() == tetrahedron().digest()
    assert datasets.load("Part-7").name == "Part-7"
    assert sorted(datasets.dataset_names()) == sorted([*DATASETS, "Part-7"])


def test_a_name_or_path_is_located_where_it_is_read(data, tmp_path):
    save_mesh(tetrahedron(), data / "part.off")
    assert datasets.locate("part") == data / "part.off"
    assert datasets.locate(tmp_path / "not-yet.ply") == tmp_path / "not-yet.ply"
    with pytest.raises(Wm3dError, match="unknown mesh 'prat'"):
        datasets.locate("prat")


def test_data_folder_wins_over_the_registry_and_ply_over_other_endings(data):
    save_mesh(box(), data / "bunny.obj")
    assert datasets.path("bunny") == datasets.fetch("bunny") == data / "bunny.obj"
    save_mesh(tetrahedron(), data / "bunny.ply")
    assert datasets.load("bunny").digest() == tetrahedron().digest()


def test_missing_data_folder_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("WM3D_DATA", str(tmp_path / "away"))
    with pytest.raises(Wm3dError, match=r"^WM3D_DATA: .*away is not a folder; correct or unset"):
        datasets.load("bunny")


def test_path_uses_no_network_and_says_how_to_get_the_file(cache):
    for use in (datasets.path, datasets.load):
        with pytest.raises(Wm3dError, match="not on this machine; run `wm3d data fetch dragon`, or put"):
            use("dragon")
    with pytest.raises(Wm3dError, match="run `wm3d data fetch happy-buddha-300k`"):
        datasets.path("happy-buddha-300k")
    assert not cache.exists()


def test_fetched_dataset_stays_at_hand(cache, server, tmp_path, monkeypatch):
    save_mesh(box(), tmp_path / "box.off")
    url = server.serve("/box.off", (tmp_path / "box.off").read_bytes())
    monkeypatch.setitem(DATASETS, "box", Dataset(Download(url)))
    assert not datasets.describe("box").available
    fetched = datasets.fetch("box")
    assert fetched.parent == cache
    assert datasets.path("box") == fetched
    assert datasets.load("box").digest() == box().digest()
    assert datasets.describe("box").available
    assert server.requests == ["/box.off"]


def doubled(mesh: Mesh) -> Mesh:
    return mesh.with_vertices(mesh.vertices * 2)


def test_recipe_fetches_its_best_base_unless_another_is_at_hand(server, tmp_path, monkeypatch):
    save_mesh(box(), tmp_path / "fine.off")
    url = server.serve("/fine.off", (tmp_path / "fine.off").read_bytes())
    recipe = Recipe(("fine", "coarse"), doubled, "doubled", ())
    monkeypatch.setitem(DATASETS, "fine", Dataset(Download(url)))
    monkeypatch.setitem(DATASETS, "double", Dataset(recipe))
    assert datasets.describe("double").source == "fine, doubled"

    monkeypatch.setenv("WM3D_DATA", str(tmp_path / "data"))
    (tmp_path / "data").mkdir()
    save_mesh(tetrahedron(), tmp_path / "data" / "coarse.ply")
    assert datasets.describe("double").source == "coarse, doubled"
    assert (
        datasets.load("double").digest() == tetrahedron().with_vertices(tetrahedron().vertices * 2).digest()
    )
    assert server.requests == []

    monkeypatch.delenv("WM3D_DATA")
    datasets.fetch("double")
    assert server.requests == ["/fine.off"]
    assert datasets.load("double").digest() == box((2, 2, 2)).digest()
    assert datasets.load("double").name == "double"


def test_resolve_takes_a_name_or_a_path(data, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    save_mesh(box(), data / "part.ply")
    save_mesh(tetrahedron(), tmp_path / "part.ply")
    assert datasets.resolve("part").digest() == box().digest()
    assert datasets.resolve("part.ply").digest() == tetrahedron().digest()
    assert datasets.resolve(tmp_path / "part.ply").name == "part"
    with pytest.raises(Wm3dError, match=r"^missing/part: no ending, which is no mesh format"):
        datasets.resolve("missing/part")
    with pytest.raises(Wm3dError, match=r"^missing\.obj: no such file"):
        datasets.resolve("missing.obj")


@pytest.mark.parametrize("use", ["resolve", "load", "path", "fetch", "describe"])
def test_unknown_name_suggests_the_nearest(data, use):
    save_mesh(box(), data / "bunny-closed.ply")
    with pytest.raises(Wm3dError, match=r"^unknown mesh 'bunny-close': .*; did you mean 'bunny-closed'"):
        getattr(datasets, use)("bunny-close")
    with pytest.raises(Wm3dError, match=r"^unknown mesh 'xyz': .*; known: armadillo, bunny, bunny-closed, "):
        getattr(datasets, use)("xyz")


def test_a_name_with_the_ending_of_a_file_is_answered_with_who_reads_files():
    with pytest.raises(Wm3dError, match=r"^x\.ply: names a file, .*; wm3d\.load_mesh reads files\.$"):
        datasets.load("x.ply")


def test_scans_are_credited_also_when_they_come_from_the_data_folder():
    for name in ("bunny", "bunny-closed", "happy-buddha-50k", "happy-buddha-300k", "dragon", "armadillo"):
        assert datasets.credit(name) == STANFORD
    assert datasets.credit("rabbit") != STANFORD
    assert datasets.credit("bunnyhop") is None
    assert datasets.credit("part") is None


def test_info_lists_every_name_with_size_and_availability(data):
    save_mesh(icosphere(1), data / "ball.stl")
    lines = {line.name: line for line in datasets.info()}
    assert list(lines) == datasets.dataset_names()
    assert lines["ball"].source == str(data / "ball.stl")
    assert lines["ball"].available
    assert lines["bunny"].source == "the pymeshlab package"
    assert (lines["bunny"].vertices, lines["bunny"].faces, lines["bunny"].available) == (28088, 56172, True)
    assert (lines["dragon"].vertices, lines["dragon"].faces, lines["dragon"].available) == (
        437645,
        871414,
        False,
    )
    assert "good taste" in lines["happy-buddha"].terms


def test_registry_is_coherent():
    for name, entry in DATASETS.items():
        if isinstance(entry.source, Recipe):
            assert set(entry.source.bases) & set(DATASETS), name
        elif isinstance(entry.source, Download):
            assert entry.source.sha256 or entry.source.git_blob, name
            assert entry.source.url.startswith("https://"), name
        else:
            assert entry.source.find() is not None, name
