"""The radial scheme on the surface instead of its vertices, after Rolland-Nevière, Doërr and Alliez.

"Triangle Surface Mesh Watermarking Based on a Constrained Optimization Framework", IEEE Transactions on
Information Forensics and Security 9(9), 2014: what Cho, Prost and Jung take over vertices is taken over area.
"""

from typing import Annotated, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field
from scipy import sparse

from wm3d.arrays import FloatArray, IntArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, face_areas, has_area, sewn, surface_area
from wm3d.schemes.radial import MEAN, Moment, RadialScheme, Spread, kernels

SPACING = 0.006
"""Longest edge of a sampled part of a face, over the root of the area: about a bin on compact shapes."""

MOST_PARTS = 256
"""Parts of an edge at most."""

MOST_POINTS = 10_000_000
"""Sampled parts of all faces at most: half a gigabyte. Compact shapes have some hundred thousand."""

MOST_LOST = 0.25
"""Share of the bits beyond which a mesh whose faces are too large for the bins is refused."""

_STEPS = 5  # of Newton; more gain nothing
_BORDER = 0.15  # of a bin: density at its border is taken over as much on either side
_DAMPING = 1e-3  # of the diagonal of J Jᵀ: bins with little area do not pull far


class _Surface(NamedTuple):
    """Points of a surface: their `Spread`, the face of each (k,), the shares of its corners (k, 3)."""

    spread: Spread
    face: IntArray
    shares: FloatArray


class RadialArea(RadialScheme):
    """Means of the distances of the surface from its centroid, over area, in N equal bins.

    As `cho2007-mean`, with the centroid of the surface for that of the vertices, means over area for means
    over vertices, and quantiles over area for the least and the greatest distance: none of them depends on
    where the vertices lie on the surface, so remeshing and simplification leave them nearly alone. As in the
    paper, vertices move along their rays by the least sum of squares that meets the wanted means; here by
    Newton's method on the means as the detector reads them, without the paper's limits on single moves.

    Attributes
    ----------
    alpha : float
        α: means are brought to at least ½ + α or at most ½ − α, in as far as the faces are small beside the
        bins; a mean that is there already is kept.
    tail : float
        Share of the area below the range of the bins, and above it.
    """

    name: Literal["radial-area"] = "radial-area"
    moment: ClassVar[Moment] = MEAN

    alpha: Annotated[float, Field(gt=0, lt=0.5)] = 0.05
    tail: Annotated[float, Field(ge=0, lt=0.5)] = 0.01

    def spread(self, mesh: Mesh) -> Spread:
        """Return distances of points all over the surface, weighted by N times their share of the area."""
        return self._surface(mesh).spread

    def _surface(self, mesh: Mesh) -> _Surface:
        area = surface_area(mesh)
        if not has_area(mesh):
            raise Wm3dError(f"{mesh.name}: its faces have no area, over which this scheme takes its means.")
        center = area_centroid(mesh)
        parts = kernels.cuts(mesh.vertices, mesh.faces, SPACING * np.sqrt(area), MOST_PARTS)
        points = int((parts**2).sum())
        if points > MOST_POINTS:
            raise Wm3dError(
                f"{mesh.name}: its faces are so long and thin that they take {points} sample points, "
                f"more than {MOST_POINTS}; remesh it to rounder faces, or use another scheme."
            )
        radii, areas, face, shares = kernels.samples(mesh.vertices, mesh.faces, parts, center)
        low, high = quantiles(radii, areas, (self.tail, 1 - self.tail))
        if high - low <= 1e-3 * high:
            raise Wm3dError(
                f"{mesh.name}: its surface is equally far from its centroid all over, so distances cannot "
                "carry a watermark; use a scheme that does without them."
            )
        return _Surface(
            Spread(center, radii, self.bits * areas / areas.sum(), low, high, self.bits), face, shares
        )

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        """Move the vertices along their rays by the least squares that meet the means; see `Scheme.embed`."""
        signs = self.signs(seed)
        given, (mesh, place) = mesh, sewn(mesh)  # no seam is torn
        surface = self._surface(mesh)
        means = surface.spread.moments(self.moment)
        target = self.moment.neutral + self.alpha * signs
        target = np.where(signs * (means - target) > 0, means, target)
        arms = mesh.vertices - surface.spread.center
        distance = np.linalg.norm(arms, axis=1, keepdims=True)
        rays = arms / np.where(distance > 0, distance, 1.0)
        moves, marked = np.zeros(len(rays)), mesh
        for _ in range(_STEPS):
            jacobian = _jacobian(marked, surface, means)
            normal = (jacobian @ jacobian.T).toarray()
            normal[np.diag_indices_from(normal)] *= 1 + _DAMPING
            moves += jacobian.T @ np.linalg.lstsq(normal, target - means)[0]
            marked = mesh.with_vertices(mesh.vertices + moves[:, None] * rays)
            surface = self._surface(marked)
            means = surface.spread.moments(self.moment)
        lost = int((signs * (means - self.moment.neutral) <= 0).sum())
        if lost > MOST_LOST * self.bits:
            raise Wm3dError(
                f"{mesh.name}: its faces are too large for {self.bits} bins: {lost} bits cannot be set; use "
                "fewer bits or a finer mesh."
            )
        return given.with_vertices(marked.vertices[place]), self


