"""What the key holds of a mesh that `range-dct` marked, and how it lays a suspect where that lay."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from wm3d.arrays import FloatArray
from wm3d.errors import NoSolidError
from wm3d.imagemarks.blocks import BLOCK
from wm3d.imagemarks.fine_signs import FineSigns
from wm3d.mesh import Mesh, Part, SolidMoments, large_parts, surface_area
from wm3d.mesh.solid import ENTRIES
from wm3d.packing import unpacked
from wm3d.scanner.affine import MOST_WAYS, AffineFrame, mirror_image, recognized
from wm3d.scanner.denoise import denoised
from wm3d.scanner.registration import (
    DOUBTFUL,
    SURE,
    UNLIKELY,
    Fit,
    Landmarks,
    Surface,
    Warp,
    nearest,
    posed,
    registered,
)
from wm3d.scanner.scan import MAX_GRID

FARTHEST = 1e60
"""Bound of the entries of a stored pose, and 1 over it of its matrix: squares of the places that it leads to
and comes from are finite, whatever the unit of the mesh."""

NEARLY_ALL = 0.9
"""Share of the surface from which a part is all but the whole, and not searched for alone."""

GridSize = Annotated[int, Field(ge=BLOCK, le=MAX_GRID, multiple_of=BLOCK)]
Entry = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]


def _checked_landmarks(text: str) -> str:
    points = Landmarks.decode(text).points
    if len(points) and not points.std(axis=0).any():
        raise ValueError("landmarks must not all lie in one place")
    return text


def _checked_steps(text: str) -> str:
    if (unpacked(text, 1, "steps") < 0).any():
        raise ValueError("steps must not be negative")
    return text


def _checked_home(home: tuple[float, ...]) -> tuple[float, ...]:
    if max(map(abs, home[:9])) < 1 / FARTHEST:
        raise ValueError(f"a pose must not shrink a mesh by more than {FARTHEST:g}")
    return home


class Laid(NamedTuple):
    """A suspect as it is read: a mesh, its vertices (n, 3) in the scanner's frame, how many poses it had."""

    mesh: Mesh
    vertices: FloatArray
    tries: int


@dataclass(frozen=True, eq=False)
class _Suspect:
    """What is laid over the landmarks: a mesh, its surface, the poses it may have, the likeliest first.

    `tries` is how many poses the landmarks chose that one from.
    """

    mesh: Mesh
    surface: Surface
    landmarks: Landmarks
    poses: list[Warp]
    tries: int

    @cached_property
    def first(self) -> Fit:
        """The fit from the likeliest pose."""
        return posed(self.surface, self.landmarks, self.poses[0])

    @cached_property
    def others(self) -> list[Fit]:
        """The fits from the other poses."""
        return [posed(self.surface, self.landmarks, pose) for pose in self.poses[1:]]

    def fit(self) -> Fit:
        """Return the best fit from the poses, without a search."""
        return max((self.first, *self.others), key=lambda fit: fit.share)

    def registered(self, mirrored: bool) -> Fit:
        """Return the best fit, searched for where that of no pose is sure."""
        return registered(self.surface, self.landmarks, self._fits(), mirrored=mirrored)

    def _fits(self) -> Iterator[Fit]:
        yield self.first
        yield from self.others

    def laid(self, found: Fit, tries: int) -> Laid:
        """Return the mesh as a fit lays it, the best of so many poses of all suspects."""
        vertices = found.warp(self.surface.placed(self.mesh.vertices))
        mesh = mirror_image(self.mesh) if found.warp.mirrors else self.mesh
        return Laid(mesh, vertices, tries)


