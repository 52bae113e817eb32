"""Landmarks: points of a marked surface, with normals, that a key holds."""

import base64
from dataclasses import dataclass

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.scanner.registration.surface import POINTS, Surface
from wm3d.scanner.registration.warp import Warp

LANDMARKS = 500
"""How many there are, about."""

FLAT = 0.9
"""Length of a mean normal from which a place makes a landmark; it is shorter on edges and thin parts. Of a
rough surface the flatter half of the places do."""

_STORED = np.dtype("<f4")


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
        return Landmarks(self.points[::step], self.normals[::step])

    def encode(self) -> str:
        """Return points and normals in single precision, row by row, as base64."""
        rows = np.column_stack([self.points, self.normals]).astype(_STORED)
        return base64.b64encode(rows.tobytes()).decode()

    @classmethod
    def decode(cls, text: str) -> "Landmarks":
        """Return what was encoded.

        Raises
        ------
        ValueError
            If the text is not base64 or no rows of six finite numbers.
        """
        try:
            stored = base64.b64decode(text, validate=True)
        except ValueError as error:
            raise ValueError(f"landmarks must be base64 ({error})") from None
        if len(stored) % (6 * _STORED.itemsize):
            raise ValueError(f"landmarks must be rows of six numbers, and {len(stored)} bytes are not")
        rows = np.frombuffer(stored, _STORED).reshape(-1, 6).astype(float)
        if not np.isfinite(rows).all():
            raise ValueError("landmarks must be finite numbers")
        return cls(rows[:, :3], rows[:, 3:])
