"""Calibration: every scheme meets the budget on every mesh, once; one that cannot is left out and said."""

import errno
import json
import shutil
from pathlib import Path

import pandas as pd
import pytest
from shapes import blob

from wm3d.attacks import Clean
from wm3d.bench import Experiment, load_experiment, run_config, write_report
from wm3d.bench.columns import TRY_AGAIN
from wm3d.bench.plan import CalibrationCell, Task, calibrations, plan
from wm3d.bench.store import FIGURES, TABLES, report_files
from wm3d.bench.summary import print_summary
from wm3d.bench.trial import run_task
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, load_mesh, save_mesh
from wm3d.metrics import Budget
from wm3d.schemes import Song2002
from wm3d.schemes.cho2007 import Cho2007Variance

CONFIG = """\
name: fair
trials: 2
block: 1
wrong_keys: 0
calibrate:
  - {{metric: snr, value: 45}}
  - {{metric: mrms, value: 0.3}}
cases:
  - meshes: [{mesh}]
    schemes:
      - {{name: song2002, grid: [24, 24], region: [4, 0, 16, 24]}}
      - {{name: cho2007-variance}}
attacks: [{{name: clean}}, {{name: similarity}}]
"""
SONG, VARIANCE = "song2002 grid=24×24 region=4,0,16,24", "cho2007-variance"


@pytest.fixture(scope="module")
def fair(tmp_path_factory: pytest.TempPathFactory, blobs: Path) -> Path:
    """Run directory of `CONFIG`."""
    folder = tmp_path_factory.mktemp("fair")
    (folder / "fair.yaml").write_text(CONFIG.format(mesh=blobs / "one.ply"))
    return run_config(folder / "fair.yaml", out=folder / "run", workers=1).directory


def calibration(run: Path) -> pd.DataFrame:
    return pd.read_csv(run / "tables" / "calibration.csv").set_index("scheme")


def test_schemes_of_one_budget_distort_alike_and_are_named_by_it(fair, blobs):
    table = calibration(fair)
    met = table[table["reached"].notna()]
    assert {f"{SONG} at SNR 45 dB", f"{SONG} at MRMS 0.3 %"} <= set(met.index)
    assert met.loc[met["metric"] == "snr", "reached"].tolist() == pytest.approx([45.0], abs=0.01)
    snr = pd.read_csv(fair / "tables" / "snr.csv").set_index("scheme")["snr_db"]
    other_keys = snr[f"{SONG} at SNR 45 dB"]
    assert other_keys == pytest.approx(45.0, abs=0.3)
    rows = pd.read_csv(fair / "tables" / "detection.csv")
    assert set(rows["scheme"]) == set(met.index)
    mesh = load_mesh(blobs / "one.ply")
    strength = met.loc[f"{SONG} at MRMS 0.3 %", "strength"]
    scheme = Song2002(grid=(24, 24), region=(4, 0, 16, 24), alpha=strength)
    marked, _ = scheme.embed(mesh, 99)
    assert Budget(metric="mrms", value=0.3).measured(mesh, marked) == pytest.approx(0.3, rel=0.1)


def test_a_scheme_that_cannot_meet_the_budget_is_left_out_and_report_and_terminal_say_so(fair, capsys):
    left_out = calibration(fair)["error"].dropna()
    assert len(left_out)
    assert all(scheme.startswith(VARIANCE) for scheme in left_out.index)
    page = (fair / "report.html").read_text()
    for sentence in left_out:
        assert "cannot be set to an " in sentence
        assert sentence.rpartition(": ")[2].rstrip(".") in page
    report = write_report(fair)
    print_summary(report.tables, fair, report.refused, report.pf)
    said = capsys.readouterr().out
    for scheme, sentence in left_out.items():
        assert f"Left out: {scheme}: {sentence}" in said


def test_a_run_that_goes_on_calibrates_nothing_again(fair, monkeypatch):
    before = {file.name: file.stat().st_mtime_ns for file in (fair / "cells").iterdir()}
    monkeypatch.setattr(Song2002, "at_distortion", None)  # calling it would fail
    monkeypatch.setattr(Cho2007Variance, "at_distortion", None)
    run_config(fair.parent / "fair.yaml", out=fair, workers=1)
    assert {file.name: file.stat().st_mtime_ns for file in (fair / "cells").iterdir()} == before
    write_report(fair)


@pytest.mark.parametrize(
    ("error", "said", "again"),
    [
        (
            OSError(errno.ENOSPC, "No space left on device"),
            "OSError: [Errno 28] No space left on device",
            True,
        ),
        (Wm3dError("one: has no volume."), "one: has no volume.", None),
    ],
    ids=["unforeseen", "refused"],
)
def test_a_calibration_that_met_an_unforeseen_error_is_to_be_made_again(error, said, again, monkeypatch):
    def failing(*_: object) -> None:
        raise error

    monkeypatch.setattr(Song2002, "at_distortion", failing)
    mesh, budget = blob(seed=1, subdivisions=2), Budget(metric="snr", value=50)
    cell = CalibrationCell(7, "one", mesh.digest(), Song2002(), Clean(), 0, 1, budget=budget)
    frame = run_task({"one": mesh}, Task((cell,)))[cell.digest]
    assert frame["error"][0].startswith(said)
    assert frame.attrs.get(TRY_AGAIN) is again


