"""`wm3d list` and `wm3d data`: complete, and in a form that can be typed back."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from shapes import tetrahedron

from wm3d.attacks import ATTACKS
from wm3d.cli.options import assignments
from wm3d.mesh import datasets, save_mesh
from wm3d.schemes import SCHEMES

Run = Callable[..., Any]


def test_every_listed_default_can_be_typed_back(wm3d: Run) -> None:
    lines = wm3d("list", "attacks").stdout.splitlines()[1:]
    assert [line.split()[0] for line in lines] == list(ATTACKS)
    for line in lines:
        name, *words = line.split()
        pairs = [word.partition("|")[0] for word in words if "=" in word]
        assert len(pairs) == len(ATTACKS[name].model_fields) - 1
        assert ATTACKS.build(name, assignments(pairs)) == ATTACKS[name]()


@pytest.mark.parametrize("kind", ["schemes", "attacks", "imagemarks", "detectors", "metrics", "poses"])
def test_json_lists_the_names_of_the_table(kind: str, wm3d: Run) -> None:
    names = [line.split()[0] for line in wm3d("list", kind).stdout.splitlines()[1:]]
    assert [one["name"] for one in json.loads(wm3d("list", kind, "--json").stdout)] == names


def test_json_holds_the_defaults(wm3d: Run) -> None:
    for one in json.loads(wm3d("list", "attacks", "--json").stdout):
        assert ATTACKS.build(one["name"], one["parameters"]) == ATTACKS[one["name"]]()


def test_what_embedding_finds_out_is_not_listed_as_a_parameter(wm3d: Run) -> None:
    assert "blocks=null" in wm3d("list", "schemes").stdout
    assert "reference" not in wm3d("list", "schemes").stdout


def test_other_words_of_a_parameter_are_listed(wm3d: Run) -> None:
    assert " amplitude=rms-vector|per-axis " in wm3d("list", "attacks").stdout


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("imagemarks", "cox"),
        ("detectors", "ggd-lrt"),
        ("metrics", "snr"),
        ("poses", "vertex-pca"),
        *(("schemes", s) for s in SCHEMES),
    ],
)
def test_every_kind_lists_name_and_meaning(kind: str, name: str, wm3d: Run) -> None:
    outcome = wm3d("list", kind)
    assert outcome.status == 0
    row = next(line for line in outcome.stdout.splitlines() if line.startswith(f"{name} "))
    assert row.endswith(".")  # the first line of its docstring


def test_data_list_has_the_registry_and_the_data_folder(
    wm3d: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save_mesh(tetrahedron(), tmp_path / "mine.ply")
    monkeypatch.setenv("WM3D_DATA", str(tmp_path))
    lines = wm3d("data", "list").stdout.splitlines()
    assert [line.split()[0] for line in lines[1:]] == datasets.dataset_names()
    assert [
        one["name"] for one in json.loads(wm3d("data", "list", "--json").stdout)
    ] == datasets.dataset_names()
    assert str(tmp_path / "mine.ply") in next(line for line in lines if line.startswith("mine "))
    assert wm3d("data", "path", "mine").stdout == f"{tmp_path / 'mine.ply'}\n"


def test_fetch_prints_the_file_and_whom_to_credit(wm3d: Run) -> None:
    outcome = wm3d("data", "fetch", "bunny")
    assert outcome.status == 0
    assert Path(outcome.stdout.removesuffix("\n")).is_file()
    assert "credit: Stanford" in outcome.stderr
