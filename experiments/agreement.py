"""Compare `configs/agreement.yaml` with the figures of an independent implementation of the paper.

    wm3d run configs/agreement.yaml
    python experiments/agreement.py runs/agreement

That implementation is older than this one and shares no code with it. Its figures are means over 24 keys with
the standard deviation over keys; ours agree if they differ by at most twice that.
"""

import argparse
import sys
from pathlib import Path

import pandas as pd

from wm3d.bench.config import load_experiment

NOISE_RMS, NOISE_AXIS = "gaussian-noise 0.6 rms-vector", "gaussian-noise 0.6 per-axis"
QUADRIC, CLUSTERING = "simplify 0.5 fast-simplification", "simplify 0.5 clustering"

REFERENCE_Z = {  # mesh, alpha: attack -> mean z, its spread over keys
    ("happy-buddha-300k", 0.9): {
        "clean": (15.6, 0.8),
        NOISE_RMS: (3.7, 1.0),
        NOISE_AXIS: (1.0, 0.8),
        QUADRIC: (14.2, 1.0),
        CLUSTERING: (9.1, 0.8),
    },
    ("happy-buddha-300k", 1.2): {
        "clean": (18.8, 0.9),
        NOISE_RMS: (4.9, 0.9),
        NOISE_AXIS: (1.3, 0.7),
        QUADRIC: (17.4, 1.1),
        CLUSTERING: (11.4, 0.9),
    },
    ("bunny-closed", 1.3): {
        "clean": (45.0, 0.5),
        NOISE_RMS: (17.3, 2.4),
        NOISE_AXIS: (5.2, 1.7),
        QUADRIC: (-2.6, 0.9),
        CLUSTERING: (23.0, 2.6),
    },
}
REFERENCE_SNR = {
    ("happy-buddha-300k", 0.9): 52.06,
    ("happy-buddha-300k", 1.2): 49.56,
    ("bunny-closed", 1.3): 41.17,
}
REFERENCE_AXES = {
    ("happy-buddha-300k", 0.9): {"clean": 0.009, QUADRIC: 0.09, CLUSTERING: 1.4},
    ("happy-buddha-300k", 1.2): {"clean": 0.012, QUADRIC: 0.08, CLUSTERING: 1.4},
    ("bunny-closed", 1.3): {"clean": 0.024, QUADRIC: 2.6, CLUSTERING: 1.9},
}


def main(run: Path) -> int:
    """Print our mean beside the reference for every cell; return 1 if one differs by more than its bound."""
    if (name := load_experiment(run / "config.yaml").name) != "agreement":
        sys.exit(f"{run}: is a run of {name}; run configs/agreement.yaml.")
    detection, snr, axes = (
        pd.read_csv(run / "tables" / f"{name}.csv") for name in ("detection", "snr", "axes")
    )
    apart = 0
    for mesh, alpha in REFERENCE_Z:
        ours = snr[_of(snr, mesh, alpha)]["snr_db"].item()
        print(f"\n{mesh}, alpha {alpha}: SNR {ours:.2f} dB, reference {REFERENCE_SNR[mesh, alpha]:.2f} dB")
        print(f"  {'attack':34} {'z ours':>14} {'z reference':>14} {'':6} {'axes ours':>10} {'ref.':>7}")
        for attack, (mean, spread) in REFERENCE_Z[mesh, alpha].items():
            line = detection[_of(detection, mesh, alpha) & (detection["attack"] == attack)].iloc[0]
            angle = axes[_of(axes, mesh, alpha) & (axes["attack"] == attack)]["mean_deg"].item()
            agrees = abs(line["z_mean"] - mean) <= 2 * spread
            apart += not agrees
            reference_angle = REFERENCE_AXES[mesh, alpha].get(attack)
            print(
                f"  {attack:34} {line['z_mean']:6.2f} ± {line['z_std']:4.2f}  {mean:6.2f} ± {spread:4.2f}  "
                f"{'agrees' if agrees else 'APART':6} {angle:9.3f}° "
                + (f"{reference_angle:6g}°" if reference_angle is not None else "")
            )
    print(f"\n{apart} of {sum(map(len, REFERENCE_Z.values()))} cells differ by more than twice the spread.")
    return int(apart > 0)


def _of(table: pd.DataFrame, mesh: str, alpha: float) -> "pd.Series[bool]":
    """Lines of one mesh and strength; the legend names alpha where it is not the default 1.3."""
    scheme = table["scheme"]
    marked = ~scheme.str.contains("alpha=") if alpha == 1.3 else scheme.str.contains(f"alpha={alpha:g}")
    return (table["mesh"] == mesh) & marked


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("run", type=Path, help="directory of the finished run")
    sys.exit(main(parser.parse_args().run))
