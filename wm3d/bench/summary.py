"""What a finished run says on the terminal: detection by attack, and where the rest is."""

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from rich.console import Console
from rich.table import Table

from wm3d.bench.columns import NOT_MARKED
from wm3d.stats import DEFAULT_PF

PLAIN_WIDTH = 110
"""Columns of the table where no terminal sets them."""

DETECTED, LOST = 0.99, 0.5
"""Pd from which a mark counts as surviving an attack, and below which it counts as lost."""

FOUND, AT_TIMES, GONE, FAILED = "found", "found at times", "lost", "failed"
REFUSED = "refused"
"""The scheme refused to mark the mesh, with every key."""

BEYOND = "out of reach"
"""No key of so few signs has so small a false-alarm probability."""


def quoted_pf(pf: Iterable[float]) -> float:
    """Return the false-alarm probability nearest to `DEFAULT_PF` among those that the tables quote."""
    return min(pf, key=lambda value: abs(math.log(value / DEFAULT_PF)))


def left_out(calibration: pd.DataFrame) -> list[str]:
    """Return why schemes have no numbers on a mesh, a sentence each, from the table of calibrations."""
    refused = calibration[calibration["error"] != ""]
    return [f"{line['scheme']}: {line['error']}" for line in refused.to_dict("records")]


def verdict(line: Mapping[Any, Any], pf: float) -> str:
    """Return the word for a line of the detection table at one of its Pf."""
    share = line[f"pd_{pf:g}"]
    if not line["trials"]:
        return FAILED
    if line["refused"] == line["trials"] and not line["failed"]:
        return REFUSED
    if line["log10_pf_least"] > math.log10(pf):
        return BEYOND
    return FOUND if share >= DETECTED else GONE if share < LOST else AT_TIMES


def refusals(rows: pd.DataFrame) -> dict[tuple[str, str], str]:
    """Return why a scheme marked a mesh with no key at all, by mesh and scheme: what it said first."""
    groups = rows[rows["hypothesis"] == "H1"].groupby(["mesh", "scheme"], sort=False)
    return {
        (str(mesh), str(scheme)): str(group["error"].iloc[0]).removeprefix(NOT_MARKED)
        for (mesh, scheme), group in groups
        if group["snr_db"].isna().all() and group["log10_p"].notna().all()
    }


def print_summary(
    tables: Mapping[str, pd.DataFrame], directory: Path, refused: Mapping[tuple[str, str], str], pf: float
) -> None:
    """Print Pd at a false-alarm probability, with its interval and a verdict.

    Parameters
    ----------
    tables : mapping of str to DataFrame
        Those of the report, by name.
    directory : Path
        Where the rest is.
    refused : mapping of (str, str) to str
        `refusals` of the run.
    pf : float
        One of those that the tables quote.
    """
    table = tables["detection"]
    console = table_console()
    for (mesh, scheme), group in table.groupby(["mesh", "scheme"], sort=False):
        console.print(f"{mesh}, {scheme}", highlight=False, soft_wrap=True)
        if why := refused.get((str(mesh), str(scheme))):
            console.print(f" {NOT_MARKED}{why}", highlight=False, soft_wrap=True)
            continue
        output = Table(box=None, padding=(0, 1))
        output.add_column("attack")
        for heading in ("trials", "d'", f"Pd at Pf = {pf:g}", "95 %"):
            output.add_column(heading, justify="right", no_wrap=True)
        output.add_column("the mark is")
        for line in group.to_dict("records"):
            share, low, high = (line[f"pd_{pf:g}{end}"] for end in ("", "_low", "_high"))
            numbers = (f"{line['d_prime']:.1f}", f"{share:.3f}", f"{low:.3f} to {high:.3f}")
            output.add_row(
                str(line["attack"]),
                str(line["trials"]),
                *(numbers if line["trials"] else "–––"),
                verdict(line, pf),
            )
        console.print(output)
    for sentence in left_out(tables["calibration"]) if "calibration" in tables else []:
        console.print(f"Left out: {sentence}", highlight=False, soft_wrap=True)
    console.print(f"Tables, figures and rows: {directory}", highlight=False, soft_wrap=True)


def table_console() -> Console:
    """Return a console on stdout that does not squeeze tables where no terminal asks for it."""
    console = Console(markup=False)  # names may hold brackets
    if not console.is_terminal:
        console.width = PLAIN_WIDTH
    return console
