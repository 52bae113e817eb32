"""Trials: rows equal what the parts give by hand; errors of an attack are rows, not the end of a run."""

from dataclasses import replace
from typing import ClassVar, Literal

import numpy as np
import pytest
from shapes import blob, box

from wm3d.attacks import Chain, Clean, Collusion, GaussianNoise, Reorder, Similarity, Simplify
from wm3d.attacks.base import Attack
from wm3d.bench.columns import FALSE_ALARMS, TRIALS
from wm3d.bench.plan import FalseAlarmCell, Task, TrialCell
from wm3d.bench.seeds import derived_seed, generator
from wm3d.bench.trial import THRESHOLDS, run_task
from wm3d.errors import Wm3dError
from wm3d.metrics import snr
from wm3d.schemes import Song2002
from wm3d.schemes.cho2007 import Cho2007Mean
from wm3d.stats import hadamard_keys, log10_tail

MESHES = {"one": blob(seed=1, subdivisions=4), "two": blob(seed=2, subdivisions=4)}
DIGEST = MESHES["one"].digest()
SCHEME = Song2002(grid=(24, 24), region=(4, 0, 16, 24), alpha=4.0)


def cell(attack, hypothesis="H1", trials=3, wrong_keys=0, other=None) -> TrialCell:
    return TrialCell(7, "one", DIGEST, SCHEME, attack, 0, trials, hypothesis, wrong_keys, other)


def rows(*cells):
    """Rows of the cells run as one task, one frame a cell."""
    found = run_task(MESHES, Task(cells))
    return [found[cell.digest] for cell in cells]


class Counting(Attack):
    """Without randomness; counts how often it is called."""

    name: Literal["counting"] = "counting"
    random: ClassVar[bool] = False
    calls: ClassVar[list[str]] = []

    def __call__(self, mesh, rng):  # noqa: ARG002 (one signature)
        self.calls.append(mesh.name)
        return mesh


class Returning(Attack):
    """Does what a test wants."""

    name: Literal["returning"] = "returning"
    what: str

    def __call__(self, mesh, rng):
        if self.what == "error at times" and rng.random() < 0.5:
            raise RuntimeError("no luck")
        if self.what == "out of memory":
            raise MemoryError
        return {"nothing": None, "a box": box()}.get(self.what, mesh)


def test_a_trial_is_embed_attack_score_with_seeds_from_names():
    attack = GaussianNoise(percent=0.2)
    (frame,) = rows(cell(attack))
    for trial, row in enumerate(frame.to_dict("records")):
        seed = derived_seed(7, DIGEST, trial, "key")
        marked, scheme = SCHEME.embed(MESHES["one"], seed)
        attacked = attack(marked, generator(derived_seed(7, DIGEST, trial, "attack")))
        score = scheme.score(attacked, seed)
        assert (row["statistic"], row["z"], row["log10_p"]) == (score.statistic, score.z, score.log10_p)
        assert row["snr_db"] == snr(MESHES["one"], marked)
        angle = scheme.cylinder(MESHES["one"]).axis_deviation(scheme.cylinder(attacked))
        assert row["axis_deg"] == angle
        assert (row["trial"], row["hypothesis"], row["error"]) == (trial, "H1", "")
        assert row["faces_out"] == len(attacked.faces)
        assert row["seconds"] == row["attack_seconds"] + row["score_seconds"] > 0
    assert list(frame.columns) == list(TRIALS)
    assert {name: str(kind) for name, kind in frame.dtypes.items()} == TRIALS


def test_rows_do_not_depend_on_what_else_is_run():
    cells = [
        cell(Clean(), wrong_keys=2),
        cell(GaussianNoise(), "H0-unmarked"),
        cell(Simplify(), "H0-other-mesh", other=("two", MESHES["two"].digest())),
        cell(Similarity()),
    ]
    measured = [name for name in TRIALS if name.endswith(("seconds", "_mb"))]
    together = rows(*cells)
    for frame, alone in zip(together, (rows(single)[0] for single in cells), strict=True):
        assert frame.drop(columns=measured).equals(alone.drop(columns=measured))


def test_a_similarity_changes_neither_score_nor_axes():
    clean, turned = rows(cell(Clean()), cell(Similarity()))
    np.testing.assert_allclose(turned["z"], clean["z"], rtol=1e-9)
    np.testing.assert_allclose(turned["axis_deg"], clean["axis_deg"], atol=1e-6)


