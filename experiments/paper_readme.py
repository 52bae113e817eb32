"""Fill `paper_readme.md.j2`, the page that puts each number of the paper beside ours, from the tables."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from jinja2 import Environment, StrictUndefined

from wm3d.mesh import datasets

TEMPLATE = Path(__file__).with_name("paper_readme.md.j2")
HELD_POSE = TEMPLATE.parent.parent / "results" / "held_pose.csv"
OTHER_READINGS = "normalize=|miss="


def readme(tables: dict[str, pd.DataFrame], amplitude: pd.DataFrame, manifests: dict[str, Any]) -> str:
    """Return the page.

    Parameters
    ----------
    tables : dict of str to DataFrame
        The tables of all runs by kind, with a column `config`.
    amplitude : DataFrame
        Pd at 1e-6 for each mesh and amplitude of the noise.
    manifests : dict of str to dict
        The manifest of each run.
    """
    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    meshes = {name: entry for manifest in manifests.values() for name, entry in manifest["meshes"].items()}
    first = next(iter(manifests.values()))

    def at(kind: str, mesh: str, attack: str | None = None) -> dict[str, Any]:
        """Return the line of a mesh, and of an attack, under the default readings that has most keys."""
        lines = records(tables[kind], other_readings=False)
        found = [line for line in lines if line["mesh"] == mesh and attack in (None, line.get("attack"))]
        return max(found, key=lambda line: line.get("trials", line.get("keys")))

    page = environment.from_string(TEMPLATE.read_text(encoding="utf-8")).render(
        meshes=meshes,
        sources={name: _source(name) for name in meshes},
        model={"happy-buddha-300k": "happy buddha", "bunny-closed": "rabbit", "venus": "rabbit"},
        base={kind: records(table, other_readings=False) for kind, table in tables.items()},
        other={kind: records(table, other_readings=True) for kind, table in tables.items()},
        reach={mesh: crossing(group, 0.97) for mesh, group in amplitude.groupby("mesh", sort=False)},
        versions=first["versions"],
        held=pd.read_csv(HELD_POSE).to_dict("records"),
        at=at,
    )
    return page.rstrip() + "\n"


def records(table: pd.DataFrame, *, other_readings: bool) -> list[dict[str, Any]]:
    """Return the lines under the default readings of `normalize` and `miss`, or all others."""
    other = table["scheme"].str.contains(OTHER_READINGS)
    return table[other if other_readings else ~other].to_dict("records")


def _source(name: str) -> str:
    source = datasets.describe(name).source
    return f"`{Path(source).name}`, a file of one's own" if Path(source).is_absolute() else source


def crossing(curve: pd.DataFrame, level: float) -> float:
    """Return the largest amplitude at which Pd still reaches `level`, linear between the points measured.

    NaN if it never does, infinite if it always does.
    """
    percent, share = curve["rms_vector_percent"].to_numpy(), curve["pd"].to_numpy()
    below = np.flatnonzero(share < level)
    if len(below) == 0:
        return float("inf")
    k = below[0]
    if k == 0:
        return float("nan")
    return float(np.interp(-level, -share[k - 1 : k + 1], percent[k - 1 : k + 1]))
