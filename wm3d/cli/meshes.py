"""`wm3d attack` and `wm3d scan`: distort one mesh, and show what the virtual scanner sees of one mesh."""

import io
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from wm3d.cli.options import (
    AsJson,
    Late,
    Parameters,
    SourceMesh,
    assignments,
    grid_size,
    keep_original,
    read_mesh,
)
from wm3d.cli.output import print_json
from wm3d.errors import Wm3dError

if TYPE_CHECKING:
    from wm3d.scanner import RangeImage


def _default_grid() -> str:
    from wm3d.scanner.scan import DEFAULT_GRID

    return "{}x{}".format(*DEFAULT_GRID)


def _default_pose() -> str:
    from wm3d.scanner import POSES

    return next(iter(POSES))


def attack(
    source: SourceMesh,
    target: Annotated[
        Path, typer.Argument(metavar="OUT", help="Attacked mesh; its ending names the format.")
    ],
    name: Annotated[str, typer.Argument(metavar="NAME", help="One of `wm3d list attacks`.")],
    pairs: Parameters = None,
    *,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of the attack's random draws.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Attack a mesh as experiments do.

    The same seed gives the same mesh.

    The object of --json has the fields attack, seed, original, attacked, vertices, faces (each before and
    after), and sigma_percent, of noise: its standard deviation per axis in percent of the diagonal.

    Example: wm3d attack marked.ply noisy.ply gaussian-noise percent=0.6

    Example: wm3d attack marked.ply half.ply simplify simplifier=clustering
    """
    import numpy as np

    from wm3d.attacks import ATTACKS, Chain, Noise
    from wm3d.mesh import ENDINGS, Mesh, check_target, decode_mesh, encode_mesh, write_whole

    if Path(name).suffix.lower() in ENDINGS:
        raise Wm3dError(f"{name}: stands where the name of an attack belongs; the order is IN OUT NAME.")
    chosen = ATTACKS.build(name, assignments(pairs or ()))
    if chosen == Chain():
        raise Wm3dError(
            f"{name}: chains no attacks; name them, as in 'then=[{{name: mirror}}, {{name: weld}}]'."
        )
    keep_original(source, target, "attacked mesh")
    check_target(target)
    mesh = read_mesh(source)
    try:
        attacked = chosen(mesh, np.random.default_rng(seed))
    except Wm3dError as error:  # the mesh itself was fine
        raise Wm3dError(str(error) if name in str(error) else f"{name}: {error}") from error
    if not isinstance(attacked, Mesh):
        raise Wm3dError(f"{name}: returned a {type(attacked).__name__} in place of a mesh; mend that attack.")
    content = encode_mesh(attacked, target)
    write_whole(target, content)
    written = decode_mesh(content, target)  # STL has three vertices a face
    vertices = len(mesh.vertices), len(written.vertices)
    faces = len(mesh.faces), len(written.faces)
    sigma = chosen.sigma_percent(mesh) if isinstance(chosen, Noise) else None
    if as_json:
        what = {"attack": chosen.label(), "seed": seed, "original": source, "attacked": str(target)}
        print_json({**what, "vertices": vertices, "faces": faces, "sigma_percent": sigma})
        return
    typer.echo(f"{source} -> {target}: {chosen.label()}")
    typer.echo("vertices {} -> {}".format(*vertices))
    typer.echo("faces    {} -> {}".format(*faces))
    if sigma is not None:
        typer.echo(f"sigma per axis: {sigma:.4g} % of the diagonal of the bounding box")


def scan(
    source: SourceMesh,
    target: Annotated[
        Path,
        typer.Argument(
            metavar="OUT", help="OUT.png, a picture, or OUT.npy, ranges in mesh units as float64 (N_u, N_v)."
        ),
    ],
    *,
    grid: Annotated[
        str,
        typer.Option(
            metavar="NVxNU",
            help="Columns around x rows along the axis.",
            default_factory=Late(_default_grid),
        ),
    ],
    pose: Annotated[
        str,
        typer.Option(metavar="NAME", help="One of `wm3d list poses`.", default_factory=Late(_default_pose)),
    ],
) -> None:
    """Draw or store the range image of a mesh.

    The picture has the columns around the axis from left to right and the rows along it from bottom to top,
    ranges in units of the cylinder's radius r, and rays that meet nothing in grey. In the .npy file row 0 is
    the bottom row and such rays are NaN.

    Example: wm3d scan bunny bunny.png --grid 360x240
    """
    import numpy as np

    from wm3d.mesh import check_target, write_whole
    from wm3d.scanner import POSES
    from wm3d.scanner import scan as scan_mesh

    ending = target.suffix.lower()
    if ending not in (".png", ".npy"):
        raise Wm3dError(f"{target}: a range image is written as .png or .npy; give one of these endings.")
    if pose not in POSES:
        raise Wm3dError(f"--pose {pose}: there is no such pose; known: {', '.join(POSES)}.")
    size = grid_size(grid)
    keep_original(source, target, "range image")
    check_target(target)
    mesh = read_mesh(source)
    image = scan_mesh(mesh, size, POSES[pose]()(mesh))
    missed = float(np.isnan(image.ranges).mean())
    if missed == 1:
        raise Wm3dError(f"{source}: no ray meets a face from the front; the mesh must enclose its own axis.")
    content = _picture(image, Path(source).name) if ending == ".png" else _array(image)
    write_whole(target, content)
    cylinder = image.cylinder
    typer.echo(
        f"{source} -> {target}: {size[0]} columns x {size[1]} rows, {missed:.1%} of the rays meet nothing"
    )
    typer.echo(f"cylinder: r = {cylinder.radius:.6g}, h = {cylinder.height:.6g} in mesh units")


def _picture(image: "RangeImage", title: str) -> bytes:
    from wm3d.cli.picture import range_picture

    return range_picture(image, title)


def _array(image: "RangeImage") -> bytes:
    import numpy as np

    stream = io.BytesIO()
    np.save(stream, image.ranges, allow_pickle=False)
    return stream.getvalue()
