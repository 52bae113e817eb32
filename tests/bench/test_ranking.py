"""The ranking: means over attacks and meshes, draws of meshes that can be counted by hand."""

import json

import numpy as np
import pandas as pd
import pytest

from wm3d.bench import Experiment
from wm3d.bench.leaderboard import leaderboard
from wm3d.bench.quality import quality_figure
from wm3d.bench.ranking import interval_words, over_meshes, ranking
from wm3d.metrics import Budget

PF = 1e-6
MESHES = ("a", "b", "c")
BUDGET = Budget(metric="snr", value=44)
METHODS = {"song2002": (0.1, 0.4, 1.0), "vertex-ss": (0.0, 0.2, 0.4), "cho2007-mean 64": (1.0, 1.0, np.nan)}
"""Mean Pd of each scheme on the three meshes; the last one could not be calibrated on c."""


def tables(methods=METHODS, meshes=MESHES) -> tuple[pd.DataFrame, ...]:
    """Calibration, detection (two attacks, 0.05 above and below the mean), SNR, times."""
    lines, trials = [], []
    for method, scores in methods.items():
        for mesh, score in zip(meshes, scores, strict=False):
            line = {"mesh": mesh, "scheme": f"{method} at SNR 44 dB", "method": method, "budget": "SNR 44 dB"}
            error = f"{mesh}: cannot" if np.isnan(score) else ""
            lines.append(line | {"strength": np.nan if error else 1.5, "error": error})
            for shift in () if error else (-0.05, 0.05):
                values = {"pd_1e-06": score + shift, "log10_pf_least": -19.3, "ber": np.nan}
                trials.append(line | values)
    detection = pd.DataFrame(trials)
    snr = detection[["scheme"]].assign(snr_db=44.0, min=43.5, max=44.25)
    costs = dict.fromkeys(("embed_seconds", "score_seconds", "embed_mb"), 1.0)
    return pd.DataFrame(lines), detection, snr, detection[["scheme"]].assign(**costs)


def test_score_is_the_mean_over_meshes_with_the_interval_of_all_draws():
    first, second, _ = ranking(*tables(), PF).to_dict("records")
    assert (first["method"], second["method"]) == ("song2002", "vertex-ss")
    assert (first["score"], second["score"]) == (pytest.approx(0.5), pytest.approx(0.2))
    # a draw of three is one mesh throughout in 1 of 27 cases, more than 2.5 %
    assert (first["score_low"], first["score_high"]) == (pytest.approx(0.1), pytest.approx(1.0))
    assert first["survived"] == pytest.approx(1 / 6)  # 1.05 of six


def test_ranks_are_drawn_with_the_same_meshes_for_all():
    first, second, _ = ranking(*tables(), PF).to_dict("records")
    # each mesh has the same order, so every draw has: no overlap, though the intervals of the scores overlap
    assert second["score_high"] > first["score_low"]
    assert (first["rank"], first["rank_low"], first["rank_high"]) == (1, 1, 1)
    assert (second["rank"], second["rank_low"], second["rank_high"]) == (2, 2, 2)
    crossing = ranking(*tables({"x": (1.0, 0.0, 0.5), "y": (0.0, 0.9, 0.5)}), PF)
    assert crossing["rank_low"].tolist() == [1, 1]
    assert crossing["rank_high"].tolist() == [2, 2]


def test_schemes_that_miss_a_mesh_have_a_score_and_no_rank():
    *_, last = ranking(*tables(), PF).to_dict("records")
    assert (last["method"], last["meshes"]) == ("cho2007-mean 64", 2)
    assert last["score"] == pytest.approx(1.0)
    assert np.isnan(last["rank"])


def test_an_attack_that_failed_with_every_key_leaves_no_rank():
    calibration, detection, snr, costs = tables()
    first = detection.index[detection["scheme"] == "song2002 at SNR 44 dB"][0]
    detection.loc[first, "pd_1e-06"] = np.nan
    lines = ranking(calibration, detection, snr, costs, PF).set_index("method")
    assert np.isnan(lines.loc["song2002", "rank"])
    assert lines.loc["song2002", ["meshes", "score"]].tolist() == [2, pytest.approx(0.7)]
    assert lines.loc["vertex-ss", "rank"] == 1


def test_equal_scores_share_a_rank():
    same = ranking(*tables({"x": (0.1, 0.2, 0.4), "y": (0.4, 0.1, 0.2), "z": (0.0, 0.0, 0.0)}), PF)
    assert same["rank"].tolist() == [1, 1, 3]


def test_one_mesh_has_no_interval_and_the_words_say_how_wide_others_are():
    (line,) = ranking(*tables({"x": (0.5,)}, ("a",)), PF).to_dict("records")
    assert np.isnan([line["score_low"], line["score_high"], line["rank_low"], line["rank_high"]]).all()
    assert "no interval" in interval_words(1)
    assert "one draw in 27 " in interval_words(3)
    assert "narrower" in interval_words(4)  # 1 of 256


def test_leaderboard_is_strict_json_with_what_it_was_made_from():
    calibration, *rest = tables()
    ranked = ranking(calibration, *rest, PF)
    schemes = [{"name": name.partition(" ")[0]} for name in METHODS]
    case = {"meshes": list(MESHES), "schemes": schemes}
    experiment = Experiment.model_validate(
        {"name": "e", "trials": 1, "calibrate": BUDGET, "cases": [case], "attacks": [{"name": "clean"}]}
    )
    meshes = {name: {"sha256": name * 64} for name in MESHES}
    manifest = {"versions": {"wm3d": "1"}, "ended": "2002-12-09", "meshes": meshes}
    content = json.loads(leaderboard(experiment, manifest, ranked, calibration, PF))
    assert [entry["rank"] for entry in content["entries"]] == [1, 2, None]
    assert content["entries"][2]["left_out"] == {"c": "c: cannot"}
    assert content["entries"][2]["strengths"] == {"a": 1.5, "b": 1.5}
    assert content["entries"][0]["bit_error_rate"] is None
    assert content["entries"][0]["snr_apart_db"] == 0.75
    assert (content["meshes"]["a"], content["attacks"], content["pf"]) == ("a" * 64, ["clean"], PF)


def test_heat_map_holds_the_mean_over_meshes_of_every_budget_and_scheme():
    calibration, detection, *_ = tables({"x": (0.1, 0.4, 1.0), "y": (0.0, 0.2, np.nan)})
    detection = detection[["mesh", "scheme", "pd_1e-06"]]
    attacked = detection.assign(attack="clean", trials=2, sigma_percent=np.nan, d_prime=3.0)
    table = over_meshes(calibration, attacked, PF)
    assert table[["mesh", "scheme"]].to_numpy().tolist() == [["SNR 44 dB", "x"], ["SNR 44 dB", "y"]]
    assert table["pd_1e-06"].tolist() == pytest.approx([0.5, 0.1])


def test_quality_figure_has_a_line_for_each_scheme_at_its_scores():
    detection = tables()[1].assign(trials=[3, *[5] * (len(tables()[1]) - 1)])
    figure = quality_figure(ranking(*tables(), PF), detection, PF, MESHES, {})
    assert "share of 3 to 5 keys found, each held to Pf by the exact key null" in figure.get_supxlabel()
    left, right = figure.axes
    assert [line.get_ydata().tolist() for line in left.lines] == [
        pytest.approx([0.5]),
        pytest.approx([0.2]),
        pytest.approx([1.0]),
    ]
    assert len(right.lines) == len(METHODS)
