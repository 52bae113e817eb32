"""The frame of a solid: centroid, principal axes signed by third moments, and extent along the first."""

from dataclasses import dataclass

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, volume_moments

DEGENERACY = 1e-6
"""Least gap between principal moments, relative to the largest, that fixes the axes."""

SYMMETRY = 1e-7
"""Least third moment along an axis, relative to volume × moment^(3/2), that fixes its direction."""


@dataclass(frozen=True, eq=False)
class Frame:
    """Where a solid lies.

    Attributes
    ----------
    center : (3,) ndarray
    axes : (3, 3) ndarray
        Rows: the principal axes by falling moment, right-handed.
    low, high : float
        Least and greatest coordinate of the vertices along the first axis.
    volume : float
        Signed, in cubed mesh units.
    """

    center: FloatArray
    axes: FloatArray
    low: float
    high: float
    volume: float

    def posed(self, mesh: Mesh) -> FloatArray:
        """Return the vertices in this frame, (n, 3): height h, then the two coordinates across."""
        posed: FloatArray = np.ascontiguousarray((mesh.vertices - self.center) @ self.axes.T)
        return posed


def volume_frame(mesh: Mesh) -> Frame:
    """Return the frame of the volume moments (Wang et al. 2011, section 3).

    Raises
    ------
    Wm3dError
        If the surface encloses no volume, two principal moments are equal, or the solid is mirror symmetric
        along the first or second axis.
    """
    moments = volume_moments(mesh)
    values, vectors = np.linalg.eigh(moments.covariance)
    values, axes = values[::-1], vectors.T[::-1].copy()
    if min(values[0] - values[1], values[1] - values[2]) < DEGENERACY * abs(values[0]):
        raise Wm3dError(
            f"{mesh.name}: two principal moments of its volume are equal, so it has no unique axes; a sphere "
            "or a regular prism cannot carry this watermark."
        )
    axes[2] *= np.sign(np.linalg.det(axes))  # a reflection would turn the signs of the tetrahedra round
    posed = (mesh.vertices - moments.centroid) @ axes.T
    third = _third_moments(posed, mesh) / (moments.volume * np.abs(values) ** 1.5)
    for axis in range(2):
        if abs(third[axis]) < SYMMETRY:
            raise Wm3dError(
                f"{mesh.name}: its volume is symmetric along principal axis {axis + 1}, so the direction of "
                "that axis is undefined; such a mesh cannot carry this watermark."
            )
        axes[axis] *= np.sign(third[axis])
    axes[2] = np.cross(axes[0], axes[1])
    heights = (mesh.vertices[mesh.used] - moments.centroid) @ axes[0]
    return Frame(moments.centroid, axes, heights.min(), heights.max(), moments.volume)


def _third_moments(posed: FloatArray, mesh: Mesh) -> FloatArray:
    """Return ∫ x³, ∫ y³, ∫ z³ over the signed tetrahedra from the origin to the faces.

    Over (0, a, b, c), ∫ x³ = det/120 · h₃(a, b, c), with h₃ the sum of all monomials of degree 3.
    """
    a, b, c = (posed[mesh.faces[:, k]] for k in range(3))
    determinant = np.einsum("ij,ij->i", a, np.cross(b, c))
    monomials = a**3 + b**3 + c**3 + a * a * (b + c) + b * b * (a + c) + c * c * (a + b) + a * b * c
    moments: FloatArray = determinant @ monomials / 120
    return moments
