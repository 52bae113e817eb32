"""Downloads: checked, whole or not kept at all, with one sentence for each way to fail."""

import gzip
import hashlib
import io
import sys
import tarfile

import pooch
import pytest

from wm3d.errors import Wm3dError
from wm3d.mesh.sources import Bundled, Download

MESH = b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n" * 500
BLOB = hashlib.sha1(f"blob {len(MESH)}\0".encode() + MESH).hexdigest()  # as `git hash-object` prints it


def sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def tar_gz(**members: bytes) -> bytes:
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w:gz") as archive:
        for name, content in members.items():
            entry = tarfile.TarInfo(name)
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content))
    return packed.getvalue()


@pytest.fixture
def plain(server) -> Download:
    return Download(server.serve("/mesh.off", MESH), sha256=sha256(MESH))


def test_plain_file_is_kept_and_not_asked_for_twice(plain, server, cache):
    file = plain.fetch("thing", cache)
    assert file.read_bytes() == MESH
    assert file.suffix == ".off"
    assert plain.fetch("thing", cache) == file
    assert server.requests == ["/mesh.off"]
    assert list(cache.iterdir()) == [file]


def test_gz_is_unpacked(server, cache):
    packed = gzip.compress(MESH)
    file = Download(server.serve("/Mesh.OFF.gz", packed), sha256(packed)).fetch("thing", cache)
    assert (file.read_bytes(), file.suffix) == (MESH, ".off")


def test_only_the_named_member_leaves_the_archive(server, cache):
    packed = tar_gz(**{"../outside": b"x", "/abs": b"x", "a/mesh.ply": MESH, "a/other.ply": b"x"})
    source = Download(server.serve("/a.tar.gz", packed), sha256(packed), "a/mesh.ply", sha256(MESH))
    file = source.fetch("thing", cache)
    assert (file.read_bytes(), file.suffix) == (MESH, ".ply")
    assert list(cache.parent.rglob("*")) == [cache, file]


def test_archive_labelled_as_encoded_content_is_stored_as_sent(server, cache):
    # some servers label .tar.gz so, and clients that undo the encoding break its hash
    packed = tar_gz(mesh=MESH)
    url = server.serve("/a.tar.gz", packed, Content_Encoding="gzip")
    assert Download(url, sha256(packed), "mesh").fetch("thing", cache).read_bytes() == MESH


def test_git_blob_id_is_checked(server, cache):
    url = server.serve("/mesh.off", MESH)
    assert Download(url, git_blob=BLOB).fetch("thing", cache).read_bytes() == MESH
    with pytest.raises(Wm3dError, match=f"git blob id {BLOB}, expected 0000; not kept"):
        Download(url, git_blob="0000").fetch("other", cache)
    assert len(list(cache.iterdir())) == 1


def test_new_expected_hash_is_another_file(plain, server, cache):
    old = plain.fetch("thing", cache)
    new = MESH + b"# edited\n"
    changed = Download(server.serve("/mesh.off", new), sha256(new)).fetch("thing", cache)
    assert (old.read_bytes(), changed.read_bytes()) == (MESH, new)


def failures(server):
    """Download that must fail, and what its sentence says."""
    packed, url = tar_gz(mesh=MESH), server.serve("/a.tar.gz", tar_gz(mesh=MESH))
    letter = server.serve("/letter.tar.gz", b"Dear reader")
    return {
        "other bytes": (Download(url, "0" * 64, "mesh"), "do not have the sha256 0000"),
        "other mesh": (Download(url, sha256(packed), "mesh", "0" * 64), f"sha256 {sha256(MESH)}, expected 0"),
        "no member": (Download(url, sha256(packed), "nothing"), "cannot be unpacked to nothing"),
        "no archive": (Download(letter, member="mesh"), "cannot be unpacked to mesh"),
        "no gzip": (Download(letter), "cannot be unpacked to one file"),
        "absent": (Download(f"{server.address}/gone.ply"), "the server answers 404; try again later"),
        "nobody there": (
            Download("http://127.0.0.1:9/a.ply"),
            "the server cannot be reached; try again later",
        ),
    }


@pytest.mark.parametrize(
    "case", ["other bytes", "other mesh", "no member", "no archive", "no gzip", "absent", "nobody there"]
)
def test_failed_download_gives_one_sentence_and_keeps_nothing(server, cache, caplog, capfd, case):
    source, sentence = failures(server)[case]
    with pytest.raises(Wm3dError, match=f"^{source.url}: .*{sentence}") as refusal:
        source.fetch("thing", cache)
    assert str(refusal.value).count("\n") == 0
    assert list(cache.iterdir()) == []
    assert not caplog.records
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("sent", [0, 1, len(MESH) // 2, len(MESH) - 1])
def test_transfer_that_breaks_off_keeps_nothing_and_can_be_repeated(plain, server, cache, sent):
    server.cut["/mesh.off"] = sent
    with pytest.raises(Wm3dError, match="the transfer broke off; try again later, or put the mesh into"):
        plain.fetch("thing", cache)
    assert list(cache.iterdir()) == []
    del server.cut["/mesh.off"]
    assert plain.fetch("thing", cache).read_bytes() == MESH


def test_cache_that_cannot_be_made_is_named(plain, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(Wm3dError, match=r"file: cannot keep thing \(File exists\); set WM3D_CACHE"):
        plain.fetch("thing", tmp_path / "file")


def test_log_level_of_pooch_is_given_back(plain, cache):
    before = pooch.get_logger().level
    plain.fetch("thing", cache)
    assert pooch.get_logger().level == before


def test_bundled_file_is_found_without_an_import_and_checked(tmp_path, monkeypatch):
    (tmp_path / "carrier").mkdir()
    (tmp_path / "carrier" / "__init__.py").write_text("raise ImportError('must not be imported')")
    (tmp_path / "carrier" / "mesh.off").write_bytes(MESH)
    monkeypatch.syspath_prepend(tmp_path)
    assert Bundled("carrier", "mesh.off", sha256(MESH)).path().read_bytes() == MESH
    with pytest.raises(Wm3dError, match=f"mesh.off: has sha256 {sha256(MESH)}, expected 0000"):
        Bundled("carrier", "mesh.off", "0000").path()
    with pytest.raises(Wm3dError, match=r"^carrier/gone\.off: not found; install the carrier wheel, or put"):
        Bundled("carrier", "gone.off", "0000").path()
    with pytest.raises(Wm3dError, match=r"^nosuchpackage/gone\.off: not found"):
        Bundled("nosuchpackage", "gone.off", "0000").path()
    assert "carrier" not in sys.modules
