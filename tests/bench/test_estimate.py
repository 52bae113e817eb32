"""Dry runs: the plan, what is there, and the time from real trials; nothing is stored."""

import pytest
from shapes import box

from wm3d.attacks import Clean, GaussianNoise, Simplify
from wm3d.bench import run_config
from wm3d.bench.estimate import Cost, seconds, setting
from wm3d.bench.plan import Task, TrialCell
from wm3d.mesh import save_mesh
from wm3d.schemes import Song2002

COST = Cost(embed=1.0, attack=10.0, read=0.1, error="")


def cell(attack, hypothesis="H1", trials=5) -> TrialCell:
    return TrialCell(1, "m", "d", Song2002(), attack, 0, trials, hypothesis)


def test_a_dry_run_tells_the_plan_and_stores_nothing(config, tmp_path, capsys):
    run_config(config("unmarked: true"), out=tmp_path / "run", workers=2, dry_run=True)
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].split() == ["attack", "cells", "there", "trials", "s", "a", "trial"]
    *_, clean, noise, similarity, count, time = lines
    assert [line.split()[-4:-1] for line in (clean, noise, similarity)] == [["4", "0", "8"]] * 3
    assert 0 < float(clean.split()[-1]) < 60
    assert count == "small: 12 cells, 0 of them there already."
    assert time.startswith("The rest takes about ")
    assert time.endswith(" s on 2 workers, from one trial of each kind.")
    assert not (tmp_path / "run").exists()


def test_a_dry_run_over_a_finished_run_has_nothing_to_time(config, tmp_path, capsys):
    run_config(config(), out=tmp_path / "run", workers=1)
    capsys.readouterr()
    run_config(config(), out=tmp_path / "run", overrides=["trials=4"], dry_run=True)
    *_, similarity, count = capsys.readouterr().out.splitlines()
    assert similarity.split()[-3:] == ["2", "2", "4"]
    assert count == "small: 6 cells, 6 of them there already."


def test_a_dry_run_tells_which_attacks_fail(config, tmp_path, monkeypatch, capsys):
    def unlucky(*_: object) -> None:
        raise RuntimeError("no luck")

    monkeypatch.setattr(GaussianNoise, "__call__", unlucky)
    run_config(config(), out=tmp_path / "run", dry_run=True)
    out = capsys.readouterr().out
    (noise,) = [line for line in out.splitlines() if "gaussian-noise" in line]
    assert noise.split()[-1] == "failed"
    assert "RuntimeError: no luck" in out


def test_a_dry_run_tells_which_meshes_are_refused_and_why(config, tmp_path, capsys):
    save_mesh(box(), tmp_path / "box.ply")
    override = f"cases=[{{meshes: ['{tmp_path / 'box.ply'}'], schemes: [{{name: cho2007-mean}}]}}]"
    run_config(config(), out=tmp_path / "run", dry_run=True, overrides=[override])
    out = capsys.readouterr().out
    assert [line.split()[-1] for line in out.splitlines() if line.startswith(" clean")] == ["refused"]
    assert "not marked: " in out


@pytest.mark.parametrize(
    ("cells", "expected"),
    [
        ([cell(Clean())], 5 * 11.1),
        ([cell(Clean()), cell(GaussianNoise())], 5 * (1 + 2 * 10.1)),  # embedded once for both
        ([cell(GaussianNoise()), cell(GaussianNoise(), "H0-unmarked")], 5 * (1 + 2 * 10.1)),
        ([cell(Simplify()), cell(Simplify(), "H0-unmarked")], 5 * 11.1 + 10.1),  # attacked once unmarked
    ],
)
def test_the_estimate_counts_what_a_task_does_once_only_once(cells, expected):
    costs = {setting(each): COST for each in cells}
    assert seconds([Task(tuple(cells))], costs) == pytest.approx(expected)
