"""Take one ingredient at a time out of range-dct; writes results/range_dct/ablation.csv.

    WM3D_DATA=folder-with-the-meshes python experiments/ablation.py [--keys 20]

Without one of them the scheme is otherwise the same, at the same SNR, on the same keys and the same noise.
"""

import argparse
import math
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pandas as pd

from wm3d.arrays import FloatArray
from wm3d.attacks import ATTACKS, Attack
from wm3d.imagemarks import shaped_dct
from wm3d.mesh import Mesh, SolidMoments, datasets, write_whole
from wm3d.scanner import VertexPca, denoise, kernels
from wm3d.scanner.affine import AffineFrame
from wm3d.scanner.registration import Fit, register
from wm3d.scanner.volume import VolumeImage, volume_image
from wm3d.schemes import informed, range_dct, volume_host, volume_reference

MODELS = {"bunny-closed": 0.63, "happy-buddha-300k": 0.33}
ATTACKED: list[tuple[str, dict[str, Any]]] = [
    ("clean", {}),
    ("gaussian-noise", {"percent": 0.6, "amplitude": "rms-vector"}),
    ("gaussian-noise", {"percent": 0.6, "amplitude": "per-axis"}),
    ("simplify", {"ratio": 0.5, "simplifier": "fast-simplification"}),
    ("simplify", {"ratio": 0.1, "simplifier": "fast-simplification"}),
    ("stretch", {"percent": 10, "axis": "x"}),
    ("bend", {"degrees": 10}),
    ("crop", {"percent": 10}),
    ("crop", {"percent": 30}),
    ("chain", {"then": [{"name": "crop", "percent": 30}, {"name": "similarity"}]}),
]
VERSION = range_dct.RangeDct.version
TABLE = Path(__file__).resolve().parent.parent / "results" / "range_dct" / "ablation.csv"


def pca_frame(mesh: Mesh) -> AffineFrame:
    """Return the paper's pose, `VertexPca`, in the unit of its own vertices."""
    cylinder = VertexPca()(mesh)
    size = math.sqrt(((mesh.vertices - mesh.vertices.mean(axis=0)) ** 2).sum(axis=1).mean())
    return AffineFrame(cylinder.center, cylinder.axes / size)


def in_pca_frame(mesh: Mesh, _reference: SolidMoments, _ways: int) -> tuple[Mesh, list[AffineFrame]]:
    """Return a mesh and its `pca_frame`."""
    return mesh, [pca_frame(mesh)]


def pose_alone(suspect: Any, **_search: bool) -> Fit:
    """Return the pose that the moments give."""
    return Fit(suspect.poses[0], 1.0)


def no_starts(*_search: Any) -> list[Fit]:
    """Return what a search finds that looks nowhere."""
    return []


def first_surface(
    posed: FloatArray, faces: Any, grid: tuple[int, int], hmin: float, height: float, outward: int
) -> VolumeImage:
    """Return the volume behind the first surface that the ray of each cell meets, as if all were solid."""
    columns, rows = grid
    planes = hmin + (np.arange(rows) + 0.5) * (height / rows)
    radius = float(np.hypot(posed[:, 1], posed[:, 2]).max())
    ranges = kernels.cast(posed, faces, planes, columns, radius, outward)
    distance = np.where(np.isnan(ranges), 0.0, radius - ranges)
    cell = height / rows * 2 * np.pi / columns
    areas = volume_image(posed, faces, grid, hmin, height, outward).areas
    return VolumeImage(0.5 * np.sign(distance) * distance**2 * cell, areas)


def unsettled(
    _host: volume_host.Host, _fine: Any, _signs: Any, along: FloatArray, _size: float
) -> FloatArray:
    """Return the moves as they are."""
    return along


def frequency_scale(received: FloatArray) -> FloatArray:
    """Return a scale for each frequency alone, the same in all blocks, as the paper's detector has it."""
    return np.broadcast_to(np.abs(received).mean(axis=0), received.shape).copy()


