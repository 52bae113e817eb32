"""`wm3d embed` and `wm3d detect`: what they write, print and return."""

import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from shapes import icosphere

import wm3d as library
from wm3d.mesh import save_mesh
from wm3d.schemes import Key
from wm3d.stats import Score

Run = Callable[..., Any]
SMALL = ("--grid", "24x24", "--region", "4,0,16,24")


def test_detect_finds_what_embed_wrote(wm3d: Run, files: Path) -> None:
    outcome = wm3d("detect", files / "marked.ply", "--key", files / "good.json", "--json")
    found = json.loads(outcome.stdout, parse_constant=pytest.fail)  # JSON knows neither NaN nor Infinity
    score = library.detect(library.load_mesh(files / "marked.ply"), Key.load(files / "good.json"))
    assert outcome.status == 0
    assert outcome.stderr == ""
    assert found == {
        "detected": True,
        "p_value": score.p_value,
        "log10_p": score.log10_p,
        "z": score.z,
        "statistic": score.statistic,
        "threshold_pf": 1e-6,
        "scheme": "song2002",
        "mesh": str(files / "marked.ply"),
    }


def test_detect_finds_nothing_in_the_original(wm3d: Run, files: Path) -> None:
    arguments = ("detect", files / "good.ply", "--key", files / "good.json")
    assert wm3d(*arguments).status == 1
    outcome = wm3d(*arguments, "--json")
    assert outcome.status == 1
    assert outcome.stderr == ""
    assert json.loads(outcome.stdout)["detected"] is False


def test_an_original_that_a_blind_scheme_does_not_look_at_is_told(wm3d: Run, files: Path) -> None:
    arguments = (
        "detect",
        files / "marked.ply",
        "--key",
        files / "good.json",
        "--original",
        files / "good.ply",
    )
    outcome = wm3d(*arguments)
    assert outcome.status == 0
    assert outcome.stderr.endswith("good.ply: is not looked at, for song2002 is a blind scheme.\n")


def test_no_mark_with_a_key_of_another_version_says_so(wm3d: Run, files: Path, tmp_path: Path) -> None:
    content = json.loads((files / "good.json").read_text())
    (tmp_path / "old.json").write_text(json.dumps({**content, "version": 0}))
    assert wm3d("detect", files / "marked.ply", "--key", tmp_path / "old.json").stderr == ""
    outcome = wm3d("detect", files / "good.ply", "--key", tmp_path / "old.json")
    assert outcome.status == 1
    assert "was written for version 0 of its scheme" in outcome.stderr


def test_pf_is_the_threshold_on_p(wm3d: Run, files: Path) -> None:
    arguments = ("detect", files / "good.ply", "--key", files / "good.json", "--json")
    p = json.loads(wm3d(*arguments).stdout)["p_value"]
    assert wm3d(*arguments, "--pf", repr(p * (1 + 1e-9))).status == 0
    assert wm3d(*arguments, "--pf", repr(p * (1 - 1e-9))).status == 1
    assert wm3d(*arguments, "--pf", "1").status == 0


