"""Tables as the report shows them: short numbers that keep the full ones, intervals beside their values."""

import base64
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pandas as pd
from pandas.api.types import is_bool_dtype, is_integer_dtype, is_numeric_dtype

from wm3d.bench.figures import power_of_ten
from wm3d.bench.tables import CELL_KEYS

DIGITS = 4
"""Significant digits of the largest number in a column; the others get as many decimals."""

TITLES = {
    "leaderboard": (
        "Ranking",
        "Schemes at equal distortion, best first, by mean Pd over attacks and meshes. Intervals are over "
        "draws of the meshes. Survived is the share of attacks and meshes at which the mark is found.",
    ),
    "calibration": (
        "Calibration",
        "The strength at which each scheme meets each budget of distortion on each mesh, set with one key.",
    ),
    "detection": (
        "Detection",
        "Pd at each Pf with its 95 % Clopper–Pearson interval, from exact p-values. d′ is the mean of z over "
        "keys, whose null has mean 0 and variance 1, with its 95 % interval by Student’s t. σ is the "
        "standard deviation of noise on each coordinate in % of the diagonal of the bounding box. Least "
        "Pf is the median of the least p-value that any key reaches on the mesh that was read. BER is the "
        "mean bit error rate of schemes that carry a message, with its 95 % interval by Student’s t.",
    ),
    "snr": ("Distortion", "Signal-to-noise ratio of the marked meshes over keys, in dB (eq. 13)."),
    "axes": (
        "Axes",
        "Angle in degrees between the axes of the original and of the marked, attacked mesh. “Flipped” is "
        "the share of trials in which an axis changed its sign; the other columns are about the rest.",
    ),
    "nulls": (
        "Null",
        "Scores without the mark against the exact key null: z should have mean 0 and variance 1, and p "
        "should nowhere be below uniform (one-sided Kolmogorov–Smirnov). The verdict holds all lines "
        "together to 1 %.",
    ),
    "false_alarms": (
        "False alarms",
        "Share of random keys whose z reaches a threshold, quoted from 10/Pf keys on, beside the exact tail.",
    ),
    "roc_paper": (
        "ROC by counting",
        "As the paper made it: one threshold on z for all trials, Pf counted on random keys, Pd on trials.",
    ),
    "timing": (
        "Stages",
        "Median seconds of each stage of a trial, and the most memory in MB that embedding needed beyond "
        "what the process held.",
    ),
}
"""Heading and explanation of the tables by file name; others are called by their file name."""

HEADINGS = {
    "sigma_percent": "σ, %",
    "faces_out": "faces after",
    "z_mean": "mean z",
    "z_std": "std z",
    "z_var": "var z",
    "d_prime": "d′",
    "auc": "AUC",
    "eer": "EER",
    "log10_pf_least": "least log10 Pf",
    "ber": "BER",
    "ks_p": "KS p-value",
    "pf": "Pf",
    "pd": "Pd",
    "log10_pf_exact": "exact log10 Pf",
    "snr_db": "SNR, dB",
    "snr_apart": "keys apart, dB",
    "mean_deg": "mean °",
    "median_deg": "median °",
    "max_deg": "max °",
    "embed_seconds": "embed, s",
    "attack_seconds": "attack, s",
    "score_seconds": "scan and score, s",
    "embed_mb": "embed, MB",
    "detect_seconds": "scan and score, s",
}


@dataclass(frozen=True)
class Cell:
    """One cell: what is shown, the full value, and the interval if the value has one."""

    text: str
    full: str
    interval: str = ""


@dataclass(frozen=True)
class Column:
    """One column: heading, alignment, cells."""

    heading: str
    numeric: bool
    cells: list[Cell]


@dataclass(frozen=True)
class HtmlTable:
    """One table.

    Attributes
    ----------
    name : str
        File name of the CSV without its ending.
    title, about : str
    common : str
        What is the same in all lines and therefore has no column.
    columns : list of Column
    csv : str
        The whole table as a base64 CSV, to download.
    """

    name: str
    title: str
    about: str
    common: str
    columns: list[Column]
    csv: str

    @property
    def lines(self) -> list[tuple[Cell, ...]]:
        """The cells line by line."""
        return list(zip(*(column.cells for column in self.columns), strict=True))


