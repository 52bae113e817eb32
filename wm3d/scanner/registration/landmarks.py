"""Landmarks: points of a marked surface, with normals, that a key holds."""

from dataclasses import dataclass

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.packing import packed, unpacked
from wm3d.scanner.registration.surface import POINTS, Surface
from wm3d.scanner.registration.warp import Warp

LANDMARKS = 500
"""How many there are, about."""

FLAT = 0.9
"""Length of a mean normal from which a place makes a landmark; it is shorter on edges and thin parts. Of a
rough surface the flatter half of the places do."""


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Points of a surface and its outward unit normals there, (k, 3) each, in the frame of a scanner."""

    points: FloatArray
    normals: FloatArray

    @classmethod
    def of(cls, surface: Surface, pose: Warp) -> "Landmarks":
        """Choose places that lie evenly on a surface, and map them by a linear pose into the frame."""
        points, normals = surface.near(surface.points[:: POINTS // LANDMARKS])
        length = np.linalg.norm(normals, axis=1)
        flat = length >= min(FLAT, float(np.median(length)))
        return cls(pose(points[flat]), pose.normals(normals[flat]))

    def every(self, step: int) -> "Landmarks":
        """Return one in `step` of the landmarks."""
        return Landmarks(
            np.ascontiguousarray(self.points[::step]), np.ascontiguousarray(self.normals[::step])
        )

    def encode(self) -> str:
        """Return points and normals in single precision, row by row, as base64."""
        return packed(np.column_stack([self.points, self.normals]))

    @classmethod
    def decode(cls, text: str) -> "Landmarks":
        """Return what was encoded.

        Raises
        ------
        ValueError
            If the text is not base64 or no rows of six finite numbers.
        """
        rows = unpacked(text, 6, "landmarks")
        return cls(np.ascontiguousarray(rows[:, :3]), np.ascontiguousarray(rows[:, 3:]))