def test_impossible_p_is_null_in_json(wm3d: Run, files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    score = Key.score

    def impossible(self: Key, mesh: library.Mesh) -> Score:
        return replace(score(self, mesh), log10_p=-math.inf)

    monkeypatch.setattr(Key, "score", impossible)
    found = json.loads(wm3d("detect", files / "good.ply", "--key", files / "good.json", "--json").stdout)
    assert (found["log10_p"], found["p_value"], found["detected"]) == (None, 0.0, True)


@pytest.mark.parametrize("ending", library.mesh.ENDINGS)
def test_embed_prints_what_detection_gives_on_the_written_file(
    ending: str, wm3d: Run, files: Path, out: Path
) -> None:
    target, key = out / f"marked{ending}", out / "key.json"
    outcome = wm3d("embed", files / "good.ply", target, "--key", key, "--seed", "3", *SMALL)
    score = library.detect(library.load_mesh(target), Key.load(key))
    assert outcome.status == 0
    assert f"z = {score.z:.2f}, log10 p = {score.log10_p:.2f}\n" in outcome.stdout
    assert score.detected(1e-6)


def test_embed_reaches_the_wanted_snr(wm3d: Run, files: Path, out: Path) -> None:
    target = out / "marked.ply"
    outcome = wm3d("embed", files / "good.ply", target, "--key", out / "key.json", "--snr", "44", *SMALL)
    assert "SNR 44.00 dB" in outcome.stdout
    assert library.snr(library.load_mesh(files / "good.ply"), library.load_mesh(target)) == pytest.approx(
        44, abs=1e-5
    )


def test_embed_tells_scripts_what_detect_tells_them(wm3d: Run, files: Path, out: Path) -> None:
    target, key = out / "marked.ply", out / "key.json"
    told = json.loads(wm3d("embed", files / "good.ply", target, "--key", key, "--json", *SMALL).stdout)
    assert told["snr_db"] == pytest.approx(
        library.snr(library.load_mesh(files / "good.ply"), library.load_mesh(target)), abs=1e-9
    )
    read = json.loads(wm3d("detect", told["marked"], "--key", told["key"], "--json").stdout)
    assert read.pop("mesh") == told["marked"]
    assert read.items() <= told.items()


def test_key_holds_the_options_and_the_parameters(wm3d: Run, files: Path, out: Path) -> None:
    options = ("--seed", "5", "--alpha", "2.5", *SMALL, "miss=exclude", "detector={name: linear}")
    wm3d("embed", files / "good.ply", out / "marked.ply", "--key", out / "key.json", *options)
    key = json.loads((out / "key.json").read_text())
    assert key["seed"] == 5
    assert key["scheme"]["grid"] == [24, 24]
    assert key["scheme"]["region"] == [4, 0, 16, 24]
    assert (key["scheme"]["alpha"], key["scheme"]["miss"]) == (2.5, "exclude")
    assert key["scheme"]["detector"] == {"name": "linear"}


def test_secret_is_random_unless_given_and_never_printed(wm3d: Run, files: Path, out: Path) -> None:
    seeds = []
    for name in ("a", "b"):
        outcome = wm3d(
            "embed", files / "good.ply", out / f"{name}.ply", "--key", out / f"{name}.json", *SMALL
        )
        seeds.append(Key.load(out / f"{name}.json").seed)
        assert not re.search(r"\d{20}", outcome.stdout + outcome.stderr)
    assert seeds[0] != seeds[1]
    assert min(seeds) > 1 << 64  # false alarm 2 * 2^-64
    assert max(seeds) < 1 << 128


def test_same_seed_gives_the_same_files(wm3d: Run, files: Path, out: Path) -> None:
    for _ in range(2):
        wm3d(
            "embed", files / "good.ply", out / "marked.ply", "--key", out / "key.json", "--seed", "7", *SMALL
        )
        assert (out / "marked.ply").read_bytes() == (files / "marked.ply").read_bytes()
        assert (out / "key.json").read_bytes() == (files / "good.json").read_bytes()


def test_undetectable_mark_is_written_with_a_warning(wm3d: Run, files: Path, out: Path) -> None:
    target = out / "faint.ply"
    options = ("--key", out / "key.json", "--seed", "1", "--alpha", "1e-9", *SMALL)
    outcome = wm3d("embed", files / "good.ply", target, *options)
    assert outcome.status == 0
    assert target.is_file()
    assert re.fullmatch(rf"wm3d: {re.escape(str(target))}: the mark .* too weak; .*\.\n", outcome.stderr)


@pytest.mark.parametrize(
    ("target", "options", "remedy"),
    [
        ("marked.stl", ("--scheme", "vertex-ss"), "the format .stl loses it; write PLY, OBJ or OFF"),
        ("marked.ply", ("--scheme", "cho2007-mean", "bits=8"), "not even the right key could reach that"),
    ],
)
def test_mark_that_the_file_cannot_show_says_why(
    target: str, options: tuple[str, ...], remedy: str, wm3d: Run, files: Path, out: Path
) -> None:
    outcome = wm3d(
        "embed", files / "good.ply", out / target, "--key", out / "key.json", "--seed", "1", *options
    )
    assert outcome.status == 0
    assert remedy in outcome.stderr


def test_another_key_in_the_place_of_a_new_one_is_kept(wm3d: Run, files: Path, out: Path) -> None:
    key = out / "key.json"
    for seed in ("1", "2", "2", "3"):
        outcome = wm3d("embed", files / "good.ply", out / f"{seed}.ply", "--key", key, "--seed", seed, *SMALL)
    assert outcome.stderr == f"wm3d: {key}: held another key, which is kept as {key}.~2~.\n"
    for seed, kept in (("1", f"{key}.~1~"), ("2", f"{key}.~2~"), ("3", key)):
        assert wm3d("detect", out / f"{seed}.ply", "--key", kept).status == 0
    assert len(list(out.glob("key.json*"))) == 3


def test_marking_in_place_when_it_fails_keeps_the_original(wm3d: Run, out: Path) -> None:
    mesh = out / "sphere.ply"
    save_mesh(icosphere(), mesh)
    before = mesh.read_bytes()
    assert wm3d("embed", mesh, mesh, "--key", out / "key.json").status == 2
    assert mesh.read_bytes() == before
    assert [file.name for file in out.iterdir()] == ["sphere.ply"]