def _jacobian(mesh: Mesh, surface: _Surface, means: FloatArray) -> sparse.csr_array:
    """Return d(mean of bin)/d(move of vertex along its ray), (N, n).

    Where the points of a bin move outwards by δ, their t grow by δ / width. Through the border above, area
    leaves with t = 1, and through that below it enters with t = 0; the mean changes by what they are off it.
    """
    spread, bins = surface.spread, surface.spread.bins
    width = (spread.high - spread.low) / bins
    across = (spread.radii - spread.low) / width
    index, border = np.floor(across).astype(np.int64), np.rint(across).astype(np.int64)
    density = (np.abs(across - border) < _BORDER) / (2 * _BORDER)
    filled = spread.counts > 0
    rows, values, points = [], [], []
    for bin_of, change in (
        (index, np.ones(len(across))),
        (border - 1, -(1 - means)[np.clip(border - 1, 0, bins - 1)] * density),
        (border, -means[np.clip(border, 0, bins - 1)] * density),
    ):
        inside = (bin_of >= 0) & (bin_of < bins)
        point = np.flatnonzero(inside & (change != 0) & filled[np.clip(bin_of, 0, bins - 1)])
        rows.append(bin_of[point])
        values.append(change[point] * spread.weights[point] / spread.counts[bin_of[point]] / width)
        points.append(point)
    row, value, point = np.concatenate(rows), np.concatenate(values), np.concatenate(points)
    entries = surface.shares[point] * value[:, None]
    vertex = mesh.faces[surface.face[point]]
    return sparse.coo_array(
        (entries.ravel(), (np.repeat(row, 3), vertex.ravel())), shape=(bins, len(mesh.vertices))
    ).tocsr()


def area_centroid(mesh: Mesh) -> FloatArray:
    """Return the centroid (3,) of the surface."""
    origin = mesh.vertices[0]
    a, b, c = (mesh.vertices[mesh.faces[:, k]] - origin for k in range(3))
    areas = face_areas(mesh.vertices, mesh.faces)
    centroid: FloatArray = origin + (areas[:, None] * (a + b + c)).sum(axis=0) / (3 * areas.sum())
    return centroid


def quantiles(values: FloatArray, weights: FloatArray, shares: tuple[float, float]) -> FloatArray:
    """Return the values below which shares of the weight lie, between the middles of the weights."""
    order: IntArray = np.argsort(values)
    rank = np.cumsum(weights[order])
    middle = (rank - 0.5 * weights[order]) / rank[-1]
    return np.interp(shares, middle, values[order])
