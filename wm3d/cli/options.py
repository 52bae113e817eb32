"""What the commands share: common arguments, defaults shown late, and the parsing of their values."""

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wm3d.cli.compiling import tell_of_compiling
from wm3d.errors import Wm3dError, shortened

if TYPE_CHECKING:
    from wm3d.mesh import Mesh

SourceMesh = Annotated[
    str,
    typer.Argument(metavar="IN", help="Mesh file (PLY, OBJ, OFF, STL, GLB), or a name of `wm3d data list`."),
]
Parameters = Annotated[
    list[str] | None,
    typer.Argument(metavar="PARAM=VALUE", help="Parameters; `wm3d list` shows them.", show_default=False),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, on one line.")]


class Late:
    """A default value that lives in a module slow to import: read only when it is used or shown in a help."""

    def __init__(self, read: Callable[[], str]) -> None:
        self._read = read

    def __call__(self) -> str:
        """Return the default."""
        return self._read()

    def __str__(self) -> str:
        return self._read()


def read_mesh(argument: str) -> "Mesh":
    """Return the mesh of a file or a dataset, named as the user named it, for the messages."""
    from wm3d.mesh import datasets

    tell_of_compiling()
    return replace(datasets.resolve(argument), name=argument)


def same_file(one: str | os.PathLike[str], other: str | os.PathLike[str]) -> bool:
    """Tell whether two paths lead to one file, there already or yet to be written."""
    if Path(one).exists() and Path(other).exists():
        return Path(one).samefile(other)
    return os.path.realpath(one) == os.path.realpath(other)


def keep_original(source: str, target: str | os.PathLike[str], what: str) -> None:
    """Refuse to write to the file that a command reads, given by its path or as a dataset.

    Raises
    ------
    Wm3dError
        If `target` is that file; `what` says what was to be written.
    """
    from wm3d.mesh import datasets

    if same_file(datasets.locate(source), target):
        raise Wm3dError(f"{target}: is the original; give the {what} a name of its own.")


def grid_size(text: str) -> tuple[int, int]:
    """Return (N_v, N_u) from "NVxNU".

    Raises
    ------
    Wm3dError
        If the text has another form.
    """
    match = re.fullmatch(r"(\d+)[xX×](\d+)", text)
    if match is None:
        raise Wm3dError(f"--grid {text}: must have the form NVxNU, columns by rows, such as 84x120.")
    return int(match[1]), int(match[2])


def region_corners(text: str) -> tuple[int, ...]:
    """Return (U0, V0, NU, NV) from "U0,V0,NU,NV".

    Raises
    ------
    Wm3dError
        If the text has another form.
    """
    if re.fullmatch(r"\d+(,\d+){3}", text) is None:
        raise Wm3dError(
            f"--region {text}: must have the form U0,V0,NU,NV: first row, first column, rows, columns, "
            "such as 2,0,80,80."
        )
    return tuple(int(number) for number in text.split(","))


def assignments(pairs: Sequence[str], **options: Any) -> dict[str, Any]:
    """Return parameters from "param=value" texts, whose values are YAML 1.2, and options that are not None.

    Raises
    ------
    Wm3dError
        If a text has another form, or a parameter is set twice.
    """
    from wm3d.bench.yamlfile import parse_value

    parameters = {name: value for name, value in options.items() if value is not None}
    for pair in pairs:
        name, equals, text = pair.partition("=")
        if equals and "." in name:
            whole, _, part = name.partition(".")
            raise Wm3dError(
                f"{pair}: a parameter with parameters of its own is given as a whole, such as "
                f"'{whole}={{name: ..., {part}: {text}}}'."
            )
        if not (equals and name.isidentifier()) or name == "name":
            raise Wm3dError(f"{pair}: a parameter must have the form param=value, such as percent=0.6.")
        if name in parameters:
            raise Wm3dError(f"{pair}: the parameter {name} is set twice.")
        parameters[name] = parse_value(text, shortened(pair))
    return parameters