def linear(y: FloatArray, a: FloatArray, scale: FloatArray) -> FloatArray:
    """Return the correlation with the mark, in place of the expected sign."""
    return np.divide(a * y, scale**2, out=np.zeros_like(y), where=scale > 0)


def no_offset(scheme: range_dct.RangeDct) -> range_dct.RangeDct:
    """Return the scheme for a frame whose origin is not the solid's centroid."""
    assert scheme.reference is not None
    return scheme.model_copy(update={"reference": scheme.reference.model_copy(update={"offset": (0, 0, 0)})})


WITHOUT: dict[str, list[Any]] = {
    "nothing (range-dct as it is)": [],
    "landmarks: the pose as the moments give it": [
        patch.object(volume_reference._Suspect, "registered", pose_alone)
    ],
    "search: the poses by the moments, fitted": [patch.object(register, "_searched", no_starts)],
    "landmarks and moments: vertex-PCA pose": [
        patch.object(volume_reference._Suspect, "registered", pose_alone),
        patch.object(volume_host, "principal_frame", pca_frame),
        patch.object(volume_reference, "recognized", in_pca_frame),
    ],
    "volumes and informed embedding: first surface of one ray a cell": [
        patch.object(volume_host, "volume_image", first_surface),
        patch.object(informed, "STEPS", 0),
    ],
    "smoothing of crumpled surfaces": [patch.object(denoise, "CRUMPLED", math.inf)],
    "block activity: scale by frequency": [patch.object(shaped_dct, "activity_scale", frequency_scale)],
    "shaping: all amplitudes equal": [patch.object(shaped_dct, "SHAPING", 0.0)],
    "cells as fine as the mesh: 100 blocks": [patch.object(volume_host, "MOST_BLOCKS", 100)],
    "fine signs": [patch.object(range_dct, "settled_moves", unsettled)],
    "informed embedding: the pattern as it is": [patch.object(informed, "STEPS", 0)],
    "scale of the host: that of what is received": [patch.object(shaped_dct, "_UNMIXINGS", 0)],
    "expected signs and scale of the host: linear detector": [
        patch.object(shaped_dct, "_UNMIXINGS", 0),
        patch.object(shaped_dct, "_expected_sign", linear),
    ],
}


@contextmanager
def without(patches: list[Any]) -> Iterator[None]:
    """Apply patches for a while."""
    with ExitStack() as stack:
        for change in patches:
            stack.enter_context(change)
        yield


def measured(
    mesh: Mesh, alpha: float, attacks: list[Attack], keys: int, *, posed_by_vertices: bool
) -> FloatArray:
    """Return z of each key after each attack: (attacks, keys)."""
    z = np.empty((len(attacks), keys))
    for key in range(keys):
        marked, scheme = range_dct.RangeDct(alpha=alpha).embed(mesh, key)
        if posed_by_vertices:
            scheme = no_offset(scheme)
        for line, attack in enumerate(attacks):
            z[line, key] = scheme.score(attack(marked, np.random.default_rng(key)), key).z
    return z


def main(keys: int) -> None:
    attacks = [ATTACKS.build(name, parameters) for name, parameters in ATTACKED]
    lines = []
    for name, alpha in MODELS.items():
        for ingredient, patches in WITHOUT.items():
            mesh = datasets.load(name)  # anew: a scheme keeps what it found in the last one
            with without(patches):
                z = measured(mesh, alpha, attacks, keys, posed_by_vertices="vertex-PCA" in ingredient)
            for attack, found in zip(attacks, z, strict=True):
                mean, error = found.mean(), found.std(ddof=1) / math.sqrt(keys)
                lines.append(
                    (name, ingredient, attack.label(), keys, round(mean, 2), round(error, 2), VERSION)
                )
                print(f"{name:18s}{ingredient:42s}{attack.label():36s}{mean:7.1f} ± {error:.1f}", flush=True)
    columns = ["mesh", "without", "attack", "keys", "z_mean", "standard_error", "version"]
    write_whole(TABLE, pd.DataFrame(lines, columns=columns).to_csv(index=False).encode())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--keys", type=int, default=20)
    main(**vars(parser.parse_args()))
