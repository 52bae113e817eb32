"""`wm3d list` and `wm3d data`: what can be named in configs and on the command line."""

import inspect
import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args, get_origin

import typer

from wm3d.cli.options import AsJson
from wm3d.cli.output import print_json, print_table

if TYPE_CHECKING:
    from wm3d.component import Component

Kind = Literal["schemes", "attacks", "imagemarks", "detectors", "metrics", "poses"]

data = typer.Typer(help="Named meshes: list, download, find them.", no_args_is_help=False)


def list_components(
    kind: Annotated[
        Kind,
        typer.Argument(metavar="KIND", help="schemes, attacks, imagemarks, detectors, metrics or poses."),
    ],
    *,
    as_json: AsJson = False,
) -> None:
    """List what configs and commands can name.

    A line holds the name, the parameters with their defaults, and what it is. Where a parameter is one of a
    few words, the default stands first. A metric has its unit and what it needs instead.

    The objects of --json have the fields name, parameters (an object of those that have defaults) and about;
    those of metrics name, unit, same_vertices and about.

    Example: wm3d list attacks
    """
    listed = _metrics() if kind == "metrics" else _listed(kind)
    if as_json:
        print_json(listed)
    elif kind == "metrics":
        print_table(("NAME", "UNIT", "NEEDS", "WHAT IT IS"), map(_metric_line, listed))
    else:
        classes = _components(kind)
        lines = [(one["name"], _parameters(classes[one["name"]]), one["about"]) for one in listed]
        print_table(("NAME", "PARAMETERS", "WHAT IT IS"), lines)


@data.command("list")
def data_list(*, as_json: AsJson = False) -> None:
    """List the named meshes.

    A line holds the name, the size where it is known, whether the mesh is on this machine, and its source.

    The objects of --json have the fields name, source, vertices, faces, available, credit and terms; null
    where nothing is known.

    Mesh files in the folder that the environment variable WM3D_DATA names are listed by their name without
    ending, and win over entries of the same name.
    """
    from wm3d.mesh import datasets

    if as_json:
        print_json([asdict(info) for info in datasets.info()])
        return
    rows = [
        (
            info.name,
            "" if info.vertices is None else str(info.vertices),
            "" if info.faces is None else str(info.faces),
            "yes" if info.available else "no",
            info.source,
        )
        for info in datasets.info()
    ]
    print_table(("NAME", "VERTICES", "FACES", "HERE", "SOURCE"), rows)


Name = Annotated[str, typer.Argument(metavar="NAME", help="One of `wm3d data list`.")]


@data.command("fetch")
def data_fetch(name: Name) -> None:
    """Download a mesh, or compute it; print its file.

    A mesh that is on this machine already is not fetched again. Files are kept in the user's cache folder, or
    in the folder that the environment variable WM3D_CACHE names.

    Example: wm3d data fetch bunny-zipper
    """
    from wm3d.mesh import datasets

    file = datasets.fetch(name)
    info = datasets.describe(name)
    typer.echo(file)
    for label, text in (("credit", info.credit), ("terms", info.terms)):
        if text:
            typer.echo(f"{label}: {text}", err=True)


@data.command("path")
def data_path(name: Name) -> None:
    """Print the file of a mesh; no network is used."""
    from wm3d.mesh import datasets

    typer.echo(datasets.path(name))


def _components(kind: str) -> "Mapping[str, type[Component]]":
    from wm3d.attacks import ATTACKS
    from wm3d.imagemarks import DETECTORS, IMAGEMARKS
    from wm3d.scanner import POSES
    from wm3d.schemes import SCHEMES

    tables: dict[str, Mapping[str, type[Component]]] = {
        "schemes": SCHEMES,
        "attacks": ATTACKS,
        "imagemarks": IMAGEMARKS,
        "detectors": DETECTORS,
        "poses": POSES,
    }
    return tables[kind]


def _listed(kind: str) -> list[dict[str, Any]]:
    return [
        {"name": name, "parameters": _defaults(cls), "about": _summary(cls)}
        for name, cls in _components(kind).items()
    ]


def _metrics() -> list[dict[str, Any]]:
    from wm3d.metrics import METRICS

    return [
        {
            "name": name,
            "unit": metric.unit,
            "same_vertices": metric.same_vertices,
            "about": _summary(metric.function),
        }
        for name, metric in METRICS.items()
    ]


def _metric_line(metric: dict[str, Any]) -> tuple[str, str, str, str]:
    needs = "same vertices" if metric["same_vertices"] else ""
    return metric["name"], metric["unit"].replace("_", " "), needs, metric["about"]


def _summary(documented: object) -> str:
    return (inspect.getdoc(documented) or "").partition("\n")[0]


def _defaults(cls: "type[Component]") -> dict[str, Any]:
    """Return the defaults as JSON knows them, of the parameters that need not be given."""
    from pydantic_core import to_jsonable_python

    return {
        name: to_jsonable_python(field.get_default(call_default_factory=True, validated_data={}))
        for name, field in cls.settable().items()
        if not field.is_required()
    }


def _parameters(cls: "type[Component]") -> str:
    """Write name=default for each parameter, and the other words where only some are allowed."""
    texts = []
    for name, field in cls.settable().items():
        default = "?" if field.is_required() else _text(field.default)
        words = get_args(field.annotation) if get_origin(field.annotation) is Literal else ()
        others = [f"|{word}" for word in words if str(word) != default]
        texts.append(f"{name}={default}" + "".join(others))
    return " ".join(texts)


def _text(default: Any) -> str:
    """Write a default as the user would behind `param=`."""
    if isinstance(default, str):
        return default
    name = getattr(default, "name", None)  # a component as a parameter
    return str(name) if name else json.dumps(default, separators=(",", ":"))
