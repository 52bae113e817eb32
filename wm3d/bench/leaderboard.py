"""leaderboard.json: the ranking of a run with what it was made from, to be read by other programs."""

import json
from collections.abc import Mapping
from typing import Any

import pandas as pd

from wm3d.bench.config import Experiment
from wm3d.bench.plan import uncalibrated
from wm3d.bench.ranking import METHOD, interval_words


def leaderboard(
    experiment: Experiment,
    manifest: Mapping[str, Any],
    ranked: pd.DataFrame,
    calibration: pd.DataFrame,
    pf: float,
) -> str:
    """Return leaderboard.json as text.

    Parameters
    ----------
    experiment : Experiment
    manifest : mapping
        Content of manifest.json.
    ranked : DataFrame
        `wm3d.bench.ranking.ranking`.
    calibration : DataFrame
        With the columns `wm3d.bench.columns.CALIBRATION`.
    pf : float
        The false-alarm probability of the scores.
    """
    blind = {
        uncalibrated(scheme).label(): scheme.blind for case in experiment.cases for scheme in case.schemes
    }
    meshes = list(dict.fromkeys(calibration["mesh"]))
    content = {
        "wm3d": manifest["versions"]["wm3d"],
        "experiment": experiment.name,
        "finished": manifest["ended"],
        "pf": pf,
        "trials": experiment.trials,
        "meshes": {name: manifest["meshes"][name]["sha256"] for name in meshes},
        "attacks": [attack.label() for attack in experiment.attacks],
        "budgets": [budget.model_dump() | {"label": budget.label()} for budget in experiment.budgets],
        "method": f"{METHOD} {interval_words(len(meshes))}",
        "entries": [_entry(line, calibration) | {"blind": blind[line["method"]]} for line in _lines(ranked)],
    }
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _lines(ranked: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the lines of a table with None for NaN and whole ranks."""
    lines = []
    for line in ranked.to_dict("records"):
        plain: dict[str, Any] = {str(key): None if pd.isna(value) else value for key, value in line.items()}
        ranks = {key: int(plain[key]) for key in ("rank", "rank_low", "rank_high") if plain[key] is not None}
        lines.append(plain | ranks)
    return lines


def _entry(line: Mapping[str, Any], calibration: pd.DataFrame) -> dict[str, Any]:
    of_scheme = calibration[calibration["scheme"] == line["scheme"]].to_dict("records")
    return {
        "budget": line["budget"],
        "rank": line["rank"],
        "rank_interval": [line["rank_low"], line["rank_high"]],
        "scheme": line["method"],
        "score": line["score"],
        "score_interval": [line["score_low"], line["score_high"]],
        "survived": line["survived"],
        "log10_pf_least": line["log10_pf_least"],
        "bit_error_rate": line["ber"],
        "snr_db": line["snr_db"],
        "snr_apart_db": line["snr_apart"],
        "embed_seconds": line["embed_seconds"],
        "detect_seconds": line["detect_seconds"],
        "embed_mb": line["embed_mb"],
        "strengths": {cell["mesh"]: cell["strength"] for cell in of_scheme if not cell["error"]},
        "left_out": {cell["mesh"]: cell["error"] for cell in of_scheme if cell["error"]},
    }
