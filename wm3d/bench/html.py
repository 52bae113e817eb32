"""The report as one HTML file that opens offline: figures, tables, readings, config, provenance."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape
from scipy.stats import norm

from wm3d.bench import findings
from wm3d.bench.config import Experiment
from wm3d.bench.curves import LEAST_LOG10_PF
from wm3d.bench.figures import power_of_ten
from wm3d.bench.htmltables import HtmlTable, html_table, short_power, shortener
from wm3d.bench.readings import readings
from wm3d.bench.summary import DETECTED, LOST, quoted_pf
from wm3d.bench.tables import CELL_KEYS

HYPOTHESES = {
    "H0-wrong-key": "scores of keys that were never embedded, on the marked and attacked meshes",
    "H0-unmarked": "scores of the trials' keys on the unmarked mesh after the same attack",
    "H0-other-mesh": "scores of the trials' keys on other meshes after the same attack",
}
"""What the scores without the mark are, by hypothesis; others are called by their name."""


APART = {"leaderboard", "timing"}
"""Tables that have a section of their own."""


@dataclass(frozen=True)
class Run:
    """All that a report is made from.

    Attributes
    ----------
    experiment : Experiment
    config : str
        The config as run, YAML.
    manifest : mapping
        Content of manifest.json.
    rows : DataFrame
    tables : mapping of str to DataFrame
        By file name without ending.
    refused : mapping of (str, str) to str
        `wm3d.bench.summary.refusals`.
    figures : mapping of str to str
        SVG elements by name.
    """

    experiment: Experiment
    config: str
    manifest: Mapping[str, Any]
    rows: pd.DataFrame
    tables: Mapping[str, pd.DataFrame]
    refused: Mapping[tuple[str, str], str]
    figures: Mapping[str, str]


def render(run: Run) -> str:
    """Return the report of a run; the same run gives the same text."""
    experiment = run.experiment
    pf = quoted_pf(experiment.pf)
    cases = findings.cases(run.tables["detection"], pf, run.refused)
    there = [case for case in cases if not case.refusal]
    marked = dict.fromkeys(case.mesh for case in there)
    schemes = dict.fromkeys(scheme for case in experiment.cases for scheme in case.schemes)
    labels = [scheme.label() for scheme in schemes]
    if not experiment.budgets:  # else the label of a case names its budget, too
        embedded = {case.scheme for case in there}
        labels = [label for label in labels if label in embedded] or labels
    return (
        _environment()
        .get_template("report.html")
        .render(
            title=experiment.title or experiment.name,
            experiment=experiment,
            config=run.config,
            manifest=run.manifest,
            pf=pf,
            z_at_pf=float(norm.isf(pf)),
            least_log10_pf=LEAST_LOG10_PF,
            detected=DETECTED,
            lost=LOST,
            marked={name: run.manifest["meshes"][name] for name in marked},
            cases=cases,
            embedded=labels,
            statistics=findings.statistics(experiment),
            null_scores=findings.null_scores(run.rows),
            departures=findings.departures(run.tables["nulls"]),
            keys_counted=_keys_counted(run.tables),
            faults=findings.faults(run.rows),
            figures={name: Markup(svg) for name, svg in run.figures.items()},
            tables=[html_table(name, table) for name, table in run.tables.items() if name not in APART],
            timing=html_table("timing", run.tables["timing"]),
            stages=_stages(run.tables["timing"]),
            readings=readings([*schemes, *experiment.attacks]),
            hypotheses=HYPOTHESES,
            ranking=findings.ranking(run.tables),
            leaderboard=_leaderboard(run.tables),
            not_blind=[scheme.label() for scheme in schemes if not scheme.blind],
        )
    )


def _whole(number: int) -> str:
    return f"{number:,}".replace(",", "\u202f")


def _keys_counted(tables: Mapping[str, pd.DataFrame]) -> str:
    """Return in words how many keys the counted curves have; whole transforms of a scheme's own size."""
    if "false_alarms" not in tables:
        return ""
    keys = tables["false_alarms"]["keys"]
    fewest, most = _whole(keys.min()), _whole(keys.max())
    return most if fewest == most else f"{fewest} to {most}, by the scheme,"


def _leaderboard(tables: Mapping[str, pd.DataFrame]) -> HtmlTable | None:
    """Return the ranking, without the labels that repeat method and budget."""
    if "leaderboard" not in tables:
        return None
    return html_table("leaderboard", tables["leaderboard"].drop(columns="scheme"))


def _stages(timing: pd.DataFrame) -> list[dict[str, Any]]:
    """Lines of the bar chart of times: seconds of each stage, and their share of the longest line."""
    stages = [str(column) for column in timing.columns if str(column).endswith("_seconds")]
    timing = timing.fillna(dict.fromkeys(stages, 0.0))  # of trials that were refused
    longest = timing[stages].sum(axis=1).max() or 1.0  # nothing took time where every mesh was refused
    short = shortener(pd.Series([longest]))
    telling = [key for key in CELL_KEYS if key == "attack" or timing[key].nunique() > 1]
    lines = []
    for line in timing.to_dict("records"):
        bars = [(stage.removesuffix("_seconds"), line[stage], line[stage] / longest) for stage in stages]
        lines.append(
            {
                "name": ", ".join(str(line[key]) for key in telling),
                "bars": bars,
                "total": short(sum(b[1] for b in bars)),
            }
        )
    return lines


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("wm3d.bench"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "power": short_power,
        "power_of_ten": power_of_ten,
        "code_spans": _code_spans,
        "whole": _whole,
        "time": lambda text: datetime.fromisoformat(text).strftime("%Y-%m-%d %H:%M:%S %Z"),
        "listed": _listed,
    }
    return environment


def _code_spans(text: str) -> Markup:
    """Turn the backquotes of docstrings into code elements."""
    return Markup(re.sub(r"(`+)(.+?)\1", r"<code>\2</code>", str(escape(text))))


def _listed(words: list[str]) -> Markup:
    """Join words as code elements: a, b and c."""
    spans = [Markup("<code>{}</code>").format(word) for word in words]
    return Markup(", ").join(spans[:-1]) + Markup(" and ") + spans[-1] if len(spans) > 1 else spans[0]
