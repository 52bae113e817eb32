"""What the robust scheme refuses to mark or to read, and wrong parameters: each in one sentence."""

import numpy as np
import pytest
from shapes import blob, box, fine_box, icosphere, lathe, uv_cylinder

from wm3d.attacks import HalfSpaceCrop
from wm3d.errors import NoSolidError, Wm3dError
from wm3d.imagemarks.fine_signs import LAYERS
from wm3d.mesh import Mesh
from wm3d.packing import packed
from wm3d.schemes import SCHEMES, RangeDct

SCHEME = SCHEMES.build("range-dct", {})
MESH = blob(0, 4)


@pytest.fixture(scope="module")
def embedded():
    """The blob marked with seed 1, and the scheme that reads it."""
    return SCHEME.embed(MESH, 1)


def test_scheme_without_a_reference_says_so():
    for call in (lambda: SCHEME.evidence(MESH), lambda: SCHEME.score(MESH, 1), lambda: SCHEME.capacity):
        with pytest.raises(Wm3dError, match="reads a mesh with the reference that its embedding returned"):
            call()


def test_a_suspect_without_area_is_refused(embedded):
    line = Mesh(np.arange(4)[:, None] * np.ones(3), [[0, 1, 2], [1, 2, 3]], "line")
    with pytest.raises(Wm3dError, match=r"^line: its faces have no area"):
        embedded[1].score(line, 1)


SHEET = Mesh([[0, 0, 0], [5, 0, 0], [5, 3, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]], "sheet")


@pytest.mark.parametrize(
    ("mesh", "sentence"),
    [
        (SHEET, "its faces enclose no volume"),
        (icosphere(3), "looks the same, or nearly, from all sides or all around"),
        (uv_cylinder(1, 5, 32, 4), "looks the same, or nearly, from all sides or all around"),
        (box((3, 2, 1)), "the mark cannot be read even from the marked mesh"),  # of eight vertices
    ],
    ids=lambda value: value.name if isinstance(value, Mesh) else "",
)
def test_mesh_that_cannot_carry_the_mark_is_refused(mesh, sentence):
    with pytest.raises(Wm3dError, match=f"^{mesh.name}: {sentence}") as refusal:
        SCHEME.embed(mesh, 1)
    assert "\n" not in str(refusal.value)


def test_symmetric_mesh_is_refused_where_the_mark_is_too_faint_to_tell_its_sides_apart():
    with pytest.raises(
        Wm3dError, match=r"^box: looks the same, or nearly, from 24 sides or all around, and a mark"
    ):
        RangeDct(alpha=0.02).embed(fine_box(), 1)


def test_vase_whose_ends_differ_is_refused_for_it_is_round():
    heights = np.linspace(0, 3, 60)
    vase = lathe(heights, 0.6 + 0.3 * np.sin(5 * heights / 3) + 0.2 * heights / 3, 80)
    with pytest.raises(Wm3dError, match="or all around"):
        SCHEME.embed(vase, 1)


def test_sheet_shows_no_mark(embedded):
    assert embedded[1].score(SHEET, 1).z == pytest.approx(0, abs=4)  # Pf 6e-5, of a fixed draw


def test_half_a_model_that_bounds_no_solid_is_refused_as_an_original_and_read_by_the_landmarks(bunny):
    marked, scheme = SCHEME.embed(bunny, 1)
    half = HalfSpaceCrop(percent=60)(marked, np.random.default_rng(0))
    with pytest.raises(
        NoSolidError, match=r"^bunny: its faces bound no solid that extends in every direction"
    ):
        SCHEME.embed(half, 1)
    assert scheme.score(half, 1).detected()


GOOD = {
    "grid": (96, 64),
    "hmin": -1.5,
    "height": 3.0,
    "moments": (0.1,) * 31,
    "offset": (0, 0, 0),
    "area": 8.0,
    "landmarks": "",
    "home": (1,) * 12,
    "strength": 0.01,
    "steps": packed(np.full(96, 1e-3)),
}


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"alpha": 0}, "alpha = 0: input should be greater than 0"),
        ({"blocks": 0}, "blocks = 0: input should be greater than or equal to 1"),
        ({"aplha": 1}, "unknown parameter 'aplha', did you mean 'alpha'?"),
        ({"reference": GOOD | {"grid": (96, 60)}}, "grid.1 = 60: input should be a multiple of 8"),
        ({"reference": GOOD | {"height": 0}}, "height = 0: input should be greater than 0"),
        ({"reference": GOOD | {"hmin": np.nan}}, "hmin = nan: input should be a finite number"),
        ({"reference": GOOD | {"moments": (0.1,) * 30}}, "moments"),
        (
            {"reference": GOOD | {"offset": (1e300, 0, 0)}},
            "offset.0 = 1e+300: input should be less than or equal to",
        ),
        (
            {"reference": GOOD | {"home": (*[0] * 11, -1e300)}},
            "home.11 = -1e+300: input should be greater than or equal to",
        ),
        ({"reference": GOOD | {"home": (1e-300,) * 12}}, "must not shrink a mesh by more than 1e+60"),
        ({"reference": GOOD | {"landmarks": "AAAA"}}, "rows of 6 numbers, and 3 bytes are not"),
        ({"reference": GOOD | {"landmarks": "é"}}, "landmarks must be base64"),
        ({"reference": GOOD | {"landmarks": packed(np.ones((70, 6)))}}, "must not all lie in one place"),
        ({"reference": GOOD | {"steps": packed(np.ones(95))}}, "grid of 96×64 has 96 blocks, but 95 steps"),
        ({"reference": GOOD | {"steps": packed(-np.ones(96))}}, "steps must not be negative"),
        ({"reference": GOOD | {"steps": packed(np.full(96, np.inf))}}, "steps must be finite numbers"),
        ({"reference": GOOD | {"pose": "pca"}}, "pose"),
    ],
)
def test_wrong_parameters_are_named_in_one_sentence(parameters, sentence):
    assert SCHEMES.build("range-dct", {"reference": GOOD}).capacity == (1 + LAYERS) * 96 * 63
    with pytest.raises(Wm3dError) as refusal:
        SCHEMES.build("range-dct", parameters)
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)
