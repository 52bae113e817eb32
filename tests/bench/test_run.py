"""Runs from config to figures: the same bytes however they were run; what is there is kept."""

import errno
import json
import math
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from wm3d.attacks import ATTACKS, GaussianNoise, Similarity
from wm3d.bench import load_experiment, run_config
from wm3d.bench import run as module
from wm3d.bench.columns import TRIALS
from wm3d.bench.store import FIGURES, TABLES, RunDirectory, report_files
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.schemes import Song2002

BUNNY = """\
name: bunny
trials: 4
block: 2
wrong_keys: 4
unmarked: true
false_alarm_trials: 100000
cases:
  - meshes: [bunny]
    schemes: [{name: song2002}]
attacks:
  - name: clean
  - name: gaussian-noise
  - name: simplify
"""

CONTRACT = [
    "mesh",
    "scheme",
    "attack",
    "attack_parameters",
    "hypothesis",
    "trial",
    "statistic",
    "z",
    "log10_p",
]
CONTRACT += ["snr_db", "axis_deg", "faces_out", "seconds"]


def results(directory: Path) -> dict[str, bytes]:
    """Tables and figures by name; timing.csv, the one that tells seconds, is left out."""
    files = [file for folder in ("tables", "figures") for file in (directory / folder).iterdir()]
    return {file.name: file.read_bytes() for file in files if file.name != "timing.csv"}


def cells(directory: Path) -> dict[str, int]:
    """Time of last change of every cell file."""
    return {file.name: file.stat().st_mtime_ns for file in (directory / "cells").iterdir()}


def detection(directory: Path) -> pd.DataFrame:
    """The detection table by attack."""
    return pd.read_csv(directory / "tables" / "detection.csv").set_index("attack")


@pytest.fixture(scope="module")
def bunny_config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("bunny") / "bunny.yaml"
    path.write_text(BUNNY)
    return path


@pytest.fixture(scope="module")
def bunny_run(bunny_config: Path) -> Path:
    """The run that others are held against: one worker, undisturbed."""
    outcome = run_config(bunny_config, out=bunny_config.parent / "one", workers=1)
    assert outcome.failed == 0
    return outcome.directory


def test_a_run_leaves_tables_figures_rows_and_what_it_ran(bunny_run):
    assert set(results(bunny_run)) >= {
        *("detection.csv", "snr.csv", "axes.csv", "nulls.csv", "false_alarms.csv", "roc_paper.csv"),
        *("roc.png", "roc.svg"),
    }
    written = {file.relative_to(bunny_run).as_posix() for file in bunny_run.glob("[tf]*/*")}
    assert written <= report_files(TABLES, FIGURES)
    assert (bunny_run / "report.html").stat().st_size > 10_000
    again = load_experiment(bunny_run / "config.yaml")
    assert again.trials == 4
    manifest = json.loads((bunny_run / "manifest.json").read_text())
    assert manifest["meshes"]["bunny"]["faces"] == 56172
    assert manifest["lost_trials"] == 0
    assert manifest["schemes"] == {"song2002": Song2002.version, "ggd-lrt": 1}  # and the parts of each
    assert manifest["attacks"] == {
        name: ATTACKS[name].version for name in ("clean", "gaussian-noise", "simplify")
    }
    # 2 blocks × 3 attacks × (marked, unmarked), and 3 curves
    assert (len(manifest["cells"]), len(manifest["false_alarm_cells"])) == (12, 3)
    assert {f"{name}.parquet" for name in manifest["cells"] + manifest["false_alarm_cells"]} == set(
        cells(bunny_run)
    )


def test_rows_have_the_columns_of_the_contract(bunny_run):
    manifest = json.loads((bunny_run / "manifest.json").read_text())
    rows = pd.concat([RunDirectory(bunny_run).read_cell(digest) for digest in manifest["cells"]])
    assert set(CONTRACT) <= set(rows.columns) == set(TRIALS)
    assert rows["hypothesis"].value_counts().to_dict() == {
        "H1": 12,
        "H0-unmarked": 12,
        "H0-wrong-key": 48,
    }
    marked = rows[rows["hypothesis"] == "H1"]
    assert marked["z"][marked["attack"] == "clean"].min() > 40
    assert marked["snr_db"].between(41, 42).all()
    assert set(marked["faces_out"]) == {56172, 28086}


def test_two_workers_give_the_same_bytes(bunny_run, bunny_config, tmp_path):
    outcome = run_config(bunny_config, out=tmp_path, workers=2)
    assert outcome.failed == 0
    assert results(tmp_path) == results(bunny_run)


