"""The `wm3d` command: its sub-commands, and how errors become one sentence and an exit status."""

import contextlib
import io
import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from wm3d.cli.comparison import compare
from wm3d.cli.experiments import report, run
from wm3d.cli.listing import data, list_components
from wm3d.cli.marks import detect, embed
from wm3d.cli.meshes import attack, scan
from wm3d.cli.plugins import check_plugin
from wm3d.errors import Wm3dError

BAD_INPUT = 2
"""Exit status for bad input and for wrong usage; a command's own statuses are 0 and 1."""

CRASH = 70
"""Exit status for an error of wm3d itself (EX_SOFTWARE of sysexits.h): never 1, which is an answer."""

UNHEARD = 141
"""Exit status where the reader of the output has gone, as shells show SIGPIPE: not 1 either."""

app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit status: 0 done; 1 `detect` found no mark, or trials of `run` or checks of `check-plugin` "
    "failed; 2 bad input; 70 an error in wm3d or a plug-in, with its traceback; 130 stopped by Ctrl-C, "
    "`run` by SIGTERM, too; 141 nobody reads the output.",
)
for command in (run, report, embed, detect, attack, scan, compare, check_plugin):
    app.command()(command)
app.command("list")(list_components)
app.add_typer(data, name="data")


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False,
) -> None:
    """Benchmark watermarks in 3D meshes; mark a mesh, and look for the mark later.

    `run` and `report` do whole experiments from a YAML config. `embed` and `detect` work on single meshes;
    `attack` and `scan` show what happens in between, `compare` what it does to the shape.

    Example: wm3d run configs/quickstart.yaml

    Example: wm3d embed bunny marked.ply --key key.json
    """
    if version:
        from wm3d import __version__

        typer.echo(f"wm3d {__version__}")
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default those of the process.

    Returns
    -------
    int
        Exit status. Bad input gives 2 and one sentence on stderr, an unexpected error 70 and its traceback,
        output that nobody reads 141.
    """
    _open_streams()
    try:
        status = app(arguments, prog_name="wm3d", standalone_mode=False)
    except typer.TyperException as error:
        return _fail(_usage(error))
    except Wm3dError as error:
        return _fail(str(error))
    except MemoryError:
        return _fail("not enough memory; use a smaller grid, mesh or number of workers.")
    except OSError as error:
        return _fail(f"{error.filename or 'a file'}: cannot be used ({error.strerror or error}).")
    except (Exception, SystemExit) as error:
        if isinstance(error.__context__, BrokenPipeError):  # for which typer exits with 1
            return UNHEARD
        with _unwritable_ignored():
            traceback.print_exc()  # the interpreter would exit with 1, and `detect` means "no mark" by that
        return CRASH
    return status if isinstance(status, int) else 0


def _open_streams() -> None:
    """Make streams that were closed lead nowhere, and file names and "σ" print in every encoding."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # open until the process ends
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def _unwritable_ignored() -> contextlib.suppress:
    """Return a context in which nothing is made of a stream that is closed or on a full disk."""
    return contextlib.suppress(OSError, ValueError)


def _fail(sentence: str) -> int:
    with _unwritable_ignored():
        typer.echo(f"wm3d: {sentence}", err=True)
    return BAD_INPUT


def _usage(error: typer.TyperException) -> str:
    """Return one line for a wrong command line, with the command whose help tells more."""
    context = getattr(error, "ctx", None)
    command = context.command_path if context else "wm3d"
    sentence = " ".join(error.format_message().split()).rstrip(".?").replace(". ", "; ")
    return f"{sentence}; see `{command} --help`."