def html_table(name: str, table: pd.DataFrame) -> HtmlTable:
    """Return a table ready to be shown.

    Parameters
    ----------
    name : str
    table : DataFrame
        Columns ``X_low`` and ``X_high`` are shown as the interval of ``X``; mesh, scheme and whole numbers
        that are the same throughout move to `common`. A column of no numbers at all, such as the noise of a
        run without noise, is left out.
    """
    title, about = TITLES.get(name, (name.replace("_", " ").capitalize(), ""))
    common = [str(column) for column in table.columns if _is_common(table[column])]
    bounds = {
        f"{value}_{end}" for value in table.columns for end in ("low", "high") if _has_interval(table, value)
    }
    empty = {column for column in table.columns if len(table) and table[column].isna().all()}
    shown = [str(column) for column in table.columns if column not in {*common, *bounds, *empty}]
    shown.sort(
        key=lambda column: column not in {*CELL_KEYS, "hypothesis"}
    )  # what a line is about comes first
    return HtmlTable(
        name=name,
        title=title,
        about=about,
        common=", ".join(_common(table, column) for column in common),
        columns=[_column(table, column) for column in shown],
        csv=base64.b64encode(table.to_csv(index=False, lineterminator="\n").encode()).decode(),
    )


def _is_common(values: "pd.Series[Any]") -> bool:
    if not len(values) or values.nunique(dropna=False) > 1:
        return False
    return values.name in CELL_KEYS[:2] or (len(values) > 1 and is_integer_dtype(values))


def _common(table: pd.DataFrame, column: str) -> str:
    value = table[column].iloc[0]
    return str(value) if column in CELL_KEYS else f"{_heading(column)} {value}"


def _has_interval(table: pd.DataFrame, column: str) -> bool:
    return f"{column}_low" in table.columns and f"{column}_high" in table.columns


def _column(table: pd.DataFrame, column: str) -> Column:
    values = table[column]
    numeric = is_numeric_dtype(values) and not is_bool_dtype(values)
    if not numeric:
        return Column(_heading(column), False, [Cell(str(value), str(value)) for value in values])
    ends = [table[f"{column}_{end}"] for end in ("low", "high") if _has_interval(table, column)]
    short = shortener(pd.concat([values, *ends]))
    cells = [Cell(short(value), repr(value)) for value in values.tolist()]
    if ends:
        limits = zip(*(end.tolist() for end in ends), strict=True)
        cells = [
            Cell(cell.text, f"{cell.full}, 95 % {low!r} to {high!r}", f"{short(low)}–{short(high)}")
            for cell, (low, high) in zip(cells, limits, strict=True)
        ]
    return Column(_heading(column), True, cells)


def _heading(column: str) -> str:
    if match := re.fullmatch(r"pd_([0-9.e+-]+)", column):
        return f"Pd at {short_power(float(match[1]))}"
    if match := re.fullmatch(r"pf_([0-9.e+-]+)", column):
        return f"share of p ≤ {float(match[1]):g}"
    return HEADINGS.get(column, column.replace("_", " "))


def shortener(values: "pd.Series[Any]") -> Callable[[float], str]:
    """Return how to write the numbers of a column: decimals by its largest number, tiny ones as powers."""
    sizes = [abs(value) for value in values.tolist() if math.isfinite(value) and value != 0]
    if all(float(size).is_integer() for size in sizes):
        decimals = 0
    else:
        decimals = min(max(DIGITS - 1 - math.floor(math.log10(max(sizes))), 0), DIGITS)

    def write(value: float) -> str:
        if not math.isfinite(value):
            return "–" if math.isnan(value) else "∞" if value > 0 else "−∞"
        if value != 0 and abs(value) < 10.0**-decimals / 2:
            digits, _, exponent = f"{value:.1e}".partition("e")
            return f"{digits}×{power_of_ten(int(exponent))}".replace("-", "−")
        return "0" if value == 0 else f"{value:,.{decimals}f}".replace(",", "\u202f").replace("-", "−")

    return write


def short_power(value: float) -> str:
    """Write a probability as a power of ten where it is one."""
    exponent = math.log10(value)
    return power_of_ten(round(exponent)) if math.isclose(exponent, round(exponent)) else f"{value:g}"
