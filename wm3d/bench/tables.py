"""Tables of a run: pure functions of its rows, one line for each mesh, scheme and attack."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import kstest

from wm3d.stats import auc, clopper_pearson, d_prime, eer, roc

CELL_KEYS = ["mesh", "scheme", "attack"]
FLIPPED_DEG = 90.0
"""An axis that turned further than this changed its sign."""


def all_tables(rows: pd.DataFrame, pf: Sequence[float]) -> dict[str, pd.DataFrame]:
    """Return every table by file name.

    Parameters
    ----------
    rows : DataFrame
        Rows as `wm3d.bench.trial` makes them, in plan order.
    pf : sequence of float
        False-alarm probabilities at which Pd is quoted.
    """
    return {
        "detection": detection(rows, pf),
        "snr": distortion(rows),
        "axes": axes(rows),
        "nulls": nulls(rows),
        "timing": timing(rows),
    }


def detection(rows: pd.DataFrame, pf: Sequence[float]) -> pd.DataFrame:
    """Pd at each Pf with its 95 % Clopper–Pearson interval, d', AUC and EER, from exact p-values.

    Trials whose attack failed are counted in `failed` and left out; a mesh that cannot be read counts as not
    detected, with p = 1.
    """
    return _table(rows, "H1", lambda group: _detection_row(group, pf))


def _detection_row(group: pd.DataFrame, pf: Sequence[float]) -> dict[str, Any]:
    scored = group[group["log10_p"].notna()]
    z, log10_p = scored["z"].to_numpy(), scored["log10_p"].to_numpy()
    curve = roc(log10_p, np.log10(pf))
    line = {
        "trials": len(scored),
        "failed": len(group) - len(scored),
        "unreadable": int((scored["error"] != "").sum()),
        "faces_out": scored["faces_out"].mean(),
        "z_mean": z.mean() if len(z) else np.nan,
        "z_std": z.std(ddof=1) if len(z) > 1 else np.nan,
        "d_prime": d_prime(z),
        "auc": auc(log10_p),
        "eer": eer(log10_p),
    }
    for value, share, low, high in zip(pf, curve.pd, curve.low, curve.high, strict=True):
        line |= {f"pd_{value:g}": share, f"pd_{value:g}_low": low, f"pd_{value:g}_high": high}
    return line


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

    def line(group: pd.DataFrame) -> dict[str, Any]:
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

    `ks_p` is the p-value of a Kolmogorov–Smirnov test of p against the uniform law; `pf_0.01` the share of
    p ≤ 0.01 with its 95 % interval.
    """

    def line(group: pd.DataFrame) -> dict[str, Any]:
        scored = group[group["log10_p"].notna()]
        z, p = scored["z"].to_numpy(), 10 ** scored["log10_p"].to_numpy()
        alarms = int((p <= 0.01).sum())
        low, high = clopper_pearson(alarms, len(p))
        return {
            "trials": len(p),
            "z_mean": z.mean() if len(z) else np.nan,
            "z_var": z.var(ddof=1) if len(z) > 1 else np.nan,
            "ks_p": kstest(p, "uniform").pvalue if len(p) else np.nan,
            "pf_0.01": alarms / len(p) if len(p) else np.nan,
            "pf_0.01_low": float(low),
            "pf_0.01_high": float(high),
        }

    parts = [
        _table(rows, hypothesis, line).assign(hypothesis=hypothesis)
        for hypothesis in ("H0-wrong-key", "H0-unmarked")
        if (rows["hypothesis"] == hypothesis).any()
    ]
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=CELL_KEYS)


def timing(rows: pd.DataFrame) -> pd.DataFrame:
    """Median seconds of each stage of a trial; the one table that differs from run to run."""
    stages = ["embed_seconds", "attack_seconds", "score_seconds"]
    trials = rows[rows["hypothesis"] == "H1"]
    return trials.groupby(CELL_KEYS, sort=False)[stages].median().reset_index()


def _table(rows: pd.DataFrame, hypothesis: str, line: Any) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {**dict(zip(CELL_KEYS, names, strict=True)), **line(group)}
            for names, group in cells(rows, hypothesis)
        ]
    )


def cells(rows: pd.DataFrame, hypothesis: str) -> Iterator[tuple[tuple[str, str, str], pd.DataFrame]]:
    """Yield (mesh, scheme, attack) and the rows of that hypothesis, in plan order."""
    for names, group in rows[rows["hypothesis"] == hypothesis].groupby(CELL_KEYS, sort=False):
        mesh, scheme, attack = map(str, names)
        yield (mesh, scheme, attack), group
