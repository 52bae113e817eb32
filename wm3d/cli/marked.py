"""What `embed` and `detect` say of a score, and of the files that `embed` writes."""

import itertools
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from wm3d.cli.output import print_json

if TYPE_CHECKING:
    from wm3d.schemes import Scheme
    from wm3d.stats import Score


def default_pf() -> str:
    """Return the Pf at which a mark counts as found, as the helps and messages write it."""
    from wm3d.stats import DEFAULT_PF

    return f"{DEFAULT_PF:g}"


class MarkedFiles(NamedTuple):
    """What `embed` tells of the files that it wrote: the score before the mesh was a file, and after."""

    source: str
    target: Path
    key: Path
    scheme: "Scheme"
    decibels: float
    before: "Score"
    score: "Score"

    def print(self, *, as_json: bool) -> None:
        """Print what was written and what detection finds in it, and the remedy where that is nothing."""
        from wm3d.registry import component_name
        from wm3d.stats import DEFAULT_PF

        if as_json:
            scheme = {"scheme": component_name(type(self.scheme)), "snr_db": _finite(self.decibels)}
            files = {"original": self.source, "marked": str(self.target), "key": str(self.key)}
            print_json({**scheme, **files, **score_fields(self.score, DEFAULT_PF)})
        else:
            typer.echo(f"{self.source} -> {self.target}: {self.scheme.label()}, SNR {self.decibels:.2f} dB")
            typer.echo(f"detection in {self.target}: {evidence(self.score)}")
            typer.echo(f"key: {self.key}")
        if not self.score.detected():
            typer.echo(
                f"wm3d: {self.target}: the mark in the written file cannot be detected at Pf = "
                f"{default_pf()}; {self._remedy()}.",
                err=True,
            )

    def _remedy(self) -> str:
        from wm3d.stats import DEFAULT_PF

        if self.score.null.log10_p_least > math.log10(DEFAULT_PF):
            return "not even the right key could reach that, too few signs are read; choose more of them"
        if self.before.detected():
            return f"the format {self.target.suffix} loses it; write PLY, OBJ or OFF"
        return "it is too weak; choose another strength or region"


def score_fields(score: "Score", pf: float) -> dict[str, Any]:
    """Return what JSON tells of a score; log10 p of a key that no random one can equal is null."""
    return {
        "detected": score.detected(pf),
        "p_value": score.p_value,
        "log10_p": _finite(score.log10_p),
        "z": score.z,
        "statistic": score.statistic,
        "threshold_pf": pf,
    }


def _finite(number: float) -> float | None:
    return number if math.isfinite(number) else None


def evidence(score: "Score") -> str:
    """Return how a sentence tells of a score."""
    return f"z = {score.z:.2f}, log10 p = {score.log10_p:.2f}"


def kept_key(path: Path, new: bytes) -> dict[Path, bytes]:
    """Return where another key in the place of a new one is kept: without it no mark of it is found again."""
    from wm3d.mesh import Secret
    from wm3d.schemes.key import FORMAT

    try:
        old = path.read_bytes()
    except OSError:
        return {}
    if old == new or f'"{FORMAT}"'.encode() not in old:  # also of a scheme that is not installed any more
        return {}
    places = (path.with_name(f"{path.name}.~{number}~") for number in itertools.count(1))
    return {next(place for place in places if not place.exists()): Secret(old)}
