"""What commands print: tables for a terminal or other programs, and JSON."""

import json
import sys
from collections.abc import Iterable, Sequence
from typing import Any

import typer

UNBOUNDED = 10_000
"""Columns of output that is not a terminal: lines are not wrapped."""


def print_json(content: Any) -> None:
    """Print one line of JSON, which knows neither NaN nor infinity."""
    typer.echo(json.dumps(content, allow_nan=False))


def print_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print columns: wrapped to the width of a terminal, else one line a row for other programs to read."""
    from rich import box
    from rich.console import Console
    from rich.table import Column, Table

    terminal = sys.stdout.isatty()
    columns = [Column(title, overflow="fold") for title in header]
    table = Table(*columns, box=box.SIMPLE_HEAD if terminal else None, pad_edge=False, padding=(0, 2, 0, 0))
    for row in rows:
        table.add_row(*row)
    console = Console(width=None if terminal else UNBOUNDED, highlight=False, markup=False)
    with console.capture() as printed:
        console.print(table)
    typer.echo("\n".join(line.rstrip() for line in printed.get().rstrip().split("\n")))
