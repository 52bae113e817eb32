"""The paper's way to the mesh and back with any 2-D mark."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.stats import kstest
from shapes import blob

from wm3d.attacks import GaussianNoise
from wm3d.errors import Wm3dError
from wm3d.imagemarks import IMAGEMARKS, Cox, DctAdditive, DwtAdditive, GgdLrt, QimDct
from wm3d.mesh import Mesh
from wm3d.metrics import snr
from wm3d.scanner import VertexPca
from wm3d.schemes import SCHEMES, Key, RangeMark, Song2002

MESH = blob(0, 5)
VARIANTS = [RangeMark(mark=cls()) for cls in IMAGEMARKS.values()]

every_mark = pytest.mark.parametrize("scheme", VARIANTS, ids=lambda scheme: scheme.label())


def open_mesh() -> Mesh:
    """A blob with a patch of one side cut away, so that rays miss."""
    posed = VertexPca()(MESH).posed(MESH)
    corners = posed[MESH.faces].mean(axis=1)
    return Mesh(MESH.vertices, MESH.faces[(corners[:, 1] < 0.3) | (np.abs(corners[:, 0]) > 0.2)], "open blob")


@pytest.mark.parametrize("detector", [GgdLrt(), GgdLrt(shape="ml")], ids=lambda d: d.label())
def test_with_the_mark_of_the_paper_it_is_song2002(detector):
    paper = Song2002(alpha=2.6, miss="exclude", detector=detector)
    scheme = RangeMark(alpha=2.0, miss="exclude", mark=DctAdditive(alpha=1.3, detector=detector))
    mesh = open_mesh()
    marked, _ = paper.embed(mesh, 3)
    assert scheme.embed(mesh, 3)[0].digest() == marked.digest()
    np.testing.assert_array_equal(scheme.evidence(marked).b, paper.evidence(marked).b)


@every_mark
def test_right_key_is_found_after_noise_and_wrong_keys_follow_the_null(scheme):
    marked, its = scheme.embed(MESH, 1)
    assert its == scheme
    attacked = GaussianNoise(percent=0.2)(marked, np.random.default_rng(1))
    evidence = scheme.evidence(attacked)
    assert scheme.score(marked, 1).z > 20
    assert evidence.score(scheme.signs(1)).z > 10
    wrong = [evidence.score(scheme.signs(seed)) for seed in range(100, 400)]
    z = np.array([score.z for score in wrong])
    # five standard errors each, and the p-values uniform at a false-alarm rate of 1e-6
    assert abs(z.mean()) < 5 / np.sqrt(300)
    assert abs(z.var() - 1) < 5 * np.sqrt(2 / 300)
    assert kstest([score.p_value for score in wrong], "uniform").pvalue > 1e-6
    assert abs(scheme.score(MESH, 1).z) < 5  # an unmarked model, the right key: 6e-7 false alarm


@every_mark
def test_rays_that_miss_are_excluded(scheme):
    mesh = open_mesh()
    scheme = scheme.model_copy(update={"miss": "exclude"})
    marked, _ = scheme.embed(mesh, 8)
    assert scheme.score(marked, 8).z > 10


@every_mark
def test_strength_is_set_from_a_wanted_snr(scheme):
    strong = scheme.at_snr(MESH, 7, 44.0)
    # quantized moves jump with the step; additive marks are exact
    tolerance = 0.05 if isinstance(scheme.mark, QimDct) else 1e-6
    assert snr(MESH, strong.embed(MESH, 7)[0]) == pytest.approx(44.0, abs=tolerance)
    assert strong == scheme.model_copy(update={"alpha": strong.alpha})


@every_mark
def test_key_comes_back_from_its_file(scheme, tmp_path):
    Key(scheme, 5).save(tmp_path / "key.json")
    assert Key.load(tmp_path / "key.json") == Key(scheme, 5)


def test_installed_packages_add_marks(tmp_path):
    # the package imports schemes too, which import the registry that is about to read it
    (tmp_path / "foreign.py").write_text(
        "from typing import Literal\n"
        "import wm3d.schemes\n"
        "from wm3d.imagemarks import Cox\n"
        "class Foreign(Cox):\n"
        "    name: Literal['foreign'] = 'foreign'\n"
    )
    info = tmp_path / "foreign-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: foreign\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[wm3d.imagemarks]\nforeign = foreign:Foreign\n")
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from wm3d.schemes import SCHEMES; "
        "print(SCHEMES.build('range-mark', {'mark': {'name': 'foreign', 'count': 9}}).capacity)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stdout == "9\n", done.stderr


def test_identity_holds_the_version_of_the_mark_and_the_engine_behind_it():
    scheme = RangeMark(mark=DwtAdditive())
    assert scheme.identity()["mark"]["version"] == DwtAdditive.version
    assert scheme.engines == ("PyWavelets",)
    assert RangeMark().engines == ()
    assert RangeMark(alpha=0.5, mark=Cox(count=500)).label() == "range-mark alpha=0.5 (cox count=500)"


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"mark": {"name": "coxx"}}, "scheme range-mark: mark has the unknown name 'coxx'"),
        ({"mark": {"name": "cox", "count": -1}}, "mark.cox.count = -1: "),
        ({"mark": {"name": "cox", "cuont": 1}}, "unknown parameter 'mark.cox.cuont'."),
        (
            {"alpha": 1e30, "mark": {"name": "cox", "alpha": 1e30}},
            "alpha times the alpha of the mark must not",
        ),
        ({"region": (2, 0, 80, 88)}, "columns 0 to 87 do not fit a grid of 84 rows and 84 columns"),
    ],
)
def test_wrong_parameters_are_named_in_one_sentence(parameters, sentence):
    with pytest.raises(Wm3dError) as refusal:
        SCHEMES.build("range-mark", parameters)
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_mesh_without_a_place_for_the_mark_is_refused():
    scheme = RangeMark(grid=(8, 8), region=(0, 0, 8, 8), miss="exclude", mark=QimDct())
    with pytest.raises(Wm3dError, match=r"^open blob: every block of the region"):
        scheme.embed(open_mesh(), 1)
