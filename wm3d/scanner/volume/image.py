"""The volume image: what a cylindrical scanner reads that sees through the model to its axis."""

import math
import sys
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array, csr_array, vstack

from wm3d.arrays import FloatArray, IntArray
from wm3d.scanner.volume import kernels
from wm3d.threads import by_halves

SAMPLES = 1.5
"""Parts of a face along its longer side, per cell of the image that it spans; more for coarse meshes gain
little."""

MOST_POINTS, POINTS_A_FACE = 15_000_000, 48
"""At how many points half of a mesh is read, and at how many more for each face: nine times what the Buddha
of 300k faces takes under any noise that leaves its mark. A mesh so crumpled that its faces span the cylinder
would take minutes; it is read at fewer points."""

JACOBIAN_SAMPLES = 0.5
"""The same for the Jacobian, which is only climbed on: what was embedded is read from the image itself."""


@dataclass(frozen=True, eq=False)
class VolumeImage:
    """Volume and surface behind each cell of a cylinder's grid.

    Attributes
    ----------
    volumes : (N_u, N_v) ndarray
        Volume of the solid in each cell, the wedge from the axis outwards, in cubed units.
    areas : (N_u, N_v) ndarray
        Area of the surface in each cell, in squared units: how fast the volume grows when the surface moves
        along its normals.
    """

    volumes: FloatArray
    areas: FloatArray


def volume_image(
    posed: FloatArray, faces: IntArray, grid: tuple[int, int], hmin: float, height: float, outward: int
) -> VolumeImage:
    """Return how much of a solid lies in each cell around the axis.

    By the divergence theorem the volume under a weight φ(θ, h) is ∮ φ (ρ/2) e_ρ·n dA, with the distance ρ
    from the axis: every face adds what lies behind it, with its sign. So where a ray meets several surfaces
    all of them count, a crumple counts in proportion to its volume and not to its tips, and for small moves
    δ of the surface the image changes by ∫ φ δ·n dA, whatever the triangles are.

    Parameters
    ----------
    posed : (n, 3) ndarray
        Vertices along s1, s2, s3 of a left-handed frame whose first axis is the cylinder's.
    faces : (m, 3) ndarray
    grid : tuple of int
        (N_v, N_u): columns around, rows along the axis.
    hmin, height : float
        Lower end and height of the cylinder, in the unit of `posed`.
    outward : int
        +1 where faces are wound counter-clockwise seen from outside, −1 for an inward-wound mesh.

    Notes
    -----
    φ is the cosine weight of eqs. 10 and 11 of the paper, so a cell shades off into its neighbours. Faces are
    cut into equal parts no larger than a cell (`SAMPLES`; near the axis than a cell further out,
    `kernels.SLIVER`), and each is integrated by three points.
    """
    columns, rows = grid
    most = MOST_POINTS + POINTS_A_FACE * len(faces)

    def dealt(samples: float, most: int) -> tuple[FloatArray, FloatArray, int]:
        cylinder = rows, columns, hmin, height, samples, most
        one, other = by_halves(lambda half: kernels.deposit(posed, half, *cylinder), faces)
        return one[0] + other[0], one[1] + other[1], max(one[2], other[2])

    volumes, areas, points = dealt(SAMPLES, most)
    if points > most:
        volumes, areas, _ = dealt(SAMPLES * math.sqrt(most / points), sys.maxsize)
    return VolumeImage(-outward * volumes, areas)  # minus: s1, s2, s3 are left-handed


def volume_jacobian(
    posed: FloatArray,
    faces: IntArray,
    directions: FloatArray,
    grid: tuple[int, int],
    hmin: float,
    height: float,
    outward: int,
) -> csc_array:
    """Return how the volumes of `volume_image` grow when vertices move along given directions.

    A cell grows by ∮ φ β d·n dA with the move of a vertex, whose tent function is β and whose direction is d
    (but for what the rim of an open mesh adds).

    Parameters
    ----------
    posed, faces, grid, hmin, height, outward
        As for `volume_image`.
    directions : (n, 3) ndarray
        Of the vertices, in the unit of `posed` for a move of 1.

    Returns
    -------
    (N_u · N_v, n) sparse array
        Of the cells, in the order of `VolumeImage.volumes`, by the vertices.
    """
    columns, rows = grid
    cylinder = rows, columns, hmin, height, JACOBIAN_SAMPLES
    halves = by_halves(lambda half: kernels.differentiate(posed, half, directions, *cylinder), faces)
    cells, vertices, values = (np.concatenate(both) for both in zip(*halves, strict=True))
    n, width = len(posed), rows * columns
    values *= -outward
    by_vertex = by_halves(
        lambda of: _rows(kernels.gathered(cells, vertices, values, of[0], of[-1] + 1, width), width),
        np.arange(n),
    )
    jacobian: csc_array = vstack(by_vertex, format="csr").T
    return jacobian


def _rows(csr: tuple[FloatArray, IntArray, IntArray], width: int) -> csr_array:
    data, indices, starts = csr
    if starts[-1] <= np.iinfo(indices.dtype).max:  # else SciPy would make the indices as wide: slower
        starts = starts.astype(indices.dtype)
    return csr_array((data, indices, starts), shape=(len(starts) - 1, width))


def volume_image_reference(
    posed: FloatArray, faces: IntArray, grid: tuple[int, int], hmin: float, height: float, outward: int
) -> VolumeImage:
    """Plain numpy twin of `volume_image`, with sixteen points a side of every face."""
    columns, rows = grid
    parts = 16
    i, j = (index.ravel() for index in np.meshgrid(np.arange(parts), np.arange(parts), indexing="ij"))
    upright, turned = i + j < parts, i + j < parts - 1
    s = np.concatenate([(i[upright] + 1 / 3) / parts, (i[turned] + 2 / 3) / parts])
    t = np.concatenate([(j[upright] + 1 / 3) / parts, (j[turned] + 2 / 3) / parts])
    a, b, c = (posed[faces[:, k]][:, None] for k in range(3))
    points = a + s[:, None] * (b - a) + t[:, None] * (c - a)
    cross = np.cross(b - a, c - a)
    flux = -outward * (points[..., 1:] * cross[..., 1:]).sum(axis=-1) / 4 / parts**2
    area = np.broadcast_to(np.linalg.norm(cross, axis=-1) / 2 / parts**2, flux.shape)
    u = (points[..., 0] - hmin) / height * rows - 0.5
    v = np.arctan2(points[..., 1], points[..., 2]) / (2 * np.pi) * columns
    image = VolumeImage(np.zeros((rows, columns)), np.zeros((rows, columns)))
    for row in (np.floor(u), np.floor(u) + 1):
        for column in (np.floor(v), np.floor(v) + 1):
            weight = (0.5 + 0.5 * np.cos(np.pi * (u - row))) * (0.5 + 0.5 * np.cos(np.pi * (v - column)))
            inside = (row >= 0) & (row < rows)
            cell = row[inside].astype(int), column[inside].astype(int) % columns
            np.add.at(image.volumes, cell, (weight * flux)[inside])
            np.add.at(image.areas, cell, (weight * area)[inside])
    return image
