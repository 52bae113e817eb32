"""Tables: pure functions of rows, also of few rows and of none."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm, ttest_1samp

from wm3d.bench.columns import FALSE_ALARMS, TRIALS
from wm3d.bench.summary import BEYOND, FAILED, FOUND, GONE, REFUSED, refusals, verdict
from wm3d.bench.tables import NULL_LEVEL, all_tables, counted, detection, nulls, swept
from wm3d.stats import clopper_pearson

PF = (1e-3, 1e-6)


def frame(z, hypothesis="H1", attack="clean", **columns) -> pd.DataFrame:
    """Rows of one attack with Gaussian p-values; NaN is a failed trial."""
    z = np.asarray(z, float)
    values = {name: ["" if kind == "str" else 0] * len(z) for name, kind in TRIALS.items()}
    values |= {"mesh": "m", "scheme": "s", "attack": attack, "hypothesis": hypothesis, "subject": "m"}
    values |= {"z": z, "log10_p": norm.logsf(z) / np.log(10), "trial": range(len(z)), **columns}
    values["error"] = np.where(np.isnan(z), "failed", "")
    return pd.DataFrame(values).astype(TRIALS)


def curve(counts, keys=1000, attack="clean") -> pd.DataFrame:
    """Monte Carlo rows at z = 0, 1, 2, ..."""
    z = np.arange(len(counts))
    band = clopper_pearson(counts, keys)
    values = {"mesh": "m", "scheme": "s", "scheme_parameters": "", "attack": attack, "attack_parameters": ""}
    values |= {"z": z, "exceedances": counts, "keys": keys, "pf_low": band.low, "pf_high": band.high}
    return pd.DataFrame({**values, "log10_p": norm.logsf(z) / np.log(10)}).astype(FALSE_ALARMS)


NO_CURVE = curve([])


def test_pd_is_the_share_of_trials_whose_p_reaches_pf():
    rows = frame([3.0, 3.0, 5.0, 0.0], log10_p=[-3.0, -2.999, -7.0, -0.3])
    (line,) = detection(rows, PF).to_dict("records")
    assert line["pd_0.001"] == 0.5  # the first trial lies on the threshold and counts
    assert line["pd_1e-06"] == 0.25
    low, high = clopper_pearson(1, 4)
    assert (line["pd_1e-06_low"], line["pd_1e-06_high"]) == (low, high)
    assert line["trials"] == 4


def test_a_pf_that_no_key_of_so_few_signs_reaches_is_no_loss():
    few, many, none = frame([3.5, 4.0]), frame([3.5, 4.0]), frame([np.nan])
    few["log10_p_least"], many["log10_p_least"], none["log10_p_least"] = -16 * np.log10(2), -1900.0, np.nan
    for rows, pf, word in (
        (few, 1e-6, BEYOND),
        (few, 1e-3, FOUND),
        (many, 1e-6, GONE),
        (none, 1e-6, FAILED),
    ):
        (line,) = detection(rows, PF).to_dict("records")
        assert verdict(line, pf) == word


def test_a_mesh_that_was_never_marked_is_refused_and_one_that_cannot_be_read_has_lost_its_mark():
    unread = frame([0.0, 0.0], log10_p=0.0)
    refused = frame([0.0, 0.0], log10_p=0.0, snr_db=np.nan)
    unread["error"], refused["error"] = "m: bounds no solid.", "not marked: m: is round."
    for rows, count, word in ((unread, 0, GONE), (refused, 2, REFUSED)):
        (line,) = detection(rows, PF).to_dict("records")
        assert (line["trials"], line["unreadable"], line["refused"]) == (2, 2, count)
        assert np.isnan(line["log10_pf_least"])
        assert verdict(line, 1e-6) == word


def test_a_mesh_of_which_one_key_was_marked_and_its_attack_failed_is_not_refused():
    rows = frame([np.nan, 0.0], log10_p=[np.nan, 0.0], snr_db=[44.0, np.nan])
    rows.loc[1, "error"] = "not marked: m: is round."
    (line,) = detection(rows, PF).to_dict("records")
    assert (line["trials"], line["failed"], line["refused"]) == (1, 1, 1)
    assert verdict(line, 1e-6) == GONE
    assert refusals(rows) == {}
    assert refusals(rows.iloc[1:]) == {("m", "s"): "m: is round."}


def test_pf_in_reach_is_told_by_the_meshes_that_could_be_read():
    rows = frame([0.0, 0.0, 5.0], log10_p=[0.0, 0.0, -7.0], log10_p_least=[0.0, 0.0, -80.0])
    rows.loc[:1, "error"] = "m: bounds no solid."
    (line,) = detection(rows, PF).to_dict("records")
    assert verdict(line, 1e-6) == GONE


def test_d_prime_is_the_mean_of_z_with_the_interval_of_the_t_test():
    z = [3.0, 4.5, 2.0, 7.25]
    (line,) = detection(frame(z), PF).to_dict("records")
    band = ttest_1samp(z, 0).confidence_interval(0.95)
    assert line["d_prime"] == np.mean(z)
    assert (line["d_prime_low"], line["d_prime_high"]) == pytest.approx((band.low, band.high))


def test_bit_errors_have_a_mean_with_an_interval_inside_0_to_1_and_marks_without_bits_have_none():
    rates = [0.0, 0.25, 0.5]
    (line,) = detection(frame([3.0, 2.0, 1.0], bit_error_rate=rates), PF).to_dict("records")
    band = ttest_1samp(rates, 0).confidence_interval(0.95)
    assert line["ber"] == 0.25
    assert (line["ber_low"], line["ber_high"]) == (0.0, pytest.approx(band.high))
    (line,) = detection(frame([3.0, 2.0], bit_error_rate=[np.nan, np.nan]), PF).to_dict("records")
    assert np.isnan([line["ber"], line["ber_low"], line["ber_high"]]).all()


def test_noise_has_its_common_unit_in_a_column_and_what_is_no_noise_has_none():
    rows = pd.concat([frame([1.0]), frame([1.0], attack="noise 0.5")])
    table = detection(rows, PF, {"m": {"noise 0.5": 0.07}, "another mesh": {"clean": 1.0}})
    np.testing.assert_array_equal(table["sigma_percent"], [np.nan, 0.07])


def test_failed_trials_are_counted_and_left_out():
    (line,) = detection(frame([10.0, np.nan, 10.0, np.nan, -1.0]), PF).to_dict("records")
    assert (line["trials"], line["failed"], line["unreadable"]) == (3, 2, 0)
    assert line["pd_0.001"] == pytest.approx(2 / 3)
    assert line["z_mean"] == pytest.approx(19 / 3)


@pytest.mark.parametrize("z", [[np.nan, np.nan], [3.0]], ids=["all failed", "one trial"])
def test_tables_of_next_to_nothing_have_lines_with_gaps(z):
    tables = all_tables(frame(z), PF, NO_CURVE)
    (line,) = tables["detection"].to_dict("records")
    scored = len(z) - int(np.isnan(z).sum())
    assert line["trials"] == scored
    assert line["failed"] == len(z) - scored
    assert np.isnan(line["z_std"])
    if not scored:
        assert np.isnan([line["pd_0.001"], line["d_prime"], line["auc"], line["eer"]]).all()
        assert (line["pd_0.001_low"], line["pd_0.001_high"]) == (0.0, 1.0)


@pytest.mark.parametrize("rows", [frame([]), frame([0.5, 1.0], "H0-unmarked")], ids=["no rows", "no H1"])
def test_tables_without_lines_keep_their_columns(rows):
    full = all_tables(pd.concat([frame([1.0]), frame([1.0], "H0-wrong-key")]), PF, NO_CURVE)
    tables = all_tables(rows, PF, NO_CURVE)
    assert {name: list(table) for name, table in tables.items()} == {n: list(t) for n, t in full.items()}
    assert len(tables["detection"]) == 0


def test_nulls_that_follow_the_key_null_are_told_from_those_that_do_not():
    uniform = (np.arange(500) + 0.5) / 500
    rows = pd.concat(
        [
            frame(norm.isf(uniform), "H0-wrong-key", "exact"),
            frame(norm.isf(uniform) + 0.5, "H0-wrong-key", "shifted"),
            frame(norm.isf(uniform) * 1.3, "H0-unmarked", "wide"),
            frame([0.0, np.nan], "H0-unmarked", "unread", log10_p=[0.0, np.nan]),
            frame([9.0], "H1", "marked"),
        ]
    )
    table = nulls(rows).set_index("attack")
    assert list(table.index) == ["exact", "shifted", "wide", "unread"]
    assert table["verdict"]["exact"] == "follows the key null: KS p = 1, 5 of 500 p ≤ 0.01"
    assert table["verdict"]["shifted"].startswith("departs from the key null: p is too small (KS p = ")
    assert table["verdict"]["wide"].endswith(" of 500 p ≤ 0.01")
    assert table["pf_0.01"].isna().all()  # from 1000 trials on
    assert "departs" in table["verdict"]["wide"]
    assert table["verdict"]["unread"] == "nothing was read"
    assert table["unreadable"]["unread"] == 1
    assert table["trials"]["unread"] == 0


def test_the_verdicts_on_true_nulls_together_hold_their_level():
    # false alarm of this test: NULL_LEVEL, 1 %, for the whole table; the seed is fixed
    rng = np.random.default_rng(5)
    table = nulls(pd.concat([frame(rng.standard_normal(60), "H0-wrong-key", f"a{i}") for i in range(50)]))
    assert NULL_LEVEL == 0.01
    assert table["ks_p"].min() < 0.05  # as one in so many will be
    assert table["verdict"].str.startswith("follows").all()


def test_counted_pf_is_quoted_from_ten_events_on():
    table = counted(curve([500, 160, 10, 9, 0]))
    assert table["pf"].tolist()[:3] == [0.5, 0.16, 0.01]
    assert table[["pf", "pf_low", "pf_high"]].iloc[3:].isna().all(axis=None)
    assert table["exceedances"].tolist() == [500, 160, 10, 9, 0]
    np.testing.assert_allclose(10 ** table["log10_pf_exact"], norm.sf(range(5)))


def test_the_papers_roc_sweeps_one_threshold_over_marked_and_random_keys():
    rows = pd.concat([frame([0.5, 1.0, 1.5, np.nan]), frame([7.0], attack="other")])
    table = swept(rows, curve([500, 160, 20, 9]))
    assert table["z"].tolist() == [0.0, 1.0, 2.0]  # 9 of 1000 may not be quoted
    assert table["pd"].tolist() == [1.0, 2 / 3, 0.0]
    assert table["pf"].tolist() == [0.5, 0.16, 0.02]
    assert set(table["trials"]) == {3}
    assert set(table["attack"]) == {"clean"}


def test_tables_of_false_alarms_appear_only_where_there_are_some():
    assert {"false_alarms", "roc_paper"}.isdisjoint(all_tables(frame([1.0]), PF, NO_CURVE))
    assert {"false_alarms", "roc_paper"} <= all_tables(frame([1.0]), PF, curve([500, 160])).keys()
