"""The paper's scheme: each step by a plain second route, what it promises, and what it refuses."""

import numpy as np
import pytest
from scipy.fft import dct
from scipy.stats import kstest
from shapes import blob, box, icosphere, inside_out

from wm3d.attacks import Similarity
from wm3d.errors import Wm3dError
from wm3d.imagemarks import GgdLrt, Linear
from wm3d.mesh import Mesh, orientation
from wm3d.metrics import snr
from wm3d.scanner import Cylinder, VertexPca, scan
from wm3d.scanner.reference import cast_reference
from wm3d.schemes import SCHEMES, Song2002, kernels
from wm3d.schemes.movement import radial_moves_reference

MESH = blob(0, 5)
SMALL = Song2002(grid=(24, 28), region=(2, 8, 24, 16), alpha=2.0)


def open_mesh() -> Mesh:
    """A blob with a third of one side cut away, so that rays miss."""
    posed = VertexPca()(MESH).posed(MESH)
    corners = posed[MESH.faces].mean(axis=1)
    return Mesh(MESH.vertices, MESH.faces[(corners[:, 1] < 0.2) | (np.abs(corners[:, 0]) > 0.3)], "open blob")


def by_hand(mesh: Mesh, scheme: Song2002) -> tuple[Cylinder, np.ndarray, np.ndarray, float]:
    """Cylinder, ranges with the far wall, grey levels of the region, mesh units of a grey level."""
    cylinder = VertexPca()(mesh)
    columns, rows = scheme.grid
    posed = (mesh.vertices - cylinder.center) @ cylinder.axes.T
    planes = cylinder.hmin + (np.arange(rows) + 0.5) * cylinder.height / rows
    ranges = cast_reference(posed, mesh.faces, planes, columns, cylinder.radius, orientation(mesh))
    ranges = np.where(np.isnan(ranges), 2 * cylinder.radius, ranges)
    top, left, height, width = scheme.region
    region = ranges[top : top + height, left : left + width]
    unit = np.ptp(region) / 255
    return cylinder, ranges, (region - region.min()) / unit, unit


def tiles(image: np.ndarray) -> list[tuple[slice, slice]]:
    rows, columns = image.shape
    return [np.s_[i : i + 8, j : j + 8] for i in range(0, rows, 8) for j in range(0, columns, 8)]


DCT = dct(np.eye(8), axis=0, norm="ortho")


def test_embedding_is_section_3a_of_the_paper_step_by_step():
    mesh, seed = open_mesh(), 5
    cylinder, ranges, grey, unit = by_hand(mesh, SMALL)
    signs = SMALL.signs(seed).reshape(-1, 63)
    marked = np.empty_like(grey)
    for tile, w in zip(tiles(grey), signs, strict=True):
        coefficients = (DCT @ grey[tile] @ DCT.T).ravel()
        coefficients[1:] += 2.0 * w
        marked[tile] = DCT.T @ coefficients.reshape(8, 8) @ DCT
    change = np.zeros_like(ranges)
    top, left, height, width = SMALL.region
    change[top : top + height, left : left + width] = (marked - grey) * unit
    posed = (mesh.vertices - cylinder.center) @ cylinder.axes.T
    normals = kernels.radial_normals(posed, mesh.faces, 1)
    moves = radial_moves_reference(posed, normals, change, cylinder.hmin, cylinder.height)
    expected = mesh.vertices + moves @ cylinder.axes[1:]

    result, scheme = SMALL.embed(mesh, seed)
    np.testing.assert_allclose(result.vertices, expected, rtol=0, atol=1e-12)
    assert (result.vertices != mesh.vertices).any()
    assert result.faces is mesh.faces
    assert scheme == SMALL


def test_detection_is_section_3b_of_the_paper_step_by_step():
    mesh = open_mesh()
    _, _, grey, _ = by_hand(mesh, SMALL)
    received = np.array([(DCT @ grey[tile] @ DCT.T).ravel()[1:] for tile in tiles(grey)])
    expected = GgdLrt().evidence(received, SMALL.alpha)
    evidence = SMALL.evidence(mesh)
    np.testing.assert_allclose(evidence.b, expected.b, rtol=1e-6)
    assert evidence.offset == pytest.approx(expected.offset, rel=1e-6)


