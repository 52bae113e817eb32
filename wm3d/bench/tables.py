"""Tables of a run: pure functions of its rows, one line for each mesh, scheme and attack."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import kstest

from wm3d.stats import auc, clopper_pearson, d_prime, eer, exceedances, quoted, roc, student_t
from wm3d.stats.intervals import QUOTABLE_COUNT

Line = dict[str, Any]

CELL_KEYS = ["mesh", "scheme", "attack"]
Sigmas = Mapping[str, Mapping[str, float]]
"""Noise by mesh and attack: standard deviation of each coordinate in percent of the diagonal."""

FLIPPED_DEG = 90.0
"""An axis that turned further than this changed its sign."""

NULL_PF = 0.01
"""False-alarm probability at which the alarms of true nulls are counted."""

NULL_LEVEL = 0.01
"""Probability that any line of a table of true nulls is called a departure."""


def all_tables(
    rows: pd.DataFrame, pf: Sequence[float], false_alarms: pd.DataFrame, sigmas: Sigmas | None = None
) -> dict[str, pd.DataFrame]:
    """Return every table by file name.

    Parameters
    ----------
    rows : DataFrame
        Scores, with the columns `wm3d.bench.columns.TRIALS`, in plan order.
    pf : sequence of float
        False-alarm probabilities at which Pd is quoted.
    false_alarms : DataFrame
        Monte Carlo curves, with the columns `wm3d.bench.columns.FALSE_ALARMS`; tables of them are made only
        if there are any.
    sigmas : mapping of str to mapping of str to float, optional
        Noise in its common unit, by mesh and label of the attack.
    """
    tables = {
        "detection": detection(rows, pf, sigmas),
        "snr": distortion(rows),
        "axes": axes(rows),
        "nulls": nulls(rows),
        "timing": timing(rows),
    }
    if len(false_alarms):
        tables["false_alarms"] = counted(false_alarms)
        tables["roc_paper"] = swept(rows, false_alarms)
    return tables


def detection(rows: pd.DataFrame, pf: Sequence[float], sigmas: Sigmas | None = None) -> pd.DataFrame:
    """Pd at each Pf with its 95 % Clopper–Pearson interval, d', AUC and EER, from exact p-values.

    The null of z has mean 0 and variance 1 exactly, so d' is the mean of z over keys and its 95 % interval
    that of Student's t. `sigma_percent` is the standard deviation of noise on each coordinate in percent of
    the diagonal of the bounding box, NaN for attacks that are no noise. `log10_pf_least` is the median over
    meshes that could be read of the log10 of the least p-value that any key reaches: no Pd at a smaller Pf
    can be above 0. `ber` is the mean bit error rate of schemes that carry a message, with its 95 % interval
    by Student's t, NaN for others; a mesh that cannot be read has one half of the bits wrong.

    Trials whose attack failed are counted in `failed` and left out; a mesh that the scheme refuses to mark,
    or cannot read, is counted in `unreadable` and as not detected, with p = 1; `refused` of these it refused
    to mark.
    """
    table = _table(rows, "H1", lambda group: _detection_row(group, pf))
    sigma = [
        (sigmas or {}).get(mesh, {}).get(attack, np.nan)
        for mesh, attack in zip(table["mesh"], table["attack"], strict=True)
    ]
    table.insert(len(CELL_KEYS), "sigma_percent", np.array(sigma, np.float64))
    return table


def _detection_row(group: pd.DataFrame, pf: Sequence[float]) -> Line:
    scored = group[group["log10_p"].notna()]
    z, log10_p = scored["z"].to_numpy(), scored["log10_p"].to_numpy()
    unreadable = scored["error"] != ""
    curve, mean = roc(log10_p, np.log10(pf)), student_t(z)
    line = {
        "trials": len(scored),
        "failed": len(group) - len(scored),
        "unreadable": int(unreadable.sum()),
        "refused": int(scored["snr_db"].isna().sum()),
        "faces_out": scored.loc[scored["snr_db"].notna(), "faces_out"].mean(),  # of those that were marked
        "z_mean": z.mean() if len(z) else np.nan,
        "z_std": z.std(ddof=1) if len(z) > 1 else np.nan,
        "d_prime": d_prime(z),
        "d_prime_low": float(mean.low),
        "d_prime_high": float(mean.high),
        "auc": auc(log10_p),
        "eer": eer(log10_p),
        "log10_pf_least": scored.loc[~unreadable, "log10_p_least"].median(),
        **_error_rate(scored["bit_error_rate"].dropna()),
    }
    for value, share, low, high in zip(pf, curve.pd, curve.low, curve.high, strict=True):
        line |= {f"pd_{value:g}": share, f"pd_{value:g}_low": low, f"pd_{value:g}_high": high}
    return line


def _error_rate(rates: "pd.Series[float]") -> Line:
    """Mean bit error rate over keys; the t interval is cut where no rate can be."""
    band = student_t(rates.to_numpy())
    return {
        "ber": rates.mean(),
        "ber_low": np.maximum(band.low, 0.0),
        "ber_high": np.minimum(band.high, 1.0),
    }


def distortion(rows: pd.DataFrame) -> pd.DataFrame:
    """SNR of the marked meshes (eq. 13), over keys."""
    marked = rows[(rows["hypothesis"] == "H1") & rows["snr_db"].notna()]
    marked = marked.drop_duplicates(["mesh", "scheme", "trial"])
    groups = marked.groupby(["mesh", "scheme"], sort=False)["snr_db"]
    return groups.agg(keys="count", snr_db="mean", std="std", min="min", max="max").reset_index()


def axes(rows: pd.DataFrame) -> pd.DataFrame:
    """Angle between the axes of the original and of the marked, attacked mesh, in degrees.

    `flipped` is the share of trials in which an axis changed its sign; the other columns are about the rest.
    """

    def line(group: pd.DataFrame) -> Line:
        degrees = group["axis_deg"].dropna()
        kept = degrees[degrees <= FLIPPED_DEG]
        return {
            "trials": len(degrees),
            "flipped": (degrees > FLIPPED_DEG).mean() if len(degrees) else np.nan,
            "mean_deg": kept.mean(),
            "median_deg": kept.median(),
            "max_deg": kept.max(),
        }

    return _table(rows, "H1", line)


def nulls(rows: pd.DataFrame) -> pd.DataFrame:
    """Whether scores without the mark follow the exact key null: z has mean 0, variance 1, p is uniform.

    `subject` is the mesh that was read. `ks_p` is the p-value of a one-sided Kolmogorov–Smirnov test of p
    against the uniform law, for p that are too small: those of few signs, and of several tries, may be too
    large for many keys. `alarms` is how many p are at most 0.01, `pf_0.01` their share, quoted from 1000
    trials on, with its 95 % interval. The verdict holds both tests of all lines together to `NULL_LEVEL`
    (Bonferroni). Meshes that cannot be read have p = 1 for every key; they are counted in `unreadable` and
    left out.
    """
    keys = [*CELL_KEYS, "hypothesis", "subject"]
    null = rows[rows["hypothesis"] != "H1"]
    lines: list[Line] = [
        dict(zip(keys, map(str, names), strict=True)) | _null_row(group)
        for names, group in null.groupby(keys, sort=False)
    ]
    tests = 2 * sum(line["trials"] > 0 for line in lines)
    for line in lines:
        line["verdict"] = _null_verdict(line, tests)
    return pd.DataFrame(lines, columns=[*keys, *_null_row(null.iloc[:0]), "verdict"])


def _null_row(group: pd.DataFrame) -> Line:
    scored = group[group["log10_p"].notna()]
    read = scored[(scored["z"] != 0) | (scored["log10_p"] != 0)]  # without evidence z = 0 and p = 1
    z, p = read["z"].to_numpy(), 10 ** read["log10_p"].to_numpy()
    alarms = int((p <= NULL_PF).sum())
    band = clopper_pearson(alarms, len(p))
    return {
        "trials": len(p),
        "unreadable": len(scored) - len(read),
        "z_mean": z.mean() if len(z) else np.nan,
        "z_var": z.var(ddof=1) if len(z) > 1 else np.nan,
        "ks_p": kstest(p, "uniform", alternative="greater").pvalue if len(p) else np.nan,
        "alarms": alarms,
        f"pf_{NULL_PF}": alarms / len(p) if len(p) >= QUOTABLE_COUNT / NULL_PF else np.nan,
        f"pf_{NULL_PF}_low": float(band.low),
        f"pf_{NULL_PF}_high": float(band.high),
    }


def _null_verdict(line: Line, tests: int) -> str:
    trials = int(line["trials"])
    if trials == 0:
        return "nothing was read"
    level = NULL_LEVEL / tests
    band = clopper_pearson(line["alarms"], trials, 1 - 2 * level)
    count = f"{line['alarms']} of {trials} p ≤ {NULL_PF}"
    faults = []
    if line["ks_p"] < level:
        faults.append(f"p is too small (KS p = {line['ks_p']:.1e})")
    if band.low > NULL_PF:
        faults.append(count)
    if faults:
        return "departs from the key null: " + " and ".join(faults)
    return f"follows the key null: KS p = {line['ks_p']:.2g}, {count}"


def counted(false_alarms: pd.DataFrame) -> pd.DataFrame:
    """Put the false alarms of random keys beside the exact tail, threshold by threshold.

    `pf` with its 95 % interval is quoted only from 10/Pf keys; `log10_pf_exact` is log10 of the exact tail.
    """
    table = false_alarms[[*CELL_KEYS, "z", "keys", "exceedances"]].copy()
    table["pf"] = quoted(table["exceedances"], table["keys"])
    for end in ("pf_low", "pf_high"):
        table[end] = false_alarms[end].where(table["pf"].notna())
    return table.assign(log10_pf_exact=false_alarms["log10_p"])


def swept(rows: pd.DataFrame, false_alarms: pd.DataFrame) -> pd.DataFrame:
    """ROC as the paper made it: one threshold on z for all trials, Pf by counting, Pd from the marked trials.

    Only thresholds whose Pf may be quoted, that is from 10/Pf keys. Pf was counted on the mesh of one trial,
    for the reading that the detector chose there: where it chose among several (`RademacherSum.tries`), the
    Pf of the detector is up to as many times that. `detection` takes that into account.
    """
    table = counted(false_alarms).dropna(subset="pf").drop(columns=["exceedances", "log10_pf_exact"])
    parts = []
    for names, group in cells(rows, "H1"):
        z = group["z"].dropna()
        curve = table[(table[CELL_KEYS] == list(names)).all(axis=1)]
        hits = exceedances(z, curve["z"])
        band = clopper_pearson(hits, len(z))
        share = hits / len(z) if len(z) else np.nan
        parts.append(curve.assign(trials=len(z), pd=share, pd_low=band.low, pd_high=band.high))
    return pd.concat(parts, ignore_index=True) if parts else table


def timing(rows: pd.DataFrame) -> pd.DataFrame:
    """Median seconds of the stages, most MB of embedding; with them, and those of a ranking, runs differ."""
    stages = ["embed_seconds", "attack_seconds", "score_seconds"]
    trials = rows[rows["hypothesis"] == "H1"]
    columns = dict.fromkeys(stages, "median") | {"embed_mb": "max"}
    return trials.groupby(CELL_KEYS, sort=False).agg(columns).reset_index()


def _table(rows: pd.DataFrame, hypothesis: str, line: Callable[[pd.DataFrame], Line]) -> pd.DataFrame:
    lines = [
        {**dict(zip(CELL_KEYS, names, strict=True)), **line(group)}
        for names, group in cells(rows, hypothesis)
    ]
    return pd.DataFrame(lines, columns=[*CELL_KEYS, *line(rows.iloc[:0])])


def cells(rows: pd.DataFrame, hypothesis: str) -> Iterator[tuple[tuple[str, str, str], pd.DataFrame]]:
    """Yield (mesh, scheme, attack) and the rows of that hypothesis, in plan order."""
    for names, group in rows[rows["hypothesis"] == hypothesis].groupby(CELL_KEYS, sort=False):
        mesh, scheme, attack = map(str, names)
        yield (mesh, scheme, attack), group