def test_axes_turned_back_by_vertices_in_another_order_have_no_angle():
    noisy = Chain(then=(GaussianNoise(percent=1.0), Similarity()))
    shuffled = Chain(then=(Reorder(), Similarity()))
    in_place, in_another = rows(cell(noisy), cell(shuffled))
    assert (in_place["axis_deg"] < 5).all()
    assert in_another["axis_deg"].isna().all()


def test_wrong_keys_are_scored_on_the_same_attacked_mesh():
    (frame,) = rows(cell(GaussianNoise(), trials=2, wrong_keys=3))
    wrong = frame[frame["hypothesis"] == "H0-wrong-key"]
    assert list(wrong["trial"]) == [0, 1, 2, 3, 4, 5]
    marked, scheme = SCHEME.embed(MESHES["one"], derived_seed(7, DIGEST, 1, "key"))
    attacked = GaussianNoise()(marked, generator(derived_seed(7, DIGEST, 1, "attack")))
    score = scheme.score(attacked, derived_seed(7, DIGEST, 1, "wrong-key-2"))
    np.testing.assert_allclose(
        wrong.iloc[-1][["statistic", "z", "log10_p"]].astype(float),
        [score.statistic, score.z, score.log10_p],
        rtol=1e-12,
    )
    assert (frame["hypothesis"] == "H1").sum() == 2


@pytest.mark.parametrize(
    ("hypothesis", "subject"), [("H0-unmarked", "one"), ("H0-other-mesh", "two")], ids=["unmarked", "other"]
)
def test_the_trials_key_is_looked_for_where_it_never_was(hypothesis, subject):
    other = ("two", MESHES["two"].digest()) if subject == "two" else None
    (frame,) = rows(cell(GaussianNoise(), hypothesis, other=other))
    for trial, row in enumerate(frame.to_dict("records")):
        attacked = GaussianNoise()(MESHES[subject], generator(derived_seed(7, DIGEST, trial, "attack")))
        assert row["z"] == SCHEME.score(attacked, derived_seed(7, DIGEST, trial, "key")).z
        assert (row["subject"], row["mesh"], row["hypothesis"]) == (subject, "one", hypothesis)
    assert frame["snr_db"].isna().all()


def test_an_attack_without_randomness_meets_a_mesh_without_the_mark_only_once():
    Counting.calls.clear()
    other = ("two", MESHES["two"].digest())
    rows(
        cell(Counting()),
        cell(Counting(), "H0-unmarked"),
        cell(Counting(), "H0-other-mesh", other=other),
    )
    assert len(Counting.calls) == 3 + 1 + 1


def test_an_attack_that_raises_at_times_fails_those_trials_alone():
    (frame,) = rows(cell(Returning(what="error at times"), trials=12, wrong_keys=1))
    scores = frame[frame["hypothesis"] == "H1"]
    failed = scores["log10_p"].isna()
    assert 0 < failed.sum() < 12
    assert scores["error"][failed].str.fullmatch(r"RuntimeError: no luck \(test_trial\.py, line \d+\)").all()
    assert set(scores["error"][~failed]) == {""}
    assert scores["snr_db"].notna().all()  # the mark itself is there
    assert (frame["hypothesis"] == "H0-wrong-key").sum() == (~failed).sum()
    (clean,) = rows(cell(Clean(), trials=12))
    assert list(scores["z"][~failed]) == list(clean["z"][~failed.to_numpy()])


def test_an_attack_that_returns_no_mesh_fails():
    (frame,) = rows(cell(Returning(what="nothing"), trials=1))
    assert frame["error"][0].startswith("TypeError: the attack returned NoneType, not Mesh (subjects.py, ")
    assert frame["log10_p"].isna().all()


def test_a_scheme_that_returns_no_scheme_to_read_with_fails(monkeypatch):
    monkeypatch.setattr(Song2002, "embed", lambda _, mesh, *__: mesh)
    (frame,) = rows(cell(Clean(), trials=1))
    assert frame["error"][0].startswith(
        "TypeError: embed returned Mesh, not a marked mesh and the scheme that"
    )


def test_want_of_memory_leaves_out_the_cell_and_no_other():
    starved, clean = cell(Returning(what="out of memory")), cell(Clean())
    found = run_task(MESHES, Task((starved, clean)))
    assert found.keys() == {clean.digest}
    assert (found[clean.digest]["log10_p"] < -3).all()


def test_a_mesh_that_cannot_be_read_is_not_detected():
    (frame,) = rows(cell(Returning(what="a box"), trials=1, wrong_keys=2))
    assert frame["log10_p"].tolist() == [0.0, 0.0, 0.0]
    assert frame["z"].tolist() == [0.0, 0.0, 0.0]
    assert "axes" in frame["error"][0]
    assert frame["error"][1:].tolist() == ["", ""]