def test_mark_is_found_with_its_key_and_wrong_keys_follow_the_null(bunny):
    scheme = Song2002()
    marked, _ = scheme.embed(bunny, 1)
    assert scheme.score(marked, 1).z > 30
    evidence = scheme.evidence(marked)
    wrong = [evidence.score(scheme.signs(seed)) for seed in range(1000, 2000)]
    z = np.array([score.z for score in wrong])
    # five standard errors each, and the p-values uniform at a false-alarm rate of 1e-6
    assert abs(z.mean()) < 5 / np.sqrt(1000)
    assert abs(z.var() - 1) < 5 * np.sqrt(2 / 1000)
    assert kstest([score.p_value for score in wrong], "uniform").pvalue > 1e-6
    # an unmarked model, the right key: 6e-7 false alarm
    assert abs(scheme.score(bunny, 1).z) < 5


def test_embedding_is_deterministic_and_signs_of_other_seeds_differ():
    unseen = Mesh(MESH.vertices, MESH.faces)
    first, again, other = (SMALL.embed(mesh, seed)[0] for mesh, seed in ((MESH, 3), (unseen, 3), (MESH, 4)))
    assert first.digest() == again.digest()
    assert first.digest() != other.digest()
    assert SMALL.capacity == 6 * 63
    assert SMALL.signs(3).size == SMALL.capacity


def test_snr_falls_by_twenty_decibels_a_decade_of_alpha():
    weak, strong = (snr(MESH, SMALL.model_copy(update={"alpha": a}).embed(MESH, 1)[0]) for a in (0.2, 2.0))
    assert weak - strong == pytest.approx(20, abs=1e-9)


def test_identity_holds_the_version_of_the_detector(monkeypatch):
    before = Song2002().identity()
    monkeypatch.setattr(type(Song2002().detector), "version", 99)
    assert Song2002().identity() != before


@pytest.mark.parametrize("decibels", [43.98, 20.0, 120.0])
def test_strength_is_set_from_a_wanted_snr(decibels):
    scheme = SMALL.at_snr(MESH, 7, decibels)
    assert snr(MESH, scheme.embed(MESH, 7)[0]) == pytest.approx(decibels, abs=1e-6)
    assert scheme == SMALL.model_copy(update={"alpha": scheme.alpha})


@pytest.mark.parametrize("decibels", [np.nan, np.inf, -np.inf, 400.0, 1e300])
def test_impossible_snr_is_refused(decibels):
    with pytest.raises(Wm3dError, match=r"cannot be set to an SNR of|rescale"):
        SMALL.at_snr(MESH, 7, decibels)


def test_z_survives_every_similarity_transform(bunny):
    scheme, rng = Song2002(), np.random.default_rng(4)
    marked, _ = scheme.embed(bunny, 2)
    expected = scheme.score(marked, 2).z
    for _ in range(100):
        moved = Similarity(min_scale=0.1, max_scale=10)(marked, rng)
        assert scheme.score(moved, 2).z == pytest.approx(expected, rel=1e-6)


def test_winding_does_not_matter():
    outward, _ = SMALL.embed(MESH, 6)
    inward, _ = SMALL.embed(inside_out(MESH), 6)
    np.testing.assert_allclose(inward.vertices, outward.vertices, rtol=0, atol=1e-13)
    assert SMALL.score(inward, 6).z == pytest.approx(SMALL.score(outward, 6).z, rel=1e-9)


@pytest.mark.parametrize("detector", [GgdLrt(), GgdLrt(shape="ml"), Linear()], ids=lambda d: d.label())
@pytest.mark.parametrize("miss", ["far-wall", "exclude"])
@pytest.mark.parametrize("normalize", ["region", "image"])
def test_every_reading_marks_and_finds_an_open_mesh(miss, normalize, detector):
    mesh = open_mesh()
    scheme = Song2002(alpha=4.0, miss=miss, normalize=normalize, detector=detector)
    marked, _ = scheme.embed(mesh, 8)
    assert scheme.score(marked, 8).z > 10
    assert abs(scheme.score(marked, 9).z) < 5  # 6e-7 false alarm


