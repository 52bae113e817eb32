"""`wm3d attack` and `wm3d scan`: the same meshes and images as the library, and pictures the right way up."""

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread

import wm3d as library
from wm3d.attacks import GaussianNoise
from wm3d.cli.picture import range_picture
from wm3d.scanner import Cylinder, RangeImage

Run = Callable[..., Any]


def test_attack_is_the_attack_of_the_library(wm3d: Run, files: Path, out: Path) -> None:
    pairs = ("percent=2", "amplitude=per-axis")
    outcome = wm3d("attack", files / "good.ply", out / "noisy.ply", "gaussian-noise", *pairs, "--seed", "3")
    mesh = library.load_mesh(files / "good.ply")
    expected = GaussianNoise(percent=2, amplitude="per-axis")(mesh, np.random.default_rng(3))
    assert outcome.status == 0
    assert library.load_mesh(out / "noisy.ply").digest() == expected.digest()
    assert "vertices 2562 -> 2562" in outcome.stdout
    assert "faces    5120 -> 5120" in outcome.stdout
    assert "sigma per axis: 2 % " in outcome.stdout


def test_sigma_of_a_vector_amplitude_is_one_over_root_three(wm3d: Run, files: Path, out: Path) -> None:
    # 1e-3 is a number in YAML 1.2; YAML 1.1 would make it a string
    outcome = wm3d("attack", files / "good.ply", out / "noisy.ply", "gaussian-noise", "percent=1e-3")
    assert "sigma per axis: 0.0005774 % " in outcome.stdout


def test_face_counts_before_and_after(wm3d: Run, files: Path, out: Path) -> None:
    outcome = wm3d("attack", files / "good.ply", out / "half.ply", "simplify", "ratio=0.25")
    faces = len(library.load_mesh(out / "half.ply").faces)
    assert f"faces    5120 -> {faces}\n" in outcome.stdout
    assert faces == pytest.approx(1280, abs=1)
    assert "sigma" not in outcome.stdout


@pytest.mark.parametrize("file", ["triangle.off", "sheet.off", "sphere.ply"])
def test_attacks_need_no_pose(file: str, wm3d: Run, files: Path, out: Path) -> None:
    assert wm3d("attack", files / file, out / "noisy.ply", "gaussian-noise").status == 0


def test_attack_tells_scripts_what_it_prints(wm3d: Run, files: Path, out: Path) -> None:
    arguments = ("attack", files / "good.ply", out / "noisy.stl", "gaussian-noise", "percent=0.5")
    told = json.loads(wm3d(*arguments, "--seed", "4", "--json").stdout)
    mesh = library.load_mesh(files / "good.ply")
    assert (told["attack"], told["seed"]) == ("gaussian-noise 0.5 rms-vector", 4)
    assert told["vertices"] == [len(mesh.vertices), 3 * len(mesh.faces)]
    assert told["sigma_percent"] == pytest.approx(0.5 / 3**0.5)


def test_stored_ranges_are_those_of_the_library(wm3d: Run, files: Path, out: Path) -> None:
    assert wm3d("scan", files / "good.ply", out / "image.npy", "--grid", "30x20").status == 0
    ranges = np.load(out / "image.npy")
    expected = library.scan(library.load_mesh(files / "good.ply"), grid=(30, 20)).ranges
    assert ranges.shape == (20, 30)
    assert ranges.dtype == np.float64
    np.testing.assert_array_equal(ranges, expected)


def test_dataset_name_stands_for_its_file(wm3d: Run, out: Path) -> None:
    outcome = wm3d("scan", "bunny", out / "image.png", "--grid", "16x16")
    assert outcome.status == 0
    assert outcome.stdout.startswith(f"bunny -> {out / 'image.png'}: 16 columns x 16 rows")
    assert imread(out / "image.png").ndim == 3


def test_picture_has_the_top_row_up_and_misses_in_grey() -> None:
    ranges = np.random.default_rng(0).uniform(0.1, 1.9, (20, 40))
    ranges[-4:, :20] = np.nan  # the highest rows, the first columns
    cylinder = Cylinder(np.zeros(3), np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, -1]]), 1.0, -1.0, 1.0)
    pixels = imread(io.BytesIO(range_picture(RangeImage(ranges, cylinder), "price $5 or $6_")))
    grey = np.isclose(pixels[..., :3], 0.8, atol=0.01).all(axis=2)
    rows, columns = np.nonzero(grey)
    height, width = grey.shape
    # the patch of the legend is grey as well, but small
    assert np.median(rows) < height / 2
    assert np.median(columns) < width / 2
    assert grey.sum() == pytest.approx(0.1 * 0.6 * grey.size, rel=0.5)
