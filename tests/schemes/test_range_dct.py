"""The robust scheme: its steps by a second route, and what leaves its reading alone."""

import json

import numpy as np
import pytest
from plain import plain_z
from scipy.spatial import KDTree
from scipy.stats import kstest
from shapes import blob, box, inside_out, rotation, soup, together

from wm3d.attacks import (
    Attack,
    Bend,
    Chain,
    Crop,
    GaussianNoise,
    HalfSpaceCrop,
    MarchingCubes,
    Mirror,
    Pedestal,
    Reorder,
    Shear,
    Similarity,
    Simplify,
    Stretch,
    Twist,
)
from wm3d.imagemarks.blocks import inverse_block_dct
from wm3d.imagemarks.fine_signs import LAYERS
from wm3d.imagemarks.shaped_dct import ShapedDct
from wm3d.mesh import Mesh, solid_moments, vertex_normals
from wm3d.metrics import snr
from wm3d.scanner.affine import principal_frame
from wm3d.scanner.denoise import CRUMPLED, whitened_area
from wm3d.scanner.registration import Landmarks
from wm3d.scanner.scan import MAX_GRID
from wm3d.scanner.volume import volume_image
from wm3d.schemes import SCHEMES, Key, Song2002
from wm3d.schemes.informed import pattern_moves
from wm3d.schemes.movement import _weight
from wm3d.schemes.volume_host import AXIS, Layout, host_of, laid
from wm3d.stats import key_signs, key_signs_batch

SCHEME = SCHEMES.build("range-dct", {})
MESH = blob(0, 5)
SMALL = blob(0, 4)


def test_clean_mark_is_found(embedded, evidence):
    assert evidence.score(embedded[1].signs(1)).z > 40


def rms(vectors):
    return np.sqrt((vectors**2).sum(axis=1).mean())


def test_pattern_moves_vertices_along_their_normals_by_its_value_there():
    host = host_of(MESH, None)
    posed, layout = principal_frame(MESH).posed(MESH), host.layout
    columns, rows = layout.grid
    image = volume_image(posed, MESH.faces, layout.grid, layout.hmin, layout.height, 1)
    mark = ShapedDct.of(image.volumes, image.areas)
    signs = key_signs(1, mark.amplitude.size)
    pattern = inverse_block_dct(mark.pattern(signs), (rows, columns))

    u = (posed[:, 0] - layout.hmin) / layout.height * rows - 0.5
    v = np.arctan2(posed[:, 1], posed[:, 2]) / (2 * np.pi) * columns
    along = np.zeros(len(posed))
    for j in (-1, 0, 1):
        for k in (-1, 0, 1):
            row, column = np.rint(u).astype(int) + j, np.rint(v).astype(int) + k
            inside = (row >= 0) & (row < rows)
            cell = pattern[row.clip(0, rows - 1), column % columns]
            along += np.where(inside, _weight(u - row) * _weight(v - column) * cell, 0)
    distance = np.hypot(posed[:, 1], posed[:, 2])
    along *= np.minimum(1, distance / (AXIS * np.median(distance)))
    moves = along[:, None] * vertex_normals(MESH)
    moves *= 0.01 / rms(moves)
    np.testing.assert_allclose(host.moves(pattern_moves(host, signs, 0.01)), moves, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("extents", "grid"), [((1, 1e-5, 1e-5), (8, 2400)), ((1e-5, 1, 1), (2400, 8))])
def test_a_rod_and_a_disc_are_laid_no_more_blocks_than_any_solid(extents, grid):
    solid = box(extents)
    assert Layout.around(solid.vertices, solid, 300).grid == grid
    assert max(Layout.around(solid.vertices, solid, 10_000).grid) == MAX_GRID


def test_vertices_move_along_their_normals(embedded):
    moves = embedded[0].vertices - MESH.vertices
    normals = vertex_normals(MESH)
    along = (moves * normals).sum(axis=1, keepdims=True)
    np.testing.assert_allclose(moves, along * normals, rtol=0, atol=1e-12)


def test_what_comes_back_of_the_mark_is_less_than_what_went_in(embedded):
    strength = rms(embedded[0].vertices - MESH.vertices) * np.linalg.norm(principal_frame(MESH).matrix[0])
    assert 0.1 * strength < embedded[1].reference.strength < strength  # cells average it


