"""Count false alarms over 10⁸ Hadamard keys, and print how much faster that is than a numpy loop over keys.

    python experiments/false_alarm_speed.py

Both ways score keys of 6300 signs on the same statistic in the same run. The loop draws one key and takes one
dot product at a time, on one core, as the paper's extraction had to; the Hadamard keys use `--threads` cores.
"""

import argparse
import time

import numpy as np

from wm3d.stats import hadamard_keys, log10_tail, z_at

SIGNS = 6300  # 100 blocks of 63 AC coefficients
LOG10_PF = np.arange(-2.0, -9.0, -1.0)


def main(trials: int, loop_trials: int, threads: int) -> None:
    rng = np.random.default_rng(0)
    b = rng.gamma(0.7, 1.0, SIGNS)
    z = np.array([z_at(b, log10_pf) for log10_pf in LOG10_PF])

    hadamard_keys(b, z, trials=1)  # compiles
    start = time.perf_counter()
    run = hadamard_keys(b, z, trials=trials, threads=threads)
    hadamard_rate = run.trials / (elapsed := time.perf_counter() - start)

    limit = z[0] * np.linalg.norm(b)
    start = time.perf_counter()
    hits = 0
    for _ in range(loop_trials):
        w = 2.0 * rng.integers(0, 2, SIGNS, dtype=np.int8) - 1.0  # faster than rng.choice
        hits += b @ w >= limit
    loop_rate = loop_trials / (time.perf_counter() - start)

    print(f"{SIGNS} signs; null: uniform keys; statistic: sum b w / sqrt(sum b^2)")
    print(
        f"Hadamard keys: {run.trials} in {elapsed:.3f} s on {threads} threads, {hadamard_rate:.3g} a second"
    )
    print(f"numpy loop:    {loop_trials} keys, {loop_rate:.3g} a second, {hits / loop_trials:.4f} above z[0]")
    print(f"ratio of the rates: {hadamard_rate / loop_rate:.0f}\n")
    print("    z    exact Pf    counted  estimate    95 % interval")
    low, high = run.interval()
    for i, exact in enumerate(10.0 ** log10_tail(b, z)):
        print(f"{z[i]:.4f}  {exact:.3e}  {run.counts[i]:8d}  {run.pf[i]:.3e}  {low[i]:.2e} .. {high[i]:.2e}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=10**8, help="Hadamard keys")
    parser.add_argument("--loop-trials", type=int, default=20_000, help="keys of the numpy loop")
    parser.add_argument("--threads", type=int, default=2)
    main(**vars(parser.parse_args()))
