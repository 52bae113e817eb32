"""The metrics by name, and all of them at once."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, places
from wm3d.metrics.metric import Metric
from wm3d.metrics.perceptual import msdm, msdm2
from wm3d.metrics.psnr import psnr
from wm3d.metrics.snr import snr
from wm3d.metrics.surface import hausdorff, mrms, normal_deviation
from wm3d.metrics.volume import volume_change

METRICS: dict[str, Metric] = {
    "snr": Metric(snr, unit="db", same_vertices=True),
    "psnr": Metric(psnr, unit="db", same_vertices=True),
    "hausdorff": Metric(hausdorff, unit="mesh_units"),
    "mrms": Metric(mrms, unit="mesh_units"),
    "normal-deviation": Metric(normal_deviation, unit="deg"),
    "volume-change": Metric(volume_change, unit="percent"),
    "msdm": Metric(msdm, same_vertices=True),
    "msdm2": Metric(msdm2),
}

SHUFFLED = 1.5
"""Pairs of places, over places, from which the vertices of two meshes are in different orders."""


class Measurement(NamedTuple):
    """A number of a comparison, named with its unit; or None and why there is no number."""

    name: str
    value: float | None
    reason: str


def compare(original: Mesh, other: Mesh) -> dict[str, float | None]:
    """Return all metrics of two meshes.

    Returns
    -------
    dict
        From name with unit, for example "hausdorff_mesh_units", to value; None where a metric is not defined
        for the two meshes. Lengths are given a second time in percent of the diagonal of the original's
        bounding box.
    """
    return {measurement.name: measurement.value for measurement in measure(original, other)}


def measure(original: Mesh, other: Mesh) -> list[Measurement]:
    """Return all metrics of two meshes, each with the reason where there is no number."""
    same = _same_vertices(original, other)
    return [
        measurement
        for name, metric in METRICS.items()
        for measurement in _measurements(name.replace("-", "_"), metric, original, other, same=same)
    ]


def _same_vertices(original: Mesh, other: Mesh) -> bool:
    """Tell whether two meshes have as many vertices, and most of the faces of one name the same ones.

    Faces may be missing, turned over, added or in another order; vertices in another order are others. Those
    of unwelded files are told by which of them lie in one place.
    """
    if original.vertices.shape != other.vertices.shape:
        return False
    here, there = (places(mesh.vertices) for mesh in (original, other))
    pairs = len(np.unique(here.place * len(there.first) + there.place))
    if pairs > SHUFFLED * max(len(here.first), len(there.first)):
        return False
    one, two = (np.unique(np.sort(mesh.faces, axis=1), axis=0) for mesh in (original, other))
    common = len(one) + len(two) - len(np.unique(np.vstack([one, two]), axis=0))
    return common > min(len(one), len(two)) / 2


def _measurements(
    name: str, metric: Metric, original: Mesh, other: Mesh, *, same: bool
) -> Iterator[Measurement]:
    value, reason = None, ""
    if metric.same_vertices and not same:
        reason = "needs the same vertices in the same order"
    else:
        try:
            value = metric(original, other)
        except Wm3dError as error:
            reason = str(error)
    yield Measurement(f"{name}_{metric.unit}".rstrip("_"), value, reason)
    if metric.unit == "mesh_units":
        percent = None if value is None else 100 * value / original.diagonal
        yield Measurement(f"{name}_percent_of_diagonal", percent, reason)
