"""Schemes that mark the range image of the virtual scanner: pose, scan, 2-D mark, vertices that follow."""

from abc import abstractmethod
from functools import lru_cache
from typing import Annotated, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from wm3d.arrays import BoolArray, FloatArray
from wm3d.errors import Wm3dError
from wm3d.imagemarks.base import Alpha, ImageMark
from wm3d.imagemarks.blocks import BLOCK
from wm3d.mesh import Mesh
from wm3d.scanner import Cylinder, RangeImage, VertexPca
from wm3d.scanner.scan import MAX_GRID, scan_posed
from wm3d.schemes.base import Scheme
from wm3d.schemes.movement import move_vertices, radial_normals
from wm3d.stats import RademacherSum

GridSize = Annotated[int, Field(ge=1, le=MAX_GRID)]
Index = Annotated[int, Field(ge=0)]
BlockMultiple = Annotated[int, Field(ge=BLOCK, multiple_of=BLOCK)]


class RangeScheme(Scheme):
    """A 2-D mark in the range image of a virtual cylindrical scanner.

    A subclass gives `name`, the default of `alpha`, and `image_mark`.

    Attributes
    ----------
    grid : (N_v, N_u)
        Columns around and rows along the axis, in the paper's order.
    region : (U0, V0, NU, NV)
        First row, first column, rows and columns of the marked rectangle; part of the key.
    miss : "far-wall" or "exclude"
        Reading of a ray that meets no face: its range is 2r, the opposite wall; or what the mark puts around
        it, such as an 8×8 block, carries no mark and is not read.
    normalize : "region" or "image"
        Whether [0, 255] spans the ranges of the region or of the whole image.
    """

    strength: ClassVar[str] = "alpha"

    # declared here for their order, which is that of rows, labels and key files
    name: str
    grid: tuple[GridSize, GridSize] = (84, 84)
    region: tuple[Index, Index, BlockMultiple, BlockMultiple] = (2, 0, 80, 80)
    alpha: Alpha
    miss: Literal["far-wall", "exclude"] = "far-wall"
    normalize: Literal["region", "image"] = "region"

    @model_validator(mode="after")
    def _region_inside_grid(self) -> Self:
        columns, rows = self.grid
        top, left, height, width = self.region
        if top + height > rows or left + width > columns:
            raise ValueError(
                f"the region's rows {top} to {top + height - 1} and columns {left} to {left + width - 1} do "
                f"not fit a grid of {rows} rows and {columns} columns (a grid is N_v x N_u, columns first)"
            )
        return self

    @property
    @abstractmethod
    def image_mark(self) -> ImageMark:
        """The mark of the region's grey levels, at the strength of this scheme."""

    @property
    def capacity(self) -> int:
        """As many signs as the image mark has in the region."""
        return self.image_mark.capacity(self.region[2:])

    def cylinder(self, mesh: Mesh) -> Cylinder:
        """Return the paper's pose, `VertexPca` (section II-A)."""
        return _cylinder(mesh)

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        """Mark the range image and let the vertices follow (section III-A); see `Scheme.embed`."""
        host = _host(mesh, self.model_copy(update={self.strength: 1.0}))  # one entry for all strengths
        grey = self._grey(host.image, mesh.name)
        mark = self.image_mark
        if not mark.carried(grey.usable).any():
            raise Wm3dError(f"{mesh.name}: every block of the region {self.region} holds a ray that misses.")
        marked = mark.embed(grey.levels, self.signs(seed), grey.usable)
        change = np.zeros((self.grid[1], self.grid[0]))
        change[self._window] = (marked - grey.levels) * grey.unit  # Δl (eq. 8)
        return move_vertices(mesh, host.posed, host.normals, host.image.cylinder, change), self

    def evidence(self, mesh: Mesh) -> RademacherSum:
        """Pose, scan and read the region (section III-B); see `Scheme.evidence`."""
        cylinder = self.cylinder(mesh)
        image = scan_posed(cylinder.posed(mesh), mesh, self.grid, cylinder)
        grey = self._grey(image, mesh.name)
        return self.image_mark.evidence(grey.levels, grey.usable)

    @property
    def _window(self) -> tuple[slice, slice]:
        top, left, height, width = self.region
        return slice(top, top + height), slice(left, left + width)

    def _grey(self, image: RangeImage, name: str) -> "_GreyRegion":
        """Map ranges linearly to [0, 255] over the region or the image, by the readings of this scheme."""
        hit = ~np.isnan(image.ranges)
        ranges = np.where(hit, image.ranges, 2 * image.cylinder.radius)
        counted = np.ones_like(hit) if self.miss == "far-wall" else hit
        span = ranges[counted] if self.normalize == "image" else ranges[self._window][counted[self._window]]
        if span.size == 0 or span.min() == span.max():
            raise Wm3dError(f"{name}: the range image is flat over the region {self.region}.")
        unit = (span.max() - span.min()) / 255
        return _GreyRegion((ranges[self._window] - span.min()) / unit, unit, counted[self._window])


class _Host(NamedTuple):
    """The original as every key finds it: vertices in the cylinder's frame, their normals, the image."""

    posed: FloatArray
    normals: FloatArray
    image: RangeImage


@lru_cache(maxsize=1)  # who has read a mesh asks for its axes
def _cylinder(mesh: Mesh) -> Cylinder:
    return VertexPca()(mesh)


# the original is marked with one key after the other
@lru_cache(maxsize=1)
def _host(mesh: Mesh, scheme: RangeScheme) -> _Host:
    cylinder = scheme.cylinder(mesh)
    posed = cylinder.posed(mesh)
    return _Host(posed, radial_normals(mesh, posed), scan_posed(posed, mesh, scheme.grid, cylinder))


class _GreyRegion:
    """The region as grey levels, the mesh units of one level, and the pixels that may be used."""

    def __init__(self, levels: FloatArray, unit: float, usable: BoolArray):
        self.levels, self.unit, self.usable = levels, unit, usable
