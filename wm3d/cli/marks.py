"""`wm3d embed` and `wm3d detect`: mark one mesh, and look for a mark in one mesh."""

import math
from pathlib import Path
from typing import Annotated

import typer

from wm3d.cli.marked import MarkedFiles, default_pf, evidence, kept_key, score_fields
from wm3d.cli.options import (
    AsJson,
    Late,
    Parameters,
    SourceMesh,
    assignments,
    grid_size,
    keep_original,
    read_mesh,
    region_corners,
    same_file,
)
from wm3d.cli.output import print_json
from wm3d.errors import Wm3dError


def embed(
    source: SourceMesh,
    target: Annotated[Path, typer.Argument(metavar="OUT", help="Marked mesh; its ending names the format.")],
    pairs: Parameters = None,
    *,
    key: Annotated[
        Path,
        typer.Option(metavar="KEY.json", help="Where the key is written: the secret and the parameters."),
    ],
    scheme: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="One of `wm3d list schemes`.",
            show_default="range-dct; song2002 with a grid, a region, miss= or normalize=",
        ),
    ] = None,
    seed: Annotated[
        int | None,
        typer.Option(metavar="N", help="The secret, below 2^256.", show_default="random bits"),
    ] = None,
    alpha: Annotated[
        float | None,
        typer.Option(
            metavar="A",
            help="The parameter alpha: the strength of the mark, but in wang2011 (step=).",
            show_default="the scheme's",
        ),
    ] = None,
    snr: Annotated[
        float | None,
        typer.Option(metavar="DB", help="Find the strength that gives this SNR in dB, instead of --alpha."),
    ] = None,
    grid: Annotated[
        str | None,
        typer.Option(
            metavar="NVxNU",
            help="Columns around x rows along the axis; rows x sectors for wang2011.",
            show_default="the scheme's",
        ),
    ] = None,
    region: Annotated[
        str | None,
        typer.Option(
            metavar="U0,V0,NU,NV",
            help="Marked rectangle of the grid: first row, first column, rows, columns.",
            show_default="the scheme's",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Mark a mesh and write its key.

    What detection finds in the file as written is printed. Both OUT and KEY.json are written, or neither;
    existing files are replaced, but another key is kept beside the new one. Vertices and faces are kept,
    colours and textures are not. Detection needs the key, and the original only where the scheme is not
    blind: keep the key, and keep it secret.

    The object of --json has the fields scheme, snr_db, original, marked, key, and those of `wm3d detect`
    that tell of the file as written: detected, p_value, log10_p, z, statistic, threshold_pf. An infinite SNR,
    where the format rounds the mark away, is null.

    Example: wm3d embed bunny marked.ply --key key.json --snr 44

    Example: wm3d embed horse.ply marked.ply --key key.json --scheme song2002 --grid 84x84
    """
    from wm3d.api import default_scheme
    from wm3d.api import embed as mark
    from wm3d.mesh import check_target, decode_mesh, encode_mesh, write_together
    from wm3d.metrics import snr as measured_snr
    from wm3d.schemes import SCHEMES

    parameters = assignments(
        pairs or (),
        alpha=alpha,
        grid=None if grid is None else grid_size(grid),
        region=None if region is None else region_corners(region),
    )
    chosen = SCHEMES.build(scheme or default_scheme(parameters), parameters)
    if snr is not None and chosen.strength in parameters:
        raise Wm3dError(f"{chosen.strength} and --snr both set the strength of the mark; give one of them.")
    _keep_apart(key, source, target)
    for file in (target, key):
        check_target(file)
    mesh = read_mesh(source)
    marked, its_key = mark(mesh, seed=seed, scheme=chosen, snr=snr)
    content = encode_mesh(marked, target)
    written = decode_mesh(content, target, name=str(target))
    score = its_key.score(written)
    kept = kept_key(key, its_key.encode())
    write_together({**kept, target: content, key: its_key.encode()})
    for place in kept:
        typer.echo(f"wm3d: {key}: held another key, which is kept as {place}.", err=True)

    compared = written if len(written.vertices) == len(mesh.vertices) else marked  # STL has three a face
    before = score if score.detected() else its_key.score(marked)
    decibels = measured_snr(mesh, compared)
    told = MarkedFiles(source, target, key, its_key.scheme, decibels, before, score)
    told.print(as_json=as_json)


def detect(
    mesh: Annotated[str, typer.Argument(metavar="MESH", help="Mesh file, or a name of `wm3d data list`.")],
    *,
    key: Annotated[Path, typer.Option(metavar="KEY.json", help="The key that `wm3d embed` wrote.")],
    pf: Annotated[
        float,
        typer.Option(
            metavar="PF",
            help="False-alarm probability: a p-value at or below it is a detection.",
            default_factory=Late(default_pf),
        ),
    ],
    original: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="The mesh before it was marked, for a scheme that is not blind."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Look for the mark of a key in a mesh.

    A blind scheme does not need the original mesh. The p-value is the probability that a random key does as
    well as this one on the same mesh. Exit status 0: the mark is found; 1: it is not.

    The object of --json has the fields detected, p_value, log10_p, z, statistic, threshold_pf, scheme, mesh.
    A p-value below 1e-323 prints as 0 while log10_p still tells it; log10_p is null where p itself is 0.

    Example: wm3d detect suspect.ply --key key.json --pf 1e-8
    """
    from wm3d.registry import component_name
    from wm3d.schemes import Key
    from wm3d.stats.rademacher import checked_pf

    checked_pf(pf)  # before the mesh is read
    its_key = Key.load(key)
    if original is not None:
        its_key = its_key.with_original(read_mesh(original))
        if its_key.scheme.blind:
            blind = component_name(type(its_key.scheme))
            typer.echo(f"wm3d: {original}: is not looked at, for {blind} is a blind scheme.", err=True)
    score = its_key.score(read_mesh(mesh))
    detected = score.detected(pf)
    if as_json:
        print_json({**score_fields(score, pf), "scheme": component_name(type(its_key.scheme)), "mesh": mesh})
    else:
        verdict = "carries the mark" if detected else "shows no mark"
        typer.echo(f"{mesh} {verdict} of {key} at Pf = {pf:g}: {evidence(score)}")
        if score.null.log10_p_least > math.log10(pf):
            typer.echo(
                "Not even the right key could reach this Pf: too few coefficients of the mesh are read."
            )
    if not detected:
        if its_key.version not in (None, its_key.scheme.version):
            typer.echo(
                f"wm3d: {key}: was written for version {its_key.version} of its scheme, which is at "
                f"{its_key.scheme.version} now and may read otherwise; try the wm3d that wrote it.",
                err=True,
            )
        raise typer.Exit(1)


def _keep_apart(key: Path, source: str, target: Path) -> None:
    """Refuse a key that would overwrite a mesh, and a marked mesh that would overwrite its original."""
    from wm3d.mesh import ENDINGS, datasets

    if key.suffix.lower() in ENDINGS:
        raise Wm3dError(f"{key}: has the ending of a mesh; give the key a name of its own, such as key.json.")
    if same_file(key, target) or same_file(key, datasets.locate(source)):
        raise Wm3dError(f"{key}: is the key and a mesh as well; give the key a name of its own.")
    keep_original(source, target, "marked mesh")
