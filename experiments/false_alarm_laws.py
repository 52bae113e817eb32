"""The computed false-alarm probability beside the true one, for weights that put approximations to the test.

    python experiments/false_alarm_laws.py

Weights are whole numbers, so the law of Σ b w is known to rounding: one convolution with two points a sign.
Each law is asked at thresholds that some sum just reaches, where Pf is about 1e-2, 1e-6 and 1e-12. Writes
results/false_alarms/laws.csv.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import norm

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh import write_together
from wm3d.stats import log10_tail, saddlepoint_log10

LOG10_PF = (-2.0, -6.0, -12.0)
LAWS: dict[str, Callable[[np.random.Generator], IntArray]] = {
    "1000 weights spread evenly": lambda rng: rng.integers(100, 300, 1000),
    "64 weights spread evenly, as of a 64-bit mark": lambda rng: rng.integers(1000, 3000, 64),
    "300 weights of four values": lambda rng: rng.integers(1, 5, 300),
    "1000 weights within 1 %": lambda rng: rng.integers(199, 202, 1000),
    "30 of 330 weights carry nearly all": lambda rng: np.append(np.full(30, 10_000), rng.integers(1, 3, 300)),
    "2 of 300 weights carry half": lambda rng: np.append(rng.integers(100, 300, 298), [3000, 2000]),
}


def true_tail(b: IntArray) -> tuple[IntArray, FloatArray]:
    """Return the sums that signs of whole weights can make, downwards, and P(Σ b w ≥ each)."""
    share = np.ones(1)  # of the sums -Σb, -Σb + 2, ..., of the weights so far
    for weight in b:
        none = np.zeros(weight)
        share = (np.concatenate([share, none]) + np.concatenate([none, share])) / 2
    sums = np.arange(b.sum(), -b.sum() - 1, -2)
    return sums[share[::-1] > 0], np.cumsum(share[::-1])[share[::-1] > 0]


def lines_of(law: str, b: IntArray) -> list[dict[str, object]]:
    """One line for each probability that is asked and that the law comes near."""
    sums, tail = true_tail(b)
    lines = []
    for wanted in LOG10_PF:
        at = int(np.searchsorted(tail, 10.0**wanted, side="right")) - 1
        if at < 0 or tail[at] < 10 ** (wanted - 1):
            continue
        z, truth = float(sums[at] / np.linalg.norm(b)), float(tail[at])
        lines.append(
            {
                "law": law,
                "z": z,
                "log10_pf": np.log10(truth),
                "computed_over_true": 10 ** log10_tail(b, z) / truth,
                "saddlepoint_over_true": 10 ** saddlepoint_log10(b, z) / truth,
                "normal_over_true": norm.sf(z) / truth,
            }
        )
    return lines


def main(seed: int, out: Path) -> None:
    rng = np.random.default_rng(seed)
    table = pd.DataFrame([line for law, draw in LAWS.items() for line in lines_of(law, draw(rng))])
    print(table.to_string(index=False, float_format="%.4f"))
    out.mkdir(parents=True, exist_ok=True)
    write_together({out / "laws.csv": table.to_csv(index=False, float_format="%.6g").encode()})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--out", type=Path, default=Path("results/false_alarms"))
    main(**vars(parser.parse_args()))
