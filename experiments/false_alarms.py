"""Four ways to the false-alarm probability of one detector on one marked mesh, on one figure.

    python experiments/false_alarms.py

The mesh under test fixes the weights b of the statistic; the null is a uniform key on that mesh. Writes
results/false_alarms/false_alarms.png, .svg and .csv. The paper iterated its extraction up to 10⁸ times and
could say nothing of Pf below 10⁻⁸; the tail goes on.
"""

import argparse
import io
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import norm

import wm3d
from wm3d.bench.figures import STYLE
from wm3d.mesh import datasets, write_together
from wm3d.stats import (
    Exceedances,
    hadamard_keys,
    hoeffding_log10,
    importance_sampling,
    independent_keys,
    log10_tail,
    z_at,
)

LOG10_PF = -np.arange(1.0, 21.0)  # where the Monte Carlo ways are asked
PAPER_LOG10_PF = -8.0
INDEPENDENT, HADAMARD, IMPORTANCE = "independent keys", "Hadamard keys", "importance sampling"
LOOKS = {  # color, marker, its size, shift in z so that bars do not overlap
    INDEPENDENT: ("C1", "s", 9, -0.05),
    HADAMARD: ("C0", "o", 6, 0.0),
    IMPORTANCE: ("C2", ".", 4, 0.05),
}


def main(mesh: str, seed: int, hadamard: int, independent: int, threads: int, out: Path) -> None:
    marked, key = wm3d.embed(datasets.resolve(mesh), seed=seed)
    score = wm3d.detect(marked, key)
    b = score.null.b
    z = np.array([z_at(b, log10_pf) for log10_pf in LOG10_PF])

    table = pd.concat(
        [
            counted(independent_keys(b, z, independent, seed), b),
            counted(hadamard_keys(b, z, hadamard, seed, threads), b),
            sampled(b, z, seed),
        ]
    )
    table["events"] = table["events"].astype("Int64")
    print(f"{mesh}, seed {seed}: z = {score.z:.2f}, log10 p = {score.log10_p:.1f}")
    print(table.to_string(index=False, float_format="%.4f"))

    figure = draw(b, table, f"{key.scheme.label()} on {mesh}, {np.count_nonzero(b)} signs read")
    contents = {out / "false_alarms.csv": table.to_csv(index=False, float_format="%.6g").encode()}
    for ending, metadata in (("png", {"Software": None}), ("svg", {"Date": None, "Creator": None})):
        buffer = io.BytesIO()
        with mpl.rc_context(STYLE):
            figure.savefig(buffer, format=ending, metadata=metadata)
        contents[out / f"false_alarms.{ending}"] = buffer.getvalue()
    out.mkdir(parents=True, exist_ok=True)
    write_together(contents)


def counted(run: Exceedances, b: np.ndarray) -> pd.DataFrame:
    """One line for each threshold whose count may be quoted."""
    low, high = run.interval()
    lines = pd.DataFrame(
        {
            "method": run.method,
            "z": run.z,
            "log10_pf": np.log10(run.quoted_pf),
            "log10_low": np.log10(low, out=np.full(low.shape, -np.inf), where=low > 0),
            "log10_high": np.log10(high),
            "log10_tail": log10_tail(b, run.z),
            "log10_hoeffding": hoeffding_log10(b, run.z),
            "keys": run.trials,
            "events": run.counts,
        }
    )
    return lines[lines["log10_pf"].notna()]


def sampled(b: np.ndarray, z: np.ndarray, seed: int) -> pd.DataFrame:
    """One line for each threshold, by importance sampling at 2 % relative error."""
    lines = []
    for i, threshold in enumerate(z):  # a seed each: shared draws would make the points err together
        estimate = importance_sampling(b, float(threshold), seed=seed + i)
        low, high = estimate.log10_interval()
        lines.append(
            {
                "method": IMPORTANCE,
                "z": threshold,
                "log10_pf": estimate.log10_pf,
                "log10_low": low,
                "log10_high": high,
                "log10_tail": log10_tail(b, float(threshold)),
                "log10_hoeffding": hoeffding_log10(b, float(threshold)),
                "keys": estimate.trials,
                "events": pd.NA,
            }
        )
    return pd.DataFrame(lines)


def draw(b: np.ndarray, table: pd.DataFrame, title: str) -> Figure:
    """Log10 Pf against z, and below it each estimate over the computed tail."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 7.2), layout="constrained")
        tail, ratio = figure.subplots(2, 1, sharex=True, height_ratios=[2.2, 1])
        z = np.linspace(0, table["z"].max() + 0.3, 300)
        tail.plot(z, log10_tail(b, z), "k-", linewidth=1.2, label="computed tail")
        tail.plot(z, hoeffding_log10(b, z), "k:", linewidth=1.2, label="Hoeffding's bound")
        ratio.plot(z, np.ones_like(z), "k-", linewidth=1.2)
        normal = 10 ** (norm.logsf(z) / np.log(10) - log10_tail(b, z))
        ratio.plot(z, normal, "--", color="0.5", linewidth=1, label="normal law Q(z)")
        for method, lines in table.groupby("method", sort=False):
            points(tail, ratio, str(method), lines)
        tail.axhline(PAPER_LOG10_PF, color="0.5", linewidth=0.8)
        tail.annotate(
            "10⁸ keys: the paper counted down to here", (0.1, PAPER_LOG10_PF + 0.2), color="0.3", fontsize=8
        )
        tail.set(title=title, ylabel="log10 Pf", ylim=(-21, 0.5), yticks=np.arange(-20, 1, 2))
        tail.legend(loc="lower left")
        ratio.set(xlabel="threshold z", ylabel="Pf / computed", yscale="log", ylim=(0.5, 2), xlim=(0, z[-1]))
        ratio.set_yticks([0.5, 0.7, 1, 1.4, 2], ["0.5", "0.7", "1", "1.4", "2"])
        ratio.set_yticks([], minor=True)
        ratio.legend(loc="upper left")
        figure.supxlabel(
            "Statistic: z = Σ b w / √(Σ b²), b from the detector on the marked mesh. Null: uniform keys w.\n"
            "Bars: 95 %; Clopper–Pearson for independent keys, Korn–Graubard over transforms for Hadamard\n"
            "keys, normal law of the mean for importance sampling. Counts are shown from 10/Pf keys on.",
            fontsize=7,
            x=0.0,
            ha="left",
        )
    return figure


def points(tail: Axes, ratio: Axes, method: str, lines: pd.DataFrame) -> None:
    color, marker, size, shift = LOOKS[method]
    keys = f"{lines['keys'].max():.2g}".replace("e+0", "e")
    label = f"{method}, {keys} keys" + (" a point at most" if method == IMPORTANCE else "")
    style = {"color": color, "marker": marker, "linestyle": "none"}
    tail.plot(lines["z"], lines["log10_pf"], label=label, markersize=size, fillstyle="none", **style)
    estimate, low, high = (
        10 ** (lines[name] - lines["log10_tail"]) for name in ("log10_pf", "log10_low", "log10_high")
    )
    bars = [estimate - low, high - estimate]
    ratio.errorbar(lines["z"] + shift, estimate, yerr=bars, elinewidth=0.9, markersize=4, **style)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--mesh", default="bunny", help="name of a dataset, or a mesh file")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--hadamard", type=int, default=10**9, help="Hadamard keys")
    parser.add_argument("--independent", type=int, default=10**5, help="independent keys")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("results/false_alarms"))
    main(**vars(parser.parse_args()))
