"""Mesh structural distortion: MSDM for the same vertices, MSDM2 for any connectivity.

Both compare the curvature of two surfaces in windows, as SSIM does images. Curvatures are multiplied by, and
radii are in units of, the largest side of the axis-aligned bounding box: so both metrics keep exactly under
translation, scale and quarter turns, and nearly under any other rotation.
"""

from typing import NamedTuple

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh import Mesh, sewn
from wm3d.metrics.perceptual import kernels
from wm3d.metrics.perceptual.connectivity import Connectivity
from wm3d.metrics.perceptual.curvature import mean_absolute_curvature
from wm3d.metrics.snr import check_same_vertices
from wm3d.metrics.surface import Nearest, Surface, check_size, tree_order

SCALES = (0.002, 0.003, 0.004)
"""Radii of the balls of the curvature of MSDM2, over the largest side of the bounding box."""

MSDM_SCALE = 0.003
"""That radius for MSDM, whose paper leaves it open: the middle one of MSDM2."""

WINDOW = 5
"""Radius of the windows over that of the curvature."""

POOLING = 3
"""Exponent of the Minkowski mean over the vertices."""


def msdm(original: Mesh, other: Mesh) -> float:
    """Mesh structural distortion measure of two meshes with the same vertices, 0 (equal) to about 1.

    At each vertex ((L³ + C³ + S³/2) / 2.5)^⅓, pooled with a Minkowski-3 mean over the vertices (Lavoué et
    al., Proc. SPIE 6312, 2006). The windows are those of the original.

    Raises
    ------
    Wm3dError
        If the meshes do not have the same number of vertices, or one is far too large beside the other.
    """
    check_same_vertices("MSDM", original, other)
    a, b = _sides(original, other, same_order=True)
    x, y = a.curvature(MSDM_SCALE), b.curvature(MSDM_SCALE)
    return _pool(a.distortion(x, y, MSDM_SCALE, exponent=3)[a.connectivity.used])


def msdm2(original: Mesh, other: Mesh) -> float:
    """Multiscale mesh structural distortion measure of two surfaces, 0 (equal) to about 1; symmetric.

    Each vertex of one surface is compared with the nearest point of the other by (L + C + S/2) / 2.5,
    averaged over three scales, and pooled with a Minkowski-3 mean over the vertices; then the two directions
    are averaged (Lavoué, Computer Graphics Forum 30(5), 2011).

    Raises
    ------
    Wm3dError
        If one surface is far too large beside the other.
    """
    a, b = _sides(original, other)
    on_b, on_a = b.surface().nearest(a.vertices), a.surface().nearest(b.vertices)
    there, back = np.zeros(len(a.vertices)), np.zeros(len(b.vertices))
    for scale in SCALES:
        x, y = a.curvature(scale), b.curvature(scale)
        there += a.distortion(x, b.carry(y, on_b), scale, exponent=1) / len(SCALES)
        back += b.distortion(y, a.carry(x, on_a), scale, exponent=1) / len(SCALES)
    return (_pool(there[a.connectivity.used]) + _pool(back[b.connectivity.used])) / 2


class Terms(NamedTuple):
    """Differences in mean (L), in standard deviation (C) and in structure (S) of a window, (n,) each."""

    L: FloatArray
    C: FloatArray
    S: FloatArray


def terms(statistics: FloatArray) -> Terms:
    """Return L, C and S of windows from means, variances and covariances (n, 5) of x and y."""
    mean_x, mean_y, variance_x, variance_y, covariance = statistics.T
    sigma_x, sigma_y = np.sqrt(variance_x), np.sqrt(variance_y)
    product = sigma_x * sigma_y
    return Terms(
        np.abs(mean_x - mean_y) / (np.maximum(mean_x, mean_y) + 1),
        np.abs(sigma_x - sigma_y) / (np.maximum(sigma_x, sigma_y) + 1),
        np.abs(product - covariance) / (product + 1),
    )


class _Side:
    """One of the two meshes, in units of the largest side of the larger bounding box.

    Its vertices are in an order that puts neighbours near each other in memory: the walks over the windows
    are then three times as fast.
    """

    def __init__(self, mesh: Mesh, origin: FloatArray, unit: float, order: IntArray) -> None:
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        self.vertices, self.faces = (mesh.vertices[order] - origin) / unit, place[mesh.faces]
        self.connectivity = Connectivity(self.faces, len(self.vertices))

    def surface(self) -> Surface:
        return Surface(self.vertices, self.faces)

    def curvature(self, scale: float) -> FloatArray:
        return mean_absolute_curvature(self.vertices, self.faces, self.connectivity, scale)

    def carry(self, curvature: FloatArray, points: Nearest) -> FloatArray:
        """Interpolate a curvature of this side at points of its surface."""
        corners = curvature[points.vertices]
        carried: FloatArray = (corners * points.weights).sum(axis=1)
        return carried

    def distortion(self, x: FloatArray, y: FloatArray, scale: float, exponent: int) -> FloatArray:
        first, vertex, _ = self.connectivity.neighbours
        values = np.column_stack([x, y])
        statistics = kernels.window_statistics(self.vertices, first, vertex, values, WINDOW * scale)
        differences = terms(statistics)
        total = differences.L**exponent + differences.C**exponent + differences.S**exponent / 2
        local: FloatArray = (total / 2.5) ** (1 / exponent)
        return local


def _sides(original: Mesh, other: Mesh, same_order: bool = False) -> tuple[_Side, _Side]:
    check_size(original, other)  # windows in the unit of the larger mesh would hold all of the smaller
    check_size(other, original)
    original, place = sewn(original)
    other = sewn(other).mesh if not same_order else _folded(other, place, original)
    origin = original.middle
    unit = float(max(np.ptp(mesh.vertices[mesh.used], axis=0).max() for mesh in (original, other)))
    orders = [tree_order(mesh.vertices) for mesh in (original, original if same_order else other)]
    return _Side(original, origin, unit, orders[0]), _Side(other, origin, unit, orders[1])


def _folded(mesh: Mesh, place: IntArray, onto: Mesh) -> Mesh:
    """Give a mesh the vertices of another that it has at the seams, too; (n,) `place` says which."""
    if len(onto.vertices) == len(mesh.vertices):
        return mesh
    vertices = np.empty_like(onto.vertices)
    vertices[place] = mesh.vertices
    return Mesh(vertices, onto.faces, mesh.name)


def _pool(local: FloatArray) -> float:
    return float((local**POOLING).mean() ** (1 / POOLING))
