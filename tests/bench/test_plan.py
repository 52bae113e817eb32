"""The plan: a cell's name changes with all that its numbers depend on, and with nothing else."""

from dataclasses import replace
from typing import ClassVar

import pytest
from shapes import blob

from wm3d.attacks import Clean, GaussianNoise, Similarity, Simplify
from wm3d.bench import Experiment
from wm3d.bench.plan import FalseAlarmCell, TrialCell, plan, tasks
from wm3d.errors import Wm3dError
from wm3d.schemes import Song2002

MESHES = {"one": blob(seed=1, subdivisions=2), "two": blob(seed=2, subdivisions=2)}
WEAK, STRONG = Song2002(alpha=0.9), Song2002(alpha=1.3)


def experiment(**changes) -> Experiment:
    fields = {
        "name": "e",
        "trials": 10,
        "block": 4,
        "cases": [{"meshes": ["one", "two"], "schemes": [WEAK, STRONG]}],
        "attacks": [Clean(), GaussianNoise()],
    }
    return Experiment(**{**fields, **changes})


def digests(meshes=MESHES, **changes) -> set[str]:
    return {cell.digest for cell in plan(experiment(**changes), meshes)}


def test_every_mesh_scheme_attack_and_block_has_a_cell():
    cells = plan(experiment(), MESHES)
    assert len(cells) == 2 * 2 * 2 * 3
    assert {(cell.start, cell.stop) for cell in cells} == {(0, 4), (4, 8), (8, 10)}
    assert sum(cell.trials for cell in cells) == 2 * 2 * 2 * 10


def test_an_engine_that_is_not_installed_is_told_with_what_needs_it():
    class Meshed(GaussianNoise):
        engines: ClassVar[tuple[str, ...]] = ("no-such-engine",)

    cell = TrialCell(0, "one", "digest", WEAK, Meshed(), 0, 1, "H1")
    with pytest.raises(Wm3dError, match=r"^gaussian-noise .*: its engine 'no-such-engine' is not installed;"):
        cell.digest  # noqa: B018 (the access is the test)


def test_words_that_change_no_number_change_no_cell():
    assert digests(name="other", title="other", pf=[0.5]) == digests()


def test_added_attacks_schemes_meshes_nulls_and_blocks_leave_the_cells_as_they_are():
    before = digests()
    for more in (
        {"attacks": [Simplify(), Clean(), GaussianNoise()]},
        {"cases": [{"meshes": ["two", "one"], "schemes": [Song2002(alpha=2.0), WEAK, STRONG]}]},
        {"unmarked": True},
        {"cross_meshes": ["one"]},
        {"false_alarm_trials": 1000},
    ):
        assert before < digests(**more)
    whole = {cell.digest for cell in plan(experiment(), MESHES) if cell.stop <= 8}
    assert whole < digests(trials=30)


def test_a_changed_parameter_changes_only_the_cells_that_depend_on_it():
    kept = {cell.digest for cell in plan(experiment(), MESHES) if cell.scheme == WEAK}
    changed = digests(cases=[{"meshes": ["one", "two"], "schemes": [WEAK, Song2002(alpha=1.4)]}])
    assert digests() & changed == kept


@pytest.mark.parametrize("change", [{"seed": 1}, {"wrong_keys": 1}, {"block": 3, "trials": 9}])
def test_seed_wrong_keys_and_blocks_change_every_cell(change):
    assert not digests(**change) & digests()


def test_mesh_bytes_and_engine_versions_change_the_cells_that_use_them(monkeypatch):
    moved = {**MESHES, "one": blob(seed=3, subdivisions=2)}
    of_two = {cell.digest for cell in plan(experiment(), MESHES) if cell.mesh == "two"}
    assert digests() & digests(moved) == of_two
    attacks = {"attacks": [Clean(), Simplify()]}
    without = {cell.digest for cell in plan(experiment(**attacks), MESHES) if cell.attack == Clean()}
    before = digests(**attacks)
    monkeypatch.setattr("wm3d.component.version", lambda package: f"another {package}")
    assert before & digests(**attacks) == without
    monkeypatch.undo()
    monkeypatch.setattr(GaussianNoise, "version", 99)
    assert digests() & digests(attacks=[Clean()]) == digests(attacks=[Clean()])
    assert len(digests() - before) == len(digests()) // 2


def test_what_is_named_twice_is_run_once():
    case = {"meshes": ["one", "one"], "schemes": [WEAK]}
    assert digests(cases=[case, case]) == digests(cases=[{"meshes": ["one"], "schemes": [WEAK]}])


def test_other_meshes_are_all_but_the_marked_one():
    cells = plan(experiment(cross_meshes=["one", "two"]), MESHES)
    crossed = {(cell.mesh, cell.subject[0]) for cell in cells if cell.hypothesis == "H0-other-mesh"}
    assert crossed == {("one", "two"), ("two", "one")}


def test_a_false_alarm_cell_stands_for_each_mesh_scheme_and_attack():
    cells = [cell for cell in plan(experiment(false_alarm_trials=9), MESHES) if cell.kind == "false-alarms"]
    assert len(cells) == 2 * 2 * 2
    assert {(cell.start, cell.stop, cell.keys) for cell in cells} == {(0, 1, 9)}


def test_a_task_holds_the_cells_that_share_their_marked_meshes():
    cells = plan(experiment(unmarked=True, cross_meshes=["two"]), MESHES)
    grouped = tasks(cells)
    assert len(grouped) == 2 * 2 * 3  # meshes, schemes, blocks
    assert sorted(cell.digest for task in grouped for cell in task.cells) == sorted(c.digest for c in cells)
    first = grouped[0]
    assert first.meshes == {"one", "two"}
    assert [part.cells for part in first.split()] == [(cell,) for cell in first.cells]


def test_kinds_and_hypotheses_never_share_a_name():
    block = (1, "one", "d", WEAK, Similarity(), 0, 1)
    cells = [
        TrialCell(*block, "H1", 3),
        TrialCell(*block, "H0-unmarked", 3),
        TrialCell(*block, "H0-other-mesh", 3, ("two", "e")),
        TrialCell(*block, "H0-other-mesh", 3, ("two", "f")),
        FalseAlarmCell(*block, 3),
        FalseAlarmCell(*block, 4),
    ]
    assert len({cell.digest for cell in cells}) == len(cells)
    assert replace(cells[0]).digest == cells[0].digest
