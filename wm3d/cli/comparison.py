"""`wm3d compare`: how much one mesh differs from another."""

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from wm3d.cli.options import AsJson, SourceMesh, read_mesh
from wm3d.cli.output import print_json, print_table

if TYPE_CHECKING:
    from wm3d.metrics import Measurement


def compare(
    original: SourceMesh,
    other: Annotated[str, typer.Argument(metavar="OTHER", help="The mesh that is compared with it.")],
    *,
    as_json: AsJson = False,
) -> None:
    """Measure how much a mesh differs from the original.

    Every metric of `wm3d list metrics` is computed; units stand in the names. Lengths are given in mesh units
    and in percent of the diagonal of the original's bounding box. Metrics that are not defined for the two
    meshes say why.

    The object of --json has the fields original, other, one for each number, and notes. A number that is
    infinite or not defined is null, and notes says which.

    Example: wm3d compare bunny marked.ply
    """
    from wm3d.metrics import measure

    measurements = measure(read_mesh(original), read_mesh(other))
    if as_json:
        print_json(_fields(original, other, measurements))
    else:
        print_table(("METRIC", "VALUE"), [(one.name, _text(one)) for one in measurements])


def _fields(original: str, other: str, measurements: "list[Measurement]") -> dict[str, Any]:
    numbers = {one.name: one.value if _finite(one) else None for one in measurements}
    notes = {one.name: one.reason or "infinite" for one in measurements if not _finite(one)}
    return {"original": original, "other": other, **numbers, "notes": notes}


def _finite(one: "Measurement") -> bool:
    return one.value is not None and math.isfinite(one.value)


def _text(one: "Measurement") -> str:
    return one.reason if one.value is None else f"{one.value:.6g}"