def test_reference_is_that_of_the_marked_mesh(embedded):
    marked, scheme = embedded
    reference, frame = scheme.reference, principal_frame(MESH)
    columns, rows = reference.grid
    assert columns % 8 == rows % 8 == 0
    assert 70 < rows * columns / 64 < 130
    assert scheme.capacity == (1 + LAYERS) * (rows // 8) * (columns // 8) * 63
    posed = frame.posed(MESH)
    assert (reference.hmin, reference.height) == (posed[:, 0].min(), np.ptp(posed[:, 0]))
    found = solid_moments(marked)
    np.testing.assert_array_equal(reference.moments, found.mapped(frame.matrix).entries())
    np.testing.assert_allclose(reference.offset, frame.matrix @ (found.centroid - frame.centroid), atol=1e-14)
    assert reference.area == whitened_area(marked)
    landmarks = Landmarks.decode(reference.landmarks)
    assert len(landmarks.points) > 400
    distance, _ = KDTree(frame.posed(marked)).query(landmarks.points)
    assert distance.max() < 0.05  # about the edges of the mesh
    home = np.reshape(reference.home[:9], (3, 3)) @ marked.vertices.T
    np.testing.assert_allclose(home.T + reference.home[9:], frame.posed(marked), atol=1e-12)


def test_cells_are_no_finer_than_the_mesh():
    # 2562 vertices are 1.5 a cell for some 27 blocks; an unwelded copy has no more places than it had
    stray = Mesh(np.vstack([SMALL.vertices, 0.5 * blob(1, 5).vertices]), SMALL.faces)  # points of no face
    for mesh in (SMALL, soup(SMALL), stray):
        columns, rows = SCHEME.embed(mesh, 3)[1].reference.grid
        assert len(SMALL.vertices) > 1.2 * rows * columns
    columns, rows = SCHEMES.build("range-dct", {"blocks": 9}).embed(SMALL, 3)[1].reference.grid
    assert rows * columns / 64 == pytest.approx(9, abs=3)


@pytest.mark.parametrize(
    ("asked", "vertices", "blocks"),
    [
        (None, 25_000, 100),
        (None, 100_000, 0.63 * 100_000**0.5),
        (None, 10**7, 300),
        (None, 4_800, 50),  # 1.5 vertices for each of 64 cells
        (25, 10**6, 25),
        (5_000, 96_000, 1_000),
    ],
)
def test_fine_meshes_carry_more_blocks_unless_a_number_is_asked_for(asked, vertices, blocks):
    assert laid(asked, vertices) == blocks


@pytest.mark.parametrize("alpha", [0.1, 0.63, 2.0])
def test_alpha_is_percent_of_the_size_so_that_the_snr_follows(alpha):
    marked, _ = SCHEMES.build("range-dct", {"alpha": alpha, "blocks": 20}).embed(SMALL, 3)
    moved = rms(marked.vertices - SMALL.vertices)
    assert moved / rms(SMALL.vertices - SMALL.vertices.mean(axis=0)) == pytest.approx(alpha / 100, rel=1e-9)
    # eq. 13 leaves out the mean of the moves, a millionth of them here and there
    assert snr(SMALL, marked) == pytest.approx(40 - 20 * np.log10(alpha), abs=1e-3)


def test_a_vertex_that_no_face_uses_changes_neither_mark_nor_snr():
    stray = Mesh(np.vstack([SMALL.vertices, [[1000.0, 0, 0]]]), SMALL.faces)
    marked, _ = SCHEME.embed(SMALL, 3)
    beside, _ = SCHEME.embed(stray, 3)
    np.testing.assert_allclose(beside.vertices[:-1], marked.vertices, rtol=0, atol=1e-9)
    assert snr(stray, beside) == pytest.approx(snr(SMALL, marked), abs=1e-6)


@pytest.mark.parametrize(
    "attack",
    [
        Similarity(min_scale=0.1, max_scale=10),
        Stretch(percent=10),
        Stretch(percent=-40, axis="x"),
        Shear(percent=20),
        Shear(percent=-80, axis="y"),
        Chain(then=(Stretch(percent=60), Shear(percent=30), Similarity())),
        Reorder(),
    ],
    ids=lambda attack: attack.label(),
)
def test_reading_is_the_same_after_every_linear_map_and_in_every_order(attack, embedded, evidence):
    marked, scheme = embedded
    there, signs = scheme.evidence(attack(marked, np.random.default_rng(1))), scheme.signs(1)
    assert there.score(signs).z == pytest.approx(evidence.score(signs).z, rel=1e-6)
    np.testing.assert_allclose(there.b, evidence.b, atol=1e-6 * evidence.b.std())


@pytest.mark.parametrize(
    ("attack", "kept"),
    [
        (Bend(degrees=10), 0.9),
        (Twist(degrees=10), 0.9),
        (Chain(then=(Stretch(percent=20), Bend(degrees=15), Similarity())), 0.9),
        (Chain(then=(Mirror(), GaussianNoise(percent=0.3), Similarity())), 0.7),
        (Crop(percent=10), 0.7),
        (Crop(percent=30), 0.6),
        (Chain(then=(Crop(percent=30), Similarity())), 0.6),
        (Chain(then=(Mirror(), Crop(percent=40), Similarity())), 0.5),
        (Chain(then=(Crop(percent=10), Pedestal(percent=40), Similarity())), 0.6),
        (Chain(then=(Pedestal(percent=40), MarchingCubes(cells=128), Similarity())), 0.35),  # one part
        (Chain(then=(Pedestal(percent=150), MarchingCubes(cells=128), Similarity())), 0.2),
        (HalfSpaceCrop(percent=20), 0.6),
    ],
    ids=lambda value: value.label() if isinstance(value, Attack) else "",
)
def test_mark_is_found_where_the_moments_mislead(attack, kept, embedded):
    marked, scheme = embedded
    z = plain_z(scheme, attack(marked, np.random.default_rng(2)), 1)
    assert z > kept * plain_z(scheme, marked, 1)


@pytest.mark.parametrize(
    "added",
    [
        Pedestal(percent=40),
        lambda mesh, _: beside_a_larger(mesh),
        lambda mesh, _: together(beside_a_larger(mesh), on_a_line(blob(4, 3))),  # of no area: not looked at
    ],
)
def test_among_added_parts_the_marked_one_is_read_alone_and_all_count_as_tries(added, embedded, evidence):
    marked, scheme = embedded
    rng = np.random.default_rng(3)
    there, signs = scheme.evidence(Similarity()(added(marked, rng), rng)), scheme.signs(1)
    assert there.score(signs).z == pytest.approx(evidence.score(signs).z, rel=1e-6)
    assert there.tries == (2 if isinstance(added, Pedestal) else 3)  # a box is too simple to be looked at


def beside_a_larger(mesh: Mesh) -> Mesh:
    other = blob(3, 5)
    return together(mesh, other.with_vertices(1.7 * other.vertices + [4, 1, 0]))


def on_a_line(mesh: Mesh) -> Mesh:
    return mesh.with_vertices(mesh.vertices * [1, 0, 0])


def test_an_original_of_several_parts_is_read_as_a_whole():
    other = blob(3, 4)
    pair = together(SMALL, other.with_vertices(0.5 * other.vertices + [2.2, 0, 0]))
    marked, scheme = SCHEME.embed(pair, 1)
    for attack, tries in ((GaussianNoise(percent=0.1), 1), (Bend(degrees=10), 3)):  # the whole and each part
        attacked = Chain(then=(attack, Similarity()))(marked, np.random.default_rng(0))
        there = scheme.evidence(attacked)
        assert there.tries == tries
        assert there.score(scheme.signs(1)).z > 0.5 * scheme.score(marked, 1).z


def test_a_smooth_model_that_lost_a_part_and_was_turned_is_searched_for():
    # seven tenths of its landmarks are met in the wrong place, to which the moments lead
    smooth = blob(1, 5)
    marked, scheme = SCHEME.embed(smooth, 1)
    part = Crop(percent=10)(marked, np.random.default_rng(0))
    turned = Similarity()(part, np.random.default_rng(0))
    assert plain_z(scheme, turned, 1) > 0.7 * plain_z(scheme, marked, 1)


def test_winding_does_not_matter(embedded, evidence):
    marked, scheme = embedded
    turned = scheme.evidence(inside_out(marked))
    np.testing.assert_allclose(turned.b, evidence.b, atol=1e-6 * evidence.b.std())
    inward, other = SCHEME.embed(inside_out(MESH), 1)
    np.testing.assert_allclose(inward.vertices, marked.vertices, rtol=0, atol=1e-9)
    np.testing.assert_allclose(other.reference.moments, scheme.reference.moments, atol=1e-9)


def test_wrong_keys_are_standard_normal(embedded, evidence):
    keys = key_signs_batch(range(1000, 3000), embedded[1].capacity)
    z = keys @ evidence.b / evidence.scale
    # five standard errors each, and no heavier upper tail than the normal one: 1e-6 false alarm each
    assert abs(z.mean()) < 5 / np.sqrt(len(z))
    assert abs(z.var() - 1) < 5 * np.sqrt(2 / len(z))
    assert kstest(z, "norm", alternative="less").pvalue > 1e-6


def test_key_file_brings_back_every_digit(embedded, tmp_path):
    marked, scheme = embedded
    Key(scheme, 1).save(tmp_path / "key.json")
    key = Key.load(tmp_path / "key.json")
    assert key == Key(scheme, 1)
    assert key.scheme.reference == scheme.reference
    assert key.score(marked).z == scheme.score(marked, 1).z
    content = json.loads((tmp_path / "key.json").read_text())["scheme"]
    assert len(content["reference"]["moments"]) == 31


def test_label_does_not_hold_what_differs_from_mesh_to_mesh(embedded):
    assert embedded[1].label() == SCHEME.label() == "range-dct"
    assert SCHEMES.build("range-dct", {"blocks": 20}).label() == "range-dct blocks=20"


def test_simplified_and_noisy_mesh_is_read_where_the_scheme_of_the_paper_sees_nothing(bunny):
    attack = Chain(then=(Simplify(ratio=0.5), GaussianNoise(percent=0.3)))
    marked, scheme = SCHEME.embed(bunny, 1)
    paper = Song2002().at_snr(bunny, 1, snr(bunny, marked))
    of_paper, _ = paper.embed(bunny, 1)
    assert snr(bunny, of_paper) == pytest.approx(snr(bunny, marked), abs=1e-5)
    assert paper.score(of_paper, 1).log10_p < -100
    attacked = [attack(mesh, np.random.default_rng(1)) for mesh in (marked, of_paper)]
    assert scheme.score(attacked[0], 1).log10_p < -300
    # simplification turns the axes of the vertices by degrees, and the key is read in the wrong place
    assert paper.score(attacked[1], 1).log10_p > -6


def test_crumpled_mesh_is_smoothed_before_it_is_read(embedded):
    marked, scheme = embedded
    noisy = GaussianNoise(percent=1.5)(marked, np.random.default_rng(2))
    assert whitened_area(noisy) > CRUMPLED * scheme.reference.area
    # with a larger area for reference nothing is smoothed
    as_it_is = scheme.model_copy(update={"reference": scheme.reference.model_copy(update={"area": 1e9})})
    assert scheme.score(noisy, 1).z > 1.2 * as_it_is.score(noisy, 1).z
    assert scheme.score(noisy, 1).detected(1e-15)


def test_faces_of_an_stl_file_are_marked_without_tearing(embedded, evidence):
    marked, scheme = SCHEME.embed(soup(MESH), 1)
    _, place = np.unique(soup(MESH).vertices, axis=0, return_inverse=True)
    _, moved = np.unique(marked.vertices, axis=0, return_inverse=True)
    np.testing.assert_array_equal(moved, moved[np.unique(place, return_index=True)[1]][place])
    assert len(np.unique(moved)) == len(MESH.vertices)
    assert scheme.score(marked, 1).z > 40
    # and the welded mesh is read from the faces of such a file as from its own
    there = embedded[1].evidence(soup(embedded[0]))
    np.testing.assert_allclose(there.b, evidence.b, atol=1e-6 * evidence.b.std())


def test_vertices_that_no_face_uses_stay_and_do_not_matter(embedded, evidence):
    marked, scheme = embedded
    loose = np.array([[0.1, 0.2, 0.3], [9, 5, 3], [-9, -5, -3]])
    there = scheme.evidence(Mesh(np.vstack([marked.vertices, loose]), marked.faces))
    np.testing.assert_allclose(there.b, evidence.b, atol=1e-6 * evidence.b.std())

    result, other = SCHEME.embed(Mesh(np.vstack([SMALL.vertices, loose]), SMALL.faces), 1)
    np.testing.assert_array_equal(result.vertices[-3:], loose)
    assert (result.vertices[:-3] != SMALL.vertices).any(axis=1).mean() > 0.99
    without = Mesh(result.vertices[:-3], result.faces)
    assert other.score(without, 1).z == pytest.approx(other.score(result, 1).z, rel=1e-6)


def open_mesh() -> Mesh:
    """A blob with a round hole in its side, of 3 % of its faces."""
    towards = MESH.vertices[MESH.faces].mean(axis=1) @ rotation(0)[:, 1]
    return Mesh(MESH.vertices, MESH.faces[np.argsort(towards)[: -len(MESH.faces) // 33]], "open blob")


def test_open_mesh_is_marked_and_read():
    mesh = open_mesh()
    marked, scheme = SCHEME.embed(mesh, 4)
    assert scheme.score(marked, 4).z > 30
    assert abs(scheme.score(marked, 5).z) < 5  # 6e-7 false alarm
    moved = Similarity()(Shear(percent=20)(marked, np.random.default_rng(0)), np.random.default_rng(0))
    assert scheme.score(moved, 4).z == pytest.approx(scheme.score(marked, 4).z, rel=1e-6)
