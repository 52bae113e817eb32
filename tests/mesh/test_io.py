"""Mesh files: nothing reordered, merged or dropped; bad ones give one sentence; writing is all or nothing."""

import os
import stat

import numpy as np
import pytest
from shapes import box, icosphere, tetrahedron

from wm3d.errors import Wm3dError
from wm3d.mesh import ENDINGS, Mesh, load_mesh, save_mesh

EXACT = (".ply", ".obj", ".off")


@pytest.fixture
def awkward():
    """Shuffled faces, an unused and a doubled vertex, a degenerate face, 40 decades of coordinates."""
    rng = np.random.default_rng(5)
    sphere = icosphere(2)
    scale = 10.0 ** rng.uniform(-20, 20, size=sphere.vertices.shape)
    vertices = np.vstack([sphere.vertices * scale, [[1 / 3, -0.0, 5e-324]], sphere.vertices[:1]])
    faces = np.vstack([rng.permutation(sphere.faces), [[3, 3, 4]]])
    return Mesh(vertices, faces)


@pytest.mark.parametrize("ending", EXACT)
def test_round_trip_is_exact_in_every_bit(awkward, tmp_path, ending):
    file = tmp_path / f"mesh{ending}"
    save_mesh(awkward, file)
    assert load_mesh(file).digest() == awkward.digest()


def test_glb_keeps_order_and_rounds_to_float32(tmp_path):
    mesh = Mesh(np.vstack([icosphere(2).vertices / 3, [[0.1, 0.2, 0.3]]]), icosphere(2).faces[::-1])
    save_mesh(mesh, tmp_path / "mesh.glb")
    again = load_mesh(tmp_path / "mesh.glb")
    assert np.array_equal(again.faces, mesh.faces)
    assert np.array_equal(again.vertices, mesh.vertices.astype(np.float32))


def test_stl_gives_three_vertices_a_face(tmp_path):
    save_mesh(box((1, 2, 3)), tmp_path / "mesh.stl")
    soup = load_mesh(tmp_path / "mesh.stl")
    assert np.array_equal(soup.faces, np.arange(36).reshape(12, 3))
    assert np.array_equal(soup.vertices, box((1, 2, 3)).vertices[box().faces].reshape(36, 3))


@pytest.mark.parametrize("ending", ENDINGS)
def test_same_mesh_gives_same_bytes_whatever_its_name(tmp_path, ending):
    mesh = icosphere(1)
    save_mesh(mesh, tmp_path / f"a{ending}")
    save_mesh(Mesh(mesh.vertices, mesh.faces, name="other"), tmp_path / f"b{ending.upper()}")
    assert (tmp_path / f"a{ending}").read_bytes() == (tmp_path / f"b{ending.upper()}").read_bytes()


@pytest.mark.parametrize("ending", [".stl", ".glb"])
def test_float32_formats_refuse_what_they_would_spoil_and_ply_does_not(tmp_path, ending):
    georeferenced = np.array([4.5e5, 5.4e6, 100.0])
    mesh = tetrahedron().with_vertices(tetrahedron().vertices / 3 + georeferenced)
    with pytest.raises(Wm3dError, match=r"holds float32, which would move a vertex by 0\.1"):
        save_mesh(mesh, tmp_path / f"mesh{ending}")
    with pytest.raises(Wm3dError, match="holds float32, which would move a vertex by inf"):
        save_mesh(box((1e45, 1e45, 1e45)), tmp_path / f"mesh{ending}")
    save_mesh(mesh, tmp_path / "mesh.ply")
    assert [file.name for file in tmp_path.iterdir()] == ["mesh.ply"]
    assert load_mesh(tmp_path / "mesh.ply").digest() == mesh.digest()


def test_name_is_the_stem_unless_given(tmp_path):
    save_mesh(box(), tmp_path / "part.v2.ply")
    assert load_mesh(tmp_path / "part.v2.ply").name == "part.v2"
    assert load_mesh(tmp_path / "part.v2.ply", name="cube").name == "cube"


LETTER = b"Dear reader,\nthis is a letter.\n"
CLOUD = b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
OBJ = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
OFF = b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n"
NO_FACES = r"has no faces; wm3d needs a triangle mesh, not a point cloud\."
DAMAGED = "cannot be read as ...; it is damaged, cut short or of another format"

BAD_FILES = [
    ("a.ply", b"", r"is empty\."),
    *((f"a{ending}", LETTER, DAMAGED) for ending in ENDINGS),
    ("a.ply", CLOUD + b"end_header\n0 0 0\n1 0 0\n", NO_FACES),
    ("a.ply", CLOUD + b"end_header\n0 0 0\n1 2 x\n", DAMAGED),
    ("a.ply", CLOUD + b"end_header\n0 0 0\n", rf"{DAMAGED} \(it ends before its 2 rows of element vertex do"),
    ("a.obj", OBJ, NO_FACES),
    ("a.obj", OBJ + b"f 1 2\n", rf"{DAMAGED} \(line 5 has 2 entries"),
    ("a.obj", OBJ + b"f 0 1 2\n", rf"{DAMAGED} \(vertex index 0; OBJ counts from 1"),
    ("a.obj", OBJ + b"f 1 2 9\n", r"a face names vertex 8, but the vertices are 0 to 3\."),
    ("a.obj", OBJ + b"v 1 nan 2\nf 1 2 3\n", "vertex 4 has a coordinate that is NaN or infinite"),
    ("a.obj", OBJ + b"v 1 2 oops\nf 1 2 3\n", rf"{DAMAGED} \(could not convert string to float"),
    ("a.off", OFF + b"3 0 1 7\n", "a face names vertex 7, but the vertices are 0 to 2"),
    ("a.off", OFF + b"3 0 1\n", rf"{DAMAGED} \(a face of 3 corners lists 2"),
    ("a.off", OFF.replace(b"1 0\n0", b"0 0\n0", 1), NO_FACES),
    ("a.off", OFF.replace(b"0 1 0", b"0 inf 0") + b"3 0 1 2", "vertex 2 has a coordinate that is NaN"),
    ("a.step", b"ISO-10303-21", r"the ending '.step' is no mesh format wm3d knows; use one of \.ply, \.obj"),
    ("mesh", b"ply", "no ending, which is no mesh format"),
]


