"""`wm3d check-plugin`: checks whether an attack or a scheme keeps what the harness relies on."""

from typing import TYPE_CHECKING, Annotated

import typer

from wm3d.cli.options import Parameters, assignments
from wm3d.errors import Wm3dError, hint

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wm3d.contract import Outcome


def check_plugin(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="One of `wm3d list schemes` or `wm3d list attacks`.")
    ],
    pairs: Parameters = None,
) -> None:
    """Check an attack or a scheme against its contract.

    A line holds a promise, and what is wrong where it is not kept. Exit status 0: all are kept; 1: some are
    not.

    Example: wm3d check-plugin song2002

    Example: wm3d check-plugin simplify ratio=0.2
    """
    broken = total = 0
    for outcome in _outcomes(name, pairs or []):
        total += 1
        broken += bool(outcome.fault)
        verdict, fault = ("FAIL", f" But {outcome.fault}") if outcome.fault else ("ok", "")
        typer.echo(f"{verdict:4} {outcome.check}: {outcome.promise}{fault}")
    typer.echo(f"{name}: {total - broken} of {total} checks passed")
    if broken:
        raise typer.Exit(1)


def _outcomes(name: str, pairs: list[str]) -> "Iterator[Outcome]":
    from wm3d.attacks import ATTACKS
    from wm3d.contract import ATTACK_CHECKS, SCHEME_CHECKS, examine
    from wm3d.schemes import SCHEMES

    if name not in ATTACKS and name not in SCHEMES:  # one that cannot be loaded has been logged
        lists = "see `wm3d list schemes` and `wm3d list attacks`."
        raise Wm3dError(f"unknown scheme or attack {name!r}; {hint(name, [*SCHEMES, *ATTACKS], lists)}")
    if name in SCHEMES:
        yield from examine(SCHEMES.build(name, assignments(pairs)), SCHEME_CHECKS)
    if name in ATTACKS:
        yield from examine(ATTACKS.build(name, assignments(pairs)), ATTACK_CHECKS)