class Reference(BaseModel):
    """What the embedder works out for a mesh and detection needs; part of the key.

    Attributes
    ----------
    grid : (N_v, N_u)
        Columns around and rows along the axis.
    hmin, height : float
        Lower end and height of the cylinder, from the solid's centroid, in the unit of the frame.
    moments : (31,) tuple of float
        `SolidMoments.entries` of the marked solid in the frame of the scanner.
    offset : (3,) tuple of float
        Where the marked solid's centroid lies in that frame.
    area : float
        `whitened_area` of the marked mesh.
    landmarks : str
        `Landmarks` of the marked mesh, in that frame.
    home : (12,) tuple of float
        Matrix and shift of the linear map that took the marked mesh into that frame.
    strength : float
        Amplitude of the mark that can be read back, in the unit of the frame.
    steps : str
        `FineSigns.step` of each block, in the cubed unit of the frame.
    ways : int
        In how many ways the solid can be laid on itself, or nearly; more than 1 for a symmetric one.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    grid: tuple[GridSize, GridSize]
    hmin: float
    height: Annotated[float, Field(gt=0)]
    moments: Annotated[tuple[float, ...], Field(min_length=ENTRIES, max_length=ENTRIES)]
    offset: tuple[Entry, Entry, Entry]
    area: Annotated[float, Field(gt=0)]
    landmarks: Annotated[str, AfterValidator(_checked_landmarks)]
    home: Annotated[tuple[Entry, ...], Field(min_length=12, max_length=12), AfterValidator(_checked_home)]
    strength: Annotated[float, Field(gt=0)]
    steps: Annotated[str, AfterValidator(_checked_steps)]
    ways: Annotated[int, Field(ge=1, le=MOST_WAYS)] = 1

    @model_validator(mode="after")
    def _one_step_a_block(self) -> Self:
        blocks, steps = self.grid[0] * self.grid[1] // BLOCK**2, len(self.fine.step)
        if steps != blocks:
            raise ValueError(
                f"a grid of {self.grid[0]}×{self.grid[1]} has {blocks} blocks, but {steps} steps are given"
            )
        return self

    @property
    def fine(self) -> FineSigns:
        """Where fine signs lie."""
        return FineSigns(unpacked(self.steps, 1, "steps"))

    def pose(self, frame: AffineFrame, surface: Surface) -> Warp:
        """Return the map that lays a surface in the frame as its moments say."""
        shift = frame.matrix @ (surface.middle - frame.centroid) + self.offset
        return Warp.linear(surface.size * frame.matrix, shift)

    def home_pose(self, surface: Surface) -> Warp:
        """Return the map that lays a surface in the frame as if it never moved."""
        matrix, shift = np.reshape(self.home[:9], (3, 3)), np.array(self.home[9:])
        return Warp.linear(surface.size * matrix, matrix @ surface.middle + shift)

    def laid(self, mesh: Mesh) -> Laid:
        """Lay a suspect where the marked mesh lay: smooth crumples, pose, and fit it to the landmarks.

        Of the poses of a symmetric solid the landmarks choose one, and they lie on what the right key made of
        the surface: on an unmarked one, too, that key does better there than in the others. So all of them
        count as tries. Of other solids that must be searched for the mirror image is searched for, too: no
        moments tell what is a part of one. What bounds no solid, as what one view of a scanner saw, has no
        moments: the landmarks alone must tell where it lies. Where the whole is not the solid, but one of its
        parts is, the others were added, as a base or as objects beside it: that part is read alone. All
        poses of the whole and of the parts that are compared count as tries, too. What the search tries does
        not: it finds an unmarked surface where it finds the marked one.
        """
        landmarks = Landmarks.decode(self.landmarks)
        whole, parts = self._suspect(mesh, landmarks), large_parts(mesh)
        if parts and not whole.first.exact:
            return self._amid(whole, parts, landmarks)
        return whole.laid(self._registered(whole), whole.tries)

    def _amid(self, whole: _Suspect, parts: list[Part], landmarks: Landmarks) -> Laid:
        """Lay a mesh of several parts, or one of these alone: each closed one by its own moments, too."""
        closed = {n: self._suspect(part.mesh, landmarks) for n, part in enumerate(parts) if part.closed}
        suspects = [whole, *closed.values()]
        fits = [one.fit() for one in suspects]
        best = max(range(len(fits)), key=lambda k: (fits[k].share, k))
        tries = sum(one.tries for one in suspects)
        if best > 0 and fits[best].share >= SURE:
            return suspects[best].laid(fits[best], tries)
        found, largest = self._registered(whole), parts[0].mesh
        if found.share < DOUBTFUL and surface_area(largest) < NEARLY_ALL * surface_area(whole.mesh):
            part = closed.get(0) or self._suspect(largest, landmarks)  # that lost a part itself, perhaps
            fit = self._registered(part)
            tries += 0 if 0 in closed else part.tries
            if fit.share > found.share + UNLIKELY:
                return part.laid(fit, tries)
        return whole.laid(found, tries)

    def _registered(self, suspect: _Suspect) -> Fit:
        return suspect.registered(mirrored=self.ways == 1)

    def _suspect(self, mesh: Mesh, landmarks: Landmarks) -> _Suspect:
        frames: list[AffineFrame] = []
        with suppress(NoSolidError):
            mesh, frames = recognized(
                denoised(mesh, self.area), SolidMoments.of_entries(self.moments), self.ways
            )
        surface = Surface.of(mesh)
        poses = [self.home_pose(surface)]
        if frames:
            poses.insert(0, nearest(surface, landmarks, [self.pose(frame, surface) for frame in frames]))
        return _Suspect(mesh, surface, landmarks, poses, len(frames) or self.ways)
