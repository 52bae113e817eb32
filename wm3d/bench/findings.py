"""What a run found, in a form to put into sentences: what survived, what was lost, what the null is."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from wm3d.bench.config import Experiment
from wm3d.bench.ranking import METHOD, interval_words
from wm3d.bench.summary import left_out, verdict
from wm3d.component import Component
from wm3d.errors import Wm3dError
from wm3d.schemes import Scheme


@dataclass(frozen=True)
class Finding:
    """Pd of one attack at the quoted Pf, with its interval and the word for it."""

    attack: str
    pd: float
    low: float
    high: float
    verdict: str


@dataclass(frozen=True)
class Case:
    """The findings on one mesh with one scheme, in the order of the config."""

    mesh: str
    scheme: str
    findings: list[Finding]
    refusal: str
    """Why the scheme marked the mesh with no key; empty if it did with some."""

    def having(self, verdict: str) -> list[Finding]:
        """Return the findings of a verdict."""
        return [finding for finding in self.findings if finding.verdict == verdict]

    def groups(self, verdict: str) -> list[list[Finding]]:
        """Return the findings of a verdict; those with the same numbers together."""
        groups: dict[tuple[float, float, float], list[Finding]] = {}
        for finding in self.having(verdict):
            groups.setdefault((finding.pd, finding.low, finding.high), []).append(finding)
        return list(groups.values())


def cases(detection: pd.DataFrame, pf: float, refused: Mapping[tuple[str, str], str]) -> list[Case]:
    """Return what the detection table says at one of its Pf, and what was refused (`refusals`)."""
    return [
        Case(
            str(mesh),
            str(scheme),
            [_finding(line, pf) for line in group.to_dict("records")],
            refused.get((str(mesh), str(scheme)), ""),
        )
        for (mesh, scheme), group in detection.groupby(["mesh", "scheme"], sort=False)
    ]


def _finding(line: Mapping[Any, Any], pf: float) -> Finding:
    share, low, high = (float(line[f"pd_{pf:g}{end}"]) for end in ("", "_low", "_high"))
    return Finding(str(line["attack"]), share, low, high, verdict(line, pf))


@dataclass(frozen=True)
class Statistic:
    """How a scheme scores a key.

    Attributes
    ----------
    scheme : str
        Its label.
    source : str
        First line of its documentation.
    detector : str
        Label of its detector; empty where it has none of its own.
    meaning : str
        First line of the documentation of the detector.
    signs : int or None
        n, the signs in a key; None where that depends on the mesh.
    log10_least : float
        log10 of the least Pf that any detector of n signs attains: one key among 2^n; NaN without n.
    """

    scheme: str
    source: str
    detector: str
    meaning: str
    signs: int | None
    log10_least: float


def statistics(experiment: Experiment) -> list[Statistic]:
    """Return the statistic of each scheme of an experiment."""
    schemes = dict.fromkeys(scheme for case in experiment.cases for scheme in case.schemes)
    found = []
    for scheme in schemes:
        detector = getattr(scheme, "detector", None)
        if not isinstance(detector, Component):
            detector = None
        signs = _signs(scheme)
        found.append(
            Statistic(
                scheme=scheme.label(),
                source=_first_line(scheme),
                detector=detector.label() if detector else "",
                meaning=_first_line(detector) if detector else "",
                signs=signs,
                log10_least=math.nan if signs is None else -signs * math.log10(2),
            )
        )
    return found


def _signs(scheme: Scheme) -> int | None:
    try:
        return scheme.capacity
    except Wm3dError:  # known once a mesh is marked
        return None


def _first_line(component: object) -> str:
    return (type(component).__doc__ or "").partition("\n")[0].rstrip(".")


@dataclass(frozen=True)
class Ranking:
    """What a ranking says.

    Attributes
    ----------
    orders : dict of str to list of dict
        The lines of the ranking by budget, best first, those without a rank last.
    left_out : list of str
        Why schemes have no numbers on a mesh, a sentence each.
    method : str
    """

    orders: dict[str, list[dict[str, Any]]]
    left_out: list[str]
    method: str


def ranking(tables: Mapping[str, pd.DataFrame]) -> Ranking | None:
    """Return what the ranking of a run says, None where its schemes were not calibrated."""
    if "leaderboard" not in tables:
        return None
    calibration = tables["calibration"]
    orders = {
        str(budget): [{str(key): value for key, value in line.items()} for line in group.to_dict("records")]
        for budget, group in tables["leaderboard"].groupby("budget", sort=False)
    }
    return Ranking(orders, left_out(calibration), f"{METHOD} {interval_words(calibration['mesh'].nunique())}")


def null_scores(rows: pd.DataFrame) -> dict[str, int]:
    """Return how many scores without the mark the run holds, by hypothesis."""
    null = rows[rows["hypothesis"].str.startswith("H0") & rows["log10_p"].notna()]
    return {str(name): int(count) for name, count in null["hypothesis"].value_counts(sort=False).items()}


def departures(nulls: pd.DataFrame) -> list[str]:
    """Return which lines of the table of nulls depart from the exact null, and how."""
    return [
        f"{line['mesh']}, {line['scheme']}, {line['attack']}, {line['hypothesis']}: {line['verdict']}"
        for line in nulls.to_dict("records")
        if str(line["verdict"]).startswith("departs")
    ]


def faults(rows: pd.DataFrame) -> list[dict[str, object]]:
    """Return the errors of a run: attack, what it said, how often, and whether the trial still counts."""
    failed = rows[rows["error"] != ""]
    groups = failed.groupby(["mesh", "scheme", "attack", "error"], sort=False)["log10_p"]
    return [
        dict(zip(("mesh", "scheme", "attack", "error"), names, strict=True))
        | {"trials": len(scores), "counted": bool(scores.notna().all())}
        for names, scores in groups
    ]