def test_calibrations_for_which_memory_ran_out_are_to_be_run_again(fair, tmp_path, monkeypatch, capsys):
    def starving(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(Song2002, "at_distortion", starving)
    monkeypatch.setattr(Cho2007Variance, "at_distortion", starving)
    with pytest.raises(Wm3dError, match=r"no scheme could be calibrated; run it again, with fewer --workers"):
        run_config(fair.parent / "fair.yaml", out=tmp_path / "run", workers=1)
    assert ", calibration: 1 trial is lost" in capsys.readouterr().err
    run_config(fair.parent / "fair.yaml", out=tmp_path / "run", workers=1, dry_run=True)
    assert "similarity" in capsys.readouterr().out  # trials are planned, too


def test_no_file_of_an_earlier_report_stays_beside_one_that_lacks_it(fair, tmp_path):
    run = Path(shutil.copytree(fair, tmp_path / "run"))
    old = {file.relative_to(run).as_posix() for file in run.glob("[tf]*/*")}
    assert {"tables/calibration.csv", "figures/quality.svg"} <= old <= report_files(TABLES, FIGURES)
    own = {"notes.txt", "tables/mine.csv", "figures/mine.svg"}
    for name in own:
        (run / name).touch()
    manifest = json.loads((run / "manifest.json").read_text())
    (run / "manifest.json").write_text(json.dumps(manifest | {"calibration_cells": []}))
    tables = write_report(run).tables
    assert "calibration" not in tables
    left = {file.relative_to(run).as_posix() for pattern in ("[tf]*/*", "*.*") for file in run.glob(pattern)}
    expected = own | report_files(tables, ["roc"]) | {"config.yaml", "manifest.json"}
    assert left - {".lock"} == expected


def test_a_run_of_which_no_scheme_can_be_calibrated_gives_the_reasons(tmp_path, monkeypatch):
    def failing(scheme: Song2002, mesh: Mesh, *_: object) -> Song2002:
        raise Wm3dError(f"{mesh.name}: no mark of {scheme.name} can be set to an SNR of 45 dB.")

    monkeypatch.setattr(Song2002, "at_distortion", failing)
    save_mesh(blob(subdivisions=2), tmp_path / "one.ply")
    (tmp_path / "fair.yaml").write_text(CONFIG.format(mesh=tmp_path / "one.ply"))
    overrides = ["cases.0.schemes=[{name: song2002}]", "calibrate={metric: snr, value: 45}"]
    with pytest.raises(Wm3dError) as raised:
        run_config(tmp_path / "fair.yaml", out=tmp_path / "run", workers=1, overrides=overrides)
    said = str(raised.value)
    assert said.startswith(f"{tmp_path / 'run'}: holds no trials, for no scheme could be calibrated;")
    assert said.endswith("\n  song2002 at SNR 45 dB: one: no mark of song2002 can be set to an SNR of 45 dB.")


def test_strength_and_budget_name_the_cells():
    meshes = {"one": blob(seed=1, subdivisions=2)}
    fields = {"name": "e", "trials": 1, "attacks": [Clean()]}

    def cells(alpha: float, *budgets: Budget, strength: float = 2.0) -> list[str]:
        cases = [{"meshes": ["one"], "schemes": [Song2002(alpha=alpha)]}]
        experiment = Experiment(**fields, cases=cases, calibrate=budgets)
        found = {cell.digest: strength for cell in calibrations(experiment, meshes)}
        return [cell.digest for cell in plan(experiment, meshes, found)]

    weak, strong = Budget(metric="snr", value=50), Budget(metric="snr", value=40)
    assert cells(1.0, weak) == cells(3.0, weak)  # the strength of the case is not used
    assert cells(1.0, weak, strength=2.1) != cells(1.0, weak)
    assert cells(1.0, weak, strong)[0] == cells(1.0, weak)[0] != cells(1.0, strong)[0]
    assert cells(2.0) != cells(2.0, weak)  # same strength, another name
    assert cells(1.0, weak, strength=float("nan")) == []


def test_one_budget_may_stand_without_a_list(tmp_path):
    path = tmp_path / "one.yaml"
    text = CONFIG.format(mesh="bunny")
    path.write_text(
        text.replace("calibrate:\n", "calibrate: ").replace("  - {metric: mrms, value: 0.3}\n", "")
    )
    path.write_text(path.read_text().replace("  - {metric: snr", "{metric: snr"))
    assert load_experiment(path).budgets == (Budget(metric="snr", value=45),)


def test_manifest_lists_the_calibrations(fair):
    manifest = json.loads((fair / "manifest.json").read_text())
    assert len(manifest["calibration_cells"]) == 4
    assert not set(manifest["calibration_cells"]) & set(manifest["cells"])
