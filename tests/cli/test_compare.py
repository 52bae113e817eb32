"""`wm3d compare`: every metric of two files, for people and as JSON; what does not apply says so."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import box, icosphere

import wm3d as library
from wm3d.attacks import Reorder
from wm3d.mesh import save_mesh
from wm3d.metrics import METRICS

Run = Callable[..., Any]
PERCENT = "hausdorff_percent_of_diagonal"
VERTEX_BY_VERTEX = ("snr_db", "psnr_db", "msdm")


@pytest.fixture
def cubes(tmp_path: Path) -> tuple[Path, Path]:
    """A cube, and one that is 10 % longer to one side."""
    longer = box().vertices.copy()
    longer[longer[:, 0] > 0, 0] += 0.1
    save_mesh(box(), tmp_path / "cube.ply")
    save_mesh(box().with_vertices(longer), tmp_path / "longer.ply")
    return tmp_path / "cube.ply", tmp_path / "longer.ply"


def test_json_holds_every_metric_with_its_unit(wm3d: Run, cubes: tuple[Path, Path]) -> None:
    outcome = wm3d("compare", *cubes, "--json")
    assert outcome.status == 0
    found = json.loads(outcome.stdout)
    assert (found.pop("original"), found.pop("other")) == tuple(map(str, cubes))
    assert found.pop("notes") == {}
    for name, metric in METRICS.items():
        assert f"{name.replace('-', '_')}_{metric.unit}".rstrip("_") in found
    assert found["hausdorff_mesh_units"] == pytest.approx(0.1)
    assert found[PERCENT] == pytest.approx(10 / 3**0.5)
    assert found["volume_change_percent"] == pytest.approx(10)
    assert found == library.compare(*map(library.load_mesh, cubes))


def test_text_has_the_numbers_of_the_json(wm3d: Run, cubes: tuple[Path, Path]) -> None:
    rows = dict(line.split() for line in wm3d("compare", *cubes).stdout.splitlines()[1:])
    found = json.loads(wm3d("compare", *cubes, "--json").stdout)
    assert {name: float(value) for name, value in rows.items()} == pytest.approx(
        {name: found[name] for name in rows}, rel=1e-5
    )


def test_other_vertices_are_no_obstacle_to_the_other_metrics(
    wm3d: Run, cubes: tuple[Path, Path], tmp_path: Path
) -> None:
    save_mesh(icosphere(2), tmp_path / "sphere.ply")
    found = json.loads(wm3d("compare", cubes[0], tmp_path / "sphere.ply", "--json").stdout)
    assert found["notes"] == dict.fromkeys(VERTEX_BY_VERTEX, "needs the same vertices in the same order")
    assert found["snr_db"] is None
    assert found[PERCENT] > 0
    assert found["msdm2"] > 0
    text = wm3d("compare", cubes[0], tmp_path / "sphere.ply").stdout
    assert next(line for line in text.splitlines() if line.startswith("msdm ")).endswith("in the same order")


def test_vertices_in_another_order_are_others_and_faces_in_another_order_are_not(
    wm3d: Run, files: Path, tmp_path: Path
) -> None:
    mesh = library.load_mesh(files / "good.ply")
    save_mesh(Reorder()(mesh, np.random.default_rng(1)), tmp_path / "shuffled.ply")
    found = json.loads(wm3d("compare", files / "good.ply", tmp_path / "shuffled.ply", "--json").stdout)
    assert set(VERTEX_BY_VERTEX) <= found["notes"].keys()
    assert found["hausdorff_mesh_units"] < 1e-9
    for name, stored in (("one", mesh), ("two", library.Mesh(mesh.vertices, mesh.faces[::-1]))):
        save_mesh(stored, tmp_path / f"{name}.stl")
    found = json.loads(wm3d("compare", tmp_path / "one.stl", tmp_path / "two.stl", "--json").stdout)
    assert set(VERTEX_BY_VERTEX) <= found["notes"].keys()
    assert found["hausdorff_mesh_units"] < 1e-9
    save_mesh(library.Mesh(1.1 * mesh.vertices, mesh.faces[::-2, ::-1]), tmp_path / "half.ply")
    found = json.loads(wm3d("compare", files / "good.ply", tmp_path / "half.ply", "--json").stdout)
    assert found["snr_db"] == pytest.approx(20)  # of a tenth


def test_infinite_numbers_are_null_and_noted(wm3d: Run, cubes: tuple[Path, Path]) -> None:
    found = json.loads(wm3d("compare", cubes[0], cubes[0], "--json").stdout)
    assert found["notes"] == {"snr_db": "infinite", "psnr_db": "infinite"}
    assert found["snr_db"] is None
    assert found["msdm2"] == 0


def test_a_metric_that_is_not_defined_says_why(wm3d: Run, files: Path) -> None:
    found = json.loads(wm3d("compare", files / "sheet.off", files / "good.ply", "--json").stdout)
    assert "enclose no volume" in found["notes"]["volume_change_percent"]
    assert found["volume_change_percent"] is None


def test_a_mesh_in_another_unit_has_the_metrics_that_do_not_measure_its_surface(
    wm3d: Run, cubes: tuple[Path, Path], tmp_path: Path
) -> None:
    save_mesh(box().with_vertices(1000 * box().vertices), tmp_path / "mm.ply")
    found = json.loads(wm3d("compare", cubes[0], tmp_path / "mm.ply", "--json").stdout)
    reason = f"{tmp_path / 'mm.ply'}: is 1,000 times as large as {cubes[0]}; bring them to one unit."
    lengths = ("hausdorff", "mrms")
    refused = [f"{name}_{unit}" for name in lengths for unit in ("mesh_units", "percent_of_diagonal")]
    assert found["notes"] == dict.fromkeys([*refused, "normal_deviation_deg", "msdm", "msdm2"], reason)
    assert found["volume_change_percent"] == pytest.approx(100 * (1e9 - 1))


@pytest.mark.parametrize(("file", "words"), [("missing.ply", "no such file"), ("cloud.off", "has no faces")])
@pytest.mark.parametrize("place", [0, 1])
def test_bad_input_is_one_sentence(wm3d: Run, files: Path, file: str, words: str, place: int) -> None:
    names = [files / "good.ply", files / "good.ply"]
    names[place] = files / file
    outcome = wm3d("compare", *names)
    assert outcome.status == 2
    assert outcome.stdout == ""
    assert outcome.stderr.startswith("wm3d: ")
    assert outcome.stderr.count("\n") == 1
    assert file in outcome.stderr
    assert words in outcome.stderr