def test_a_run_that_was_stopped_goes_on_and_gives_the_same_bytes(
    bunny_run, bunny_config, tmp_path, monkeypatch
):
    class Stop(BaseException):
        pass

    write = RunDirectory.write_cell

    def stopping(directory: RunDirectory, digest: str, rows: pd.DataFrame) -> None:
        if len(cells(tmp_path)) == 4:
            raise Stop
        write(directory, digest, rows)

    monkeypatch.setattr(RunDirectory, "write_cell", stopping)
    with pytest.raises(Stop):
        run_config(bunny_config, out=tmp_path, workers=1)
    monkeypatch.undo()
    before = cells(tmp_path)
    assert len(before) == 4
    assert not (tmp_path / "manifest.json").exists()
    run_config(bunny_config, out=tmp_path, workers=1)
    assert cells(tmp_path).items() >= before.items()
    assert results(tmp_path) == results(bunny_run)


@pytest.fixture(scope="module")
def small_run(small_config: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_config(small_config, out=tmp_path_factory.mktemp("small"), workers=1).directory


@pytest.fixture
def small(small_run: Path, tmp_path: Path) -> Path:
    """Copy of a run of the small config: four trials in two blocks, three attacks."""
    return Path(shutil.copytree(small_run, tmp_path / "small"))


def test_the_order_of_the_tasks_does_not_matter(small_run, config, tmp_path, monkeypatch):
    tasks = module.tasks
    monkeypatch.setattr(module, "tasks", lambda cells: tasks(cells)[::-1])
    run_config(config(), out=tmp_path / "backwards", workers=1)
    assert results(tmp_path / "backwards") == results(small_run)


def test_damaged_cells_are_named_and_computed_again(small, config, capsys):
    expected, files = results(small), sorted((small / "cells").iterdir())
    files[0].write_bytes(files[0].read_bytes()[:1000])
    files[1].write_bytes(b"\0" * 1000)
    files[2].write_bytes(files[3].read_bytes())
    times = cells(small)
    capsys.readouterr()
    assert run_config(config(), out=small, workers=1).failed == 0
    told = capsys.readouterr().err
    assert all(f"{file}: is damaged (" in told for file in files[:3])
    assert "3 of 6 cells are there already." in told
    assert results(small) == expected
    changed = {name for name, time in cells(small).items() if time != times[name]}
    assert changed == {file.name for file in files[:3]}


def test_more_attacks_and_trials_leave_files_and_numbers_as_they_are(small, config):
    times, before = cells(small), detection(small)
    run_config(config("  - name: simplify"), out=small, workers=1)
    assert detection(small).drop("simplify 0.5 fast-simplification").equals(before)
    assert cells(small).items() > times.items()
    assert len(cells(small)) == len(times) + 2  # two blocks of the new attack
    run_config(config(), out=small, overrides=["trials=6"], workers=1)
    assert set(detection(small)["trials"]) == {6}
    assert cells(small).items() > times.items()
    assert len(cells(small)) == len(times) + 2 + 3  # one more block of the old ones


def test_a_changed_parameter_runs_only_what_depends_on_it(small, config):
    times, before = cells(small), detection(small)
    run_config(config(), out=small, overrides=["attacks.1.percent=0.1"], workers=1)
    assert cells(small).items() > times.items()
    assert len(cells(small)) == len(times) + 2
    assert detection(small).loc[["clean", "similarity"]].equals(before.loc[["clean", "similarity"]])


def test_a_run_of_other_trials_says_that_it_takes_the_place_of_an_earlier_one(small, config, capsys):
    run_config(config(), out=small, overrides=["trials=6"], workers=1)
    assert "held a run of other trials" not in capsys.readouterr().err
    run_config(config(), out=small, overrides=["seed=8"], workers=1)
    assert "held a run of other trials; its cells are kept" in capsys.readouterr().err


def test_failed_trials_are_counted_and_the_rest_stands(small_run, config, tmp_path, monkeypatch):
    def unlucky(_: GaussianNoise, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        if rng.random() < 0.5:
            raise RuntimeError("no luck")
        return mesh

    monkeypatch.setattr(GaussianNoise, "__call__", unlucky)
    outcome = run_config(config(), out=tmp_path / "run", workers=1)
    table = detection(outcome.directory)
    failed = table["failed"]["gaussian-noise 0.6 rms-vector"]
    assert outcome.failed == failed == table["failed"].sum()
    assert 0 < failed < 4
    untouched = ["clean", "similarity"]
    assert table.loc[untouched].equals(detection(small_run).loc[untouched])


def test_what_an_unforeseen_error_spoiled_is_run_again_and_what_was_refused_is_not(
    small_run, config, tmp_path, monkeypatch, capsys
):
    full, refused = tmp_path / "full", []
    noise = GaussianNoise.__call__

    def on_full_disk(attack: GaussianNoise, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        if full.exists():
            raise OSError(errno.ENOSPC, "No space left on device")
        return noise(attack, mesh, rng)

    def refusing(_: Similarity, mesh: Mesh, __: np.random.Generator) -> Mesh:
        refused.append(mesh)
        raise Wm3dError("one: cannot be turned.")

    monkeypatch.setattr(GaussianNoise, "__call__", on_full_disk)
    monkeypatch.setattr(Similarity, "__call__", refusing)
    full.touch()
    path, again = config("false_alarm_trials: 1000"), {"out": tmp_path / "run", "workers": 1}
    assert run_config(path, **again).failed == 8
    full.unlink()
    refused.clear()
    assert run_config(path, **again).failed == 4
    assert "6 of 9 cells are there already." in capsys.readouterr().err  # two blocks and a curve are not
    assert refused == []
    healed = "gaussian-noise 0.6 rms-vector"
    assert detection(tmp_path / "run").loc[healed].equals(detection(small_run).loc[healed])
    curves = pd.read_csv(tmp_path / "run" / "tables" / "false_alarms.csv")
    assert set(curves["attack"]) == {"clean", healed}
    assert run_config(path, **again).failed == 4
    assert "9 of 9 cells are there already." in capsys.readouterr().err


def test_a_cell_for_which_memory_ran_out_is_named_and_run_again(
    small_run, config, tmp_path, monkeypatch, capsys
):
    def starving(*_: object) -> None:
        raise MemoryError

    path, again = config(), {"out": tmp_path / "run", "workers": 1}
    with monkeypatch.context() as patched:
        patched.setattr(GaussianNoise, "__call__", starving)
        outcome = run_config(path, **again)
        two = "attacks=[{name: clean}, {name: gaussian-noise, percent: 0.6}]"
        run_config(path, out=tmp_path / "two", workers=1, overrides=[two])
    assert outcome.failed == 4
    page = (tmp_path / "two" / "report.html").read_text(encoding="utf-8")
    assert "the mark survives" in page
    assert "Nothing that was tried removes it" not in page  # for of the noise nothing is known
    told = capsys.readouterr().err
    assert "gaussian-noise 0.6 rms-vector: 4 trials are lost, for the worker died or ran out of" in told
    assert json.loads((tmp_path / "run" / "manifest.json").read_text())["lost_trials"] == 4
    starved = detection(tmp_path / "run").loc["gaussian-noise 0.6 rms-vector"]
    assert starved[["trials", "failed"]].tolist() == [0, 4]  # an average must not go without them
    assert math.isnan(starved["pd_1e-06"])
    assert run_config(path, **again).failed == 0
    assert results(tmp_path / "run") == results(small_run)


def test_a_config_is_not_replaced_by_the_config_as_run(config, tmp_path):
    mine = tmp_path / "mine" / "config.yaml"
    mine.parent.mkdir()
    mine.write_bytes(config().read_bytes())
    with pytest.raises(Wm3dError, match="would be replaced by the config as run; choose another --out"):
        run_config(mine, out=mine.parent)
    assert mine.read_bytes() == config().read_bytes()
    assert [file.name for file in mine.parent.iterdir()] == ["config.yaml"]


def test_a_cluster_that_does_not_answer_costs_no_earlier_report(small, config):
    pytest.importorskip("distributed")
    before = results(small)
    with pytest.raises(Wm3dError, match="no scheduler answers"):
        run_config(config(), out=small, overrides=["trials=6"], dask="tcp://127.0.0.1:1")
    assert results(small) == before


def test_a_mesh_beside_the_config_is_told_from_where_paths_are_read(config, tmp_path):
    path = config()
    (path.parent / "mine.ply").touch()
    with pytest.raises(
        Wm3dError, match=r"mine\.ply: no such file\. Paths are relative to the folder that the comm"
    ):
        run_config(path, out=tmp_path / "run", overrides=["cases.0.meshes=[mine.ply]"])


def test_bad_input_leaves_no_directory(config, tmp_path):
    with pytest.raises(
        Wm3dError, match=r"(?s)^\S*: 2 faults:\n  unknown mesh 'bunnny'.*\n  unknown mesh 'cat'"
    ):
        run_config(config(), out=tmp_path / "run", overrides=["cases.0.meshes=[bunnny, cat]"])
    with pytest.raises(Wm3dError, match="unknown mesh 'horsee'"):
        run_config(config(), out=tmp_path / "run", overrides=["cross_meshes=[horsee]"])
    assert not (tmp_path / "run").exists()