def test_excluded_blocks_are_neither_changed_nor_read():
    mesh = open_mesh()
    scheme = Song2002(miss="exclude")
    image = scan(mesh, scheme.grid)
    missed = np.isnan(image.ranges[2:82, :80]).reshape(10, 8, 10, 8).any(axis=(1, 3)).ravel()
    assert 0 < missed.sum() < 100
    marked, _ = scheme.embed(mesh, 8)
    b = scheme.evidence(marked).b.reshape(100, 63)
    assert (b[missed] == 0).all()
    assert (b[~missed] != 0).all()

    # vertices more than a pixel inside an excluded block stay where they are
    u = (image.cylinder.posed(mesh)[:, 0] - image.cylinder.hmin) / image.cylinder.height * 84 - 0.5
    angle = np.arctan2(*image.cylinder.posed(mesh)[:, 1:].T)
    v = angle / (2 * np.pi) * 84 % 84
    block = (np.clip((u - 2) // 8, 0, 9) * 10 + np.clip(v // 8, 0, 9)).astype(int)
    inside = ((u - 2) % 8 <= 7) & (v % 8 <= 7) & (u >= 2) & (u < 82) & (v < 80)
    stays = inside & missed[block]
    assert stays.sum() > 100
    np.testing.assert_array_equal(marked.vertices[stays], mesh.vertices[stays])
    moves = inside & ~missed[block]
    assert (marked.vertices[moves] != mesh.vertices[moves]).any(axis=1).all()


def test_normalizing_over_the_image_marks_by_the_span_of_the_image():
    ranges = scan(MESH, SMALL.grid).ranges
    ratio = np.ptp(ranges) / np.ptp(ranges[2:26, 8:24])
    over_region, over_image = (
        SMALL.model_copy(update={"normalize": n}).embed(MESH, 1)[0] for n in ("region", "image")
    )
    assert ratio > 1.05
    assert snr(MESH, over_region) - snr(MESH, over_image) == pytest.approx(20 * np.log10(ratio), abs=1e-6)


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"alpha": 0}, "scheme song2002: alpha = 0: input should be greater than 0"),
        ({"region": (2, 0, 80, 88)}, "columns 0 to 87 do not fit a grid of 84 rows and 84 columns"),
        ({"region": (5, 0, 80, 80)}, "rows 5 to 84 and columns"),
        ({"region": (2, 0, 81, 80)}, "region.2 = 81: input should be a multiple of 8"),
        ({"region": (-1, 0, 80, 80)}, "region.0 = -1: input should be greater than or equal to 0"),
        ({"region": (2, 0, 80)}, "region"),
        ({"grid": (84, 84.5)}, "grid.1 = 84.5: "),
        ({"miss": "ignore"}, "miss = 'ignore': input should be 'far-wall' or 'exclude'"),
        ({"aplha": 1}, "unknown parameter 'aplha', did you mean 'alpha'?"),
        ({"detector": {"name": "ggd-lrt", "shape": -1}}, "shape"),
        ({"detector": {"name": "median"}}, "median"),
    ],
)
def test_wrong_parameters_are_named_in_one_sentence(parameters, sentence):
    with pytest.raises(Wm3dError) as refusal:
        SCHEMES.build("song2002", parameters)
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)


def flat(vertices: list[list[float]], faces: list[list[int]]) -> Mesh:
    return Mesh(vertices, faces, "sheet")


def on_a_pole() -> Mesh:
    """A blob with a loose vertex far above and another far below, so that the outer rows are empty."""
    cylinder = VertexPca()(MESH)
    ends = cylinder.center + np.array([[9.0], [-9.0]]) * cylinder.axes[0]
    return Mesh(np.vstack([MESH.vertices, ends]), MESH.faces, "blob on a pole")


@pytest.mark.parametrize(
    ("mesh", "scheme", "sentence"),
    [
        (icosphere(3), SMALL, "icosphere: two principal moments"),
        (box((3, 2, 1)), SMALL, "box: is symmetric along"),
        (
            flat([[0, 0, 0], [5, 0, 0], [5, 3, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]]),
            SMALL,
            "sheet: all vertices",
        ),
        (flat([[0, 0, 0], [3, 0, 0], [0, 1, 2]], [[0, 1, 2]]), SMALL, "sheet: all vertices lie in a plane"),
        (
            on_a_pole(),
            SMALL.model_copy(update={"region": (0, 0, 8, 24)}),
            "blob on a pole: the range image is flat",
        ),
        (
            open_mesh(),
            Song2002(grid=(8, 8), region=(0, 0, 8, 8), miss="exclude"),
            "open blob: every block of",
        ),
    ],
    ids=["sphere", "box", "sheet", "triangle", "empty region", "no whole block"],
)
def test_mesh_that_cannot_carry_the_mark_is_refused(mesh, scheme, sentence):
    with pytest.raises(Wm3dError, match=f"^{sentence}"):
        scheme.embed(mesh, 1)