@pytest.mark.parametrize(("file", "content", "sentence"), BAD_FILES)
def test_bad_file_gives_one_sentence_that_starts_with_the_path_as_typed(
    tmp_path, monkeypatch, caplog, capfd, file, content, sentence
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / file).write_bytes(content)
    with pytest.raises(Wm3dError, match=f"^{file}: {sentence}") as refusal:
        load_mesh(file)
    assert str(refusal.value).count("\n") == 0
    assert not caplog.records
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("ending", [".ply", ".stl", ".glb", ".off"])
def test_file_cut_short_anywhere_is_never_taken_for_a_smaller_mesh(tmp_path, ending):
    whole, cut = tmp_path / f"whole{ending}", tmp_path / f"cut{ending}"
    save_mesh(icosphere(1), whole)
    content = whole.read_bytes().rstrip(b"\n") if ending == ".off" else whole.read_bytes()
    last_row = content.rfind(b" ") if ending == ".off" else len(content)  # a cut digit is another index
    for length in range(1, last_row, 37):
        cut.write_bytes(content[:length])
        with pytest.raises(Wm3dError, match=DAMAGED):
            load_mesh(cut)


def test_places_that_cannot_be_read_are_named(tmp_path):
    with pytest.raises(Wm3dError, match=r"nowhere\.ply: no such file"):
        load_mesh(tmp_path / "nowhere.ply")
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(Wm3dError, match=r"folder\.ply: is a folder"):
        load_mesh(tmp_path / "folder.ply")
    with pytest.raises(Wm3dError, match="cannot be read; File name too long"):
        load_mesh(tmp_path / ("x" * 300 + ".ply"))
    with pytest.raises(Wm3dError, match="cannot be read; embedded null byte"):
        load_mesh("a\0.ply")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read and write everything")
def test_missing_permission_is_named(tmp_path):
    save_mesh(box(), tmp_path / "mesh.ply")
    (tmp_path / "mesh.ply").chmod(0)
    with pytest.raises(Wm3dError, match=r"mesh\.ply: cannot be read; permission denied"):
        load_mesh(tmp_path / "mesh.ply")
    tmp_path.chmod(0o500)
    with pytest.raises(Wm3dError, match=r"new.ply: cannot be written \(Permission denied\)"):
        save_mesh(box(), tmp_path / "new.ply")
    tmp_path.chmod(0o700)


def test_places_that_cannot_be_written_are_named(tmp_path):
    with pytest.raises(Wm3dError, match=r"mesh.ply: the folder .*missing does not exist; create it first"):
        save_mesh(box(), tmp_path / "missing" / "mesh.ply")
    (tmp_path / "folder.ply").mkdir()
    with pytest.raises(Wm3dError, match=r"folder\.ply: is a folder; name a file"):
        save_mesh(box(), tmp_path / "folder.ply")
    with pytest.raises(Wm3dError, match=r"mesh.xyz: the ending '\.xyz' is no mesh format"):
        save_mesh(box(), tmp_path / "mesh.xyz")


def test_mesh_and_path_in_the_wrong_order_are_named(tmp_path):
    with pytest.raises(Wm3dError, match=r"the mesh is a str, not a wm3d\.Mesh; the order is mesh, path"):
        save_mesh(str(tmp_path / "a.ply"), tetrahedron())


@pytest.mark.parametrize("step", ["os.open", "pathlib.Path.replace"])
def test_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, step):
    save_mesh(box(), tmp_path / "mesh.ply")
    before = (tmp_path / "mesh.ply").read_bytes()

    def full(*_args, **_kwargs):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(step, full)
        with pytest.raises(Wm3dError, match=r"mesh.ply: cannot be written \(No space left on device\)"):
            save_mesh(icosphere(2), tmp_path / "mesh.ply")
    assert (tmp_path / "mesh.ply").read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["mesh.ply"]


@pytest.mark.skipif(os.name != "posix", reason="file modes and links of POSIX")
def test_written_file_has_the_usual_mode_and_links_stay_links(tmp_path):
    (tmp_path / "real.ply").touch(mode=0o600)
    (tmp_path / "link.ply").symlink_to("real.ply")
    umask = os.umask(0o022)
    try:
        save_mesh(box(), tmp_path / "link.ply")
    finally:
        os.umask(umask)
    assert (tmp_path / "link.ply").is_symlink()
    assert stat.S_IMODE((tmp_path / "real.ply").stat().st_mode) == 0o644
    assert load_mesh(tmp_path / "real.ply").digest() == box().digest()


@pytest.mark.parametrize("name", ["bunny-zipper", "cow"])
def test_real_meshes_survive_every_exact_format(data_mesh, tmp_path, name):
    mesh = data_mesh(name)
    for ending in EXACT:
        save_mesh(mesh, tmp_path / f"mesh{ending}")
        assert load_mesh(tmp_path / f"mesh{ending}").digest() == mesh.digest()