def test_a_key_that_a_mesh_cannot_carry_is_not_detected_and_tried_only_once(monkeypatch):
    tried, embed = [], Song2002.embed

    def refusing(scheme, mesh, seed):
        tried.append(seed)
        if len(tried) == 2:
            raise Wm3dError("one: too faint.")
        return embed(scheme, mesh, seed)

    monkeypatch.setattr(Song2002, "embed", refusing)
    noise = GaussianNoise(percent=0.1)
    *marked, unmarked = rows(
        cell(Clean(), wrong_keys=1), cell(noise, wrong_keys=1), cell(noise, "H0-unmarked")
    )
    assert list(unmarked["trial"]) == [0, 2]  # the second key is none
    for frame in marked:
        scores = frame[frame["hypothesis"] == "H1"]
        assert scores["error"].tolist() == ["", "not marked: one: too faint.", ""]
        assert scores["embed_seconds"].isna().tolist() == [False, True, False]
        assert scores["log10_p"].iloc[1] == 0.0 > scores["log10_p"].iloc[[0, 2]].max()
        assert (frame["hypothesis"] == "H0-wrong-key").sum() == 2
    assert len(tried) == 3


def test_a_message_that_a_mesh_cannot_carry_has_half_of_its_bits_wrong():
    refused = TrialCell(7, "box", box().digest(), Cho2007Mean(), Clean(), 0, 1, "H1")
    frame = run_task({"box": box()}, Task((refused,)))[refused.digest]
    assert frame["error"].str.startswith("not marked: box").all()
    assert frame[["bit_error_rate", "log10_p"]].to_numpy().tolist() == [[0.5, 0.0]]


def test_attacks_with_other_marks_get_them_from_the_scheme_under_test():
    alone, mixed = rows(cell(Clean()), cell(Collusion(copies=4)))
    assert set(mixed["error"]) == {""}
    ratio = mixed["z"].mean() / alone["z"].mean()
    assert 0.1 < ratio < 0.6  # a quarter of the mark is left


def test_a_false_alarm_cell_counts_random_keys_on_the_attacked_mesh_of_trial_0():
    keys = 100_000
    monte_carlo = FalseAlarmCell(7, "one", DIGEST, SCHEME, GaussianNoise(), 0, 1, keys)
    (frame,) = rows(monte_carlo)
    marked, scheme = SCHEME.embed(MESHES["one"], derived_seed(7, DIGEST, 0, "key"))
    attacked = GaussianNoise()(marked, generator(derived_seed(7, DIGEST, 0, "attack")))
    b = scheme.evidence(attacked).b
    drawn = hadamard_keys(b, THRESHOLDS, keys, derived_seed(7, DIGEST, 0, "false-alarm"), threads=2)
    assert list(frame["exceedances"]) == list(drawn.counts)
    assert set(frame["keys"]) == {drawn.trials}
    assert list(frame["pf_high"]) == list(drawn.interval().high)
    np.testing.assert_array_equal(frame["log10_p"], log10_tail(b, THRESHOLDS))
    assert {name: str(kind) for name, kind in frame.dtypes.items()} == FALSE_ALARMS
    # false alarm of this check: at most 4 thresholds × 1e-6
    band = drawn.interval(1 - 1e-6)
    at = np.isin(THRESHOLDS, [0.0, 1.0, 2.0, 3.0])
    exact = 10 ** frame["log10_p"].to_numpy()
    assert ((band.low <= exact) & (exact <= band.high))[at].all()


@pytest.mark.parametrize("what", ["nothing", "a box"])
def test_there_is_no_false_alarm_curve_of_a_mesh_that_failed(what):
    monte_carlo = FalseAlarmCell(7, "one", DIGEST, SCHEME, Returning(what=what), 0, 1, 1000)
    (frame,) = rows(monte_carlo)
    assert len(frame) == 0
    assert list(frame.columns) == list(FALSE_ALARMS)


def test_bits_are_counted_where_they_are_a_message_and_every_mesh_has_a_least_p():
    message = replace(cell(Clean()), scheme=Cho2007Mean())
    (of_bits,), (of_mark,) = rows(message), rows(cell(Clean(), wrong_keys=1))
    assert (of_bits["bit_error_rate"] == 0).all()
    assert of_bits["log10_p_least"].tolist() == pytest.approx([-64 * np.log10(2)] * 3)
    assert of_mark["bit_error_rate"].isna().all()
    assert (of_mark["log10_p_least"] < of_mark["log10_p"]).all()
