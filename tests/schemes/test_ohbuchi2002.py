"""The spectral scheme: its modes against a dense solver, registration, and the original that it needs."""

import json

import numpy as np
import pytest
from scipy.sparse.csgraph import laplacian
from shapes import blob, icosphere

from wm3d import detect, embed, load_mesh, save_mesh
from wm3d.attacks import Chain, Clean, Crop, Reorder, Similarity, Simplify, Subdivide, UniformNoise
from wm3d.cli import main
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.schemes import SCHEMES, Key
from wm3d.schemes.spectral import lowest_modes, modes, resampled

MESH = blob(0, 4)
SCHEME = SCHEMES.build("ohbuchi2002", {"modes": 40})


def dense_laplacian(mesh: Mesh) -> np.ndarray:
    adjacency = np.zeros((len(mesh.vertices), len(mesh.vertices)))
    for face in mesh.faces:
        for a, b in zip(face, np.roll(face, 1), strict=True):
            adjacency[a, b] = adjacency[b, a] = 1
    return laplacian(adjacency)


def test_modes_are_the_lowest_of_the_laplacian():
    small = blob(0, 3)
    found, k = lowest_modes(small, 20), dense_laplacian(small)
    values = np.linalg.eigvalsh(k)[1:21]
    np.testing.assert_allclose(found.T @ found, np.eye(20), atol=1e-9)
    np.testing.assert_allclose(k @ found, found * values, atol=1e-8)
    assert ((found**3).sum(axis=0) > 0).all()


def test_modes_of_a_large_mesh_are_right_to_a_per_cent(monkeypatch):
    exact = lowest_modes(MESH, 20)
    monkeypatch.setattr(modes, "EXACT", 100)
    near = lowest_modes(MESH.with_vertices(MESH.vertices), 20)  # not the cached one
    k = dense_laplacian(MESH)
    energy, expected = ((m * (k @ m)).sum(axis=0) for m in (near, exact))
    np.testing.assert_allclose(near.T @ near, np.eye(20), atol=1e-8)
    np.testing.assert_allclose(energy, expected, rtol=0.01)
    assert (np.linalg.norm(exact.T @ near, axis=0) > 0.99).all()


def test_components_and_unused_vertices_carry_nothing():
    n = len(MESH.vertices)
    two = Mesh(
        np.vstack([MESH.vertices, [[9, 9, 9]], icosphere(2).vertices + 3]),
        np.vstack([MESH.faces, icosphere(2).faces + n + 1]),
    )
    found = lowest_modes(two, 12)
    assert (found[n] == 0).all()
    # orthogonal to the constants over either component
    np.testing.assert_allclose(found[:n].sum(axis=0), 0, atol=1e-7)
    np.testing.assert_allclose(found[n:].sum(axis=0), 0, atol=1e-7)


def test_embedding_changes_each_coefficient_by_its_sign():
    marked, _ = SCHEME.embed(MESH, 3)
    moves = marked.vertices - MESH.vertices
    spectrum = lowest_modes(MESH, 40).T @ moves
    step = 0.05 / 100 * MESH.diagonal * np.sqrt(len(moves) / 40)
    np.testing.assert_allclose(spectrum.ravel(), step * SCHEME.signs(3), rtol=1e-6)
    assert np.sqrt((moves**2).mean()) == pytest.approx(0.05 / 100 * MESH.diagonal, rel=1e-6)


def test_registration_undoes_a_similarity_whatever_the_order_of_the_vertices():
    rng = np.random.default_rng(2)
    same = Similarity()(MESH, rng)
    np.testing.assert_allclose(resampled(MESH, same), MESH.vertices, atol=1e-9)
    moved = Reorder()(same, rng)
    np.testing.assert_allclose(resampled(MESH, moved), MESH.vertices, atol=1e-4)


def test_vertices_that_no_face_has_are_neither_here_nor_there():
    speck = [[9.0, 9.0, 9.0]]
    dotted = Mesh(np.vstack([MESH.vertices, speck]), MESH.faces, "dotted")
    np.testing.assert_allclose(resampled(MESH, dotted), MESH.vertices, atol=1e-9)
    np.testing.assert_allclose(resampled(dotted, MESH), dotted.vertices, atol=1e-9)


def test_suspect_without_area_is_refused():
    line = Mesh(MESH.vertices * [1, 0, 0], MESH.faces[::-1], "line")
    with pytest.raises(Wm3dError, match=r"^line: its faces have no area, so it cannot be laid"):
        resampled(MESH, line)


@pytest.mark.parametrize(
    ("attack", "least"),
    [
        (Clean(), 10.5),  # of √120 = 10.95
        (UniformNoise(percent=0.5), 10),
        (Chain(then=(Similarity(), Reorder())), 6),
        (Chain(then=(Simplify(ratio=0.5), Similarity())), 6),
        (Subdivide(), 6),
        (Crop(percent=10), 4),
    ],
    ids=lambda value: getattr(value, "label", lambda: "")(),
)
def test_mark_is_found_after(attack, least):
    marked, scheme = SCHEME.embed(MESH, 1)
    attacked = attack(marked, np.random.default_rng(0))
    assert scheme.score(attacked, 1).z > least
    assert abs(scheme.score(attacked, 2).z) < 5  # 6e-7


def test_python_takes_the_original_with_a_key_from_a_file(tmp_path):
    marked, key = embed(MESH, seed=7, scheme="ohbuchi2002", modes=20)
    key.save(tmp_path / "key.json")
    loaded = Key.load(tmp_path / "key.json")
    assert json.loads((tmp_path / "key.json").read_text())["scheme"]["original"] == MESH.digest()
    assert detect(marked, key).z == detect(marked, loaded, original=MESH).z
    with pytest.raises(Wm3dError, match=r"^blob-0: ohbuchi2002 is not blind and needs the original mesh"):
        detect(marked, loaded)


def test_command_line_takes_the_original(tmp_path, capsys):
    original, target, key = (str(tmp_path / name) for name in ("mesh.ply", "marked.ply", "key.json"))
    save_mesh(MESH, original)
    assert main(["embed", original, target, "--key", key, "--scheme", "ohbuchi2002", "modes=20"]) == 0
    assert main(["detect", target, "--key", key, "--original", original]) == 0
    assert main(["detect", original, "--key", key, "--original", original]) == 1
    capsys.readouterr()
    assert main(["detect", target, "--key", key]) == 2
    assert "needs the original mesh (--original FILE" in capsys.readouterr().err
    assert main(["detect", target, "--key", key, "--original", target]) == 2
    assert "is not the mesh that was marked" in capsys.readouterr().err
    assert load_mesh(original).digest() != load_mesh(target).digest()


def test_mesh_with_too_few_vertices_is_refused():
    with pytest.raises(Wm3dError, match=r"^blob-0: has 42 vertices, too few for 40 spectral modes; use at"):
        SCHEME.embed(blob(0, 1), 1)
