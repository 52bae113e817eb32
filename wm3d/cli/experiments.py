"""`wm3d run` and `wm3d report`: experiments from a config, and their tables and figures."""

import signal
from pathlib import Path
from typing import Annotated

import typer


def run(
    config: Annotated[
        Path, typer.Argument(metavar="CONFIG.yaml", help="What to run; see the folder configs.")
    ],
    *,
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Run directory.", show_default="runs/ and the name in the config"),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, help="Local processes.", show_default="one for each processor"),
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Dask scheduler to use instead of local processes."),
    ] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="PATH=VALUE",
            help="Change one field of the config, such as trials=10; repeatable.",
        ),
    ] = None,
    dry_run: Annotated[
        bool,
        typer.Option(
            "--dry-run",
            help="Print the plan and, from one trial of each kind, how long it takes; store nothing.",
        ),
    ] = False,
) -> None:
    """Run an experiment, then report it.

    What an earlier run of the same experiment left in the directory is kept, so a run that was stopped goes
    on where it stopped, and trials that failed are tried again unless wm3d refused the mesh. Exit status 1:
    some trials failed.

    Example: wm3d run configs/quickstart.yaml

    Example: wm3d run configs/quickstart.yaml --set trials=10 --out try
    """
    from wm3d.bench import run_config

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # as batch systems stop a job: like Ctrl-C
    try:
        outcome = run_config(
            config, out=out, workers=workers, dask=dask, overrides=overrides or [], dry_run=dry_run
        )
    except KeyboardInterrupt:
        typer.echo(
            "wm3d: stopped; finished cells are kept, and the same command goes on from there.", err=True
        )
        raise
    if outcome.failed:
        typer.echo(
            f"wm3d: {outcome.directory}: {outcome.failed} trials failed; report.html, under Faults, or a "
            "line above says why, and the same command tries them again unless wm3d refused the mesh.",
            err=True,
        )
        raise typer.Exit(1)


def report(
    directory: Annotated[Path, typer.Argument(metavar="RUN_DIR", help="What a finished `wm3d run` wrote.")],
) -> None:
    """Write the tables, figures and page of a run again.

    They follow from the rows that the run stored; nothing is run.

    Example: wm3d report runs/quickstart
    """
    from wm3d.bench import write_report

    typer.echo(write_report(directory).page)
