"""Warps: maps of space whose coordinates are polynomials of second degree, so nearly linear ones too."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.scanner.registration import kernels

LINEAR_TERMS, QUADRATIC_TERMS = 4, 10

MOST_STRETCH, MOST_BEND = 10.0, 0.5
"""Largest stretch or squeeze, and quadratic coefficient, of a warp that may be meant, at size 1."""

FARTHEST = 100.0
"""Coordinate beyond which no point is looked for, at size 1."""

INVERSIONS = 8
"""Rounds of the inversion; each gains a digit where the map is nearly linear."""


@dataclass(frozen=True, eq=False)
class Warp:
    """The map x ↦ `terms`(x) · coefficients.

    A bend, a twist and a taper are such maps to first order.

    Attributes
    ----------
    coefficients : (10, 3) ndarray
        Of 1, x, y, z, x², y², z², xy, yz, zx, for each coordinate of the image.
    """

    coefficients: FloatArray

    @classmethod
    def linear(cls, matrix: FloatArray, shift: FloatArray) -> "Warp":
        """Return x ↦ matrix x + shift."""
        coefficients = np.zeros((QUADRATIC_TERMS, 3))
        coefficients[0], coefficients[1:LINEAR_TERMS] = shift, matrix.T
        return cls(coefficients)

    def __call__(self, points: FloatArray) -> FloatArray:
        """Map (n, 3) points."""
        image: FloatArray = terms(points) @ self.coefficients
        return image

    @property
    def matrix(self) -> FloatArray:
        """The matrix of the linear part, (3, 3)."""
        return self.coefficients[1:LINEAR_TERMS].T

    def inverted(self) -> "Warp":
        """Return the inverse of a linear map."""
        return Warp.linear(self.back.T, -self.coefficients[0] @ self.back)

    @cached_property
    def mirrors(self) -> bool:
        """Whether it takes a surface to its mirror image: the frame of a scanner is left-handed."""
        return bool(np.linalg.det(self.matrix) > 0)

    @cached_property
    def back(self) -> FloatArray:
        """The inverse of the linear part, for rows: (3, 3)."""
        return np.asarray(np.linalg.inv(self.coefficients[1:LINEAR_TERMS]), dtype=float)

    def normals(self, normals: FloatArray) -> FloatArray:
        """Return the unit normals (n, 3) of surfaces that the linear part maps."""
        turned = normals @ self.back.T
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        unit: FloatArray = turned / np.where(length > 0, length, 1.0)
        return unit

    def inverse(self, images: FloatArray) -> FloatArray:
        """Return the points (n, 3) that the map takes to these, nearly, where it is nearly linear.

        Elsewhere the search for them may run away; it ends at `FARTHEST`.
        """
        rounds = INVERSIONS if self.coefficients[LINEAR_TERMS:].any() else 0
        points: FloatArray = kernels.preimages(images, self.coefficients, self.back, rounds, FARTHEST)
        return points


def terms(points: FloatArray) -> FloatArray:
    """Return 1, x, y, z, x², y², z², xy, yz, zx of (n, 3) points: (n, 10)."""
    x, y, z = points.T
    return np.column_stack([np.ones(len(points)), points, points**2, x * y, y * z, z * x])
