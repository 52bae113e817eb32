"""Poses: how a mesh fixes its own reference frame and scanning cylinder, whatever its position and size."""

import math
from typing import Literal

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.component import Component
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, vertex_moments
from wm3d.scanner import kernels
from wm3d.scanner.cylinder import Cylinder

DEGENERACY = 1e-6
"""Least gap between principal moments, relative to the largest, below which the axes count as undefined."""

FLATNESS = 1e-12
"""Least principal moment, relative to the largest, below which a mesh counts as flat."""

SYMMETRY = 1e-9
"""Least relative difference of D_A² and D_B² (eq. 3) below which the sign of an axis counts as undefined.

Also the height above the plane between A and B, relative to the standard deviation along s1, up to which a
vertex counts in neither set.
"""


class VertexPca(Component):
    """The paper's pose: principal axes of the vertices, signed by the larger spread (eqs. 1–3)."""

    name: Literal["vertex-pca"] = "vertex-pca"

    def __call__(self, mesh: Mesh) -> Cylinder:
        """Return the tight cylinder around the mesh.

        Raises
        ------
        Wm3dError
            If two principal moments are equal (a sphere, a cube, a regular prism), the mesh is mirror
            symmetric along s1 or s2, or it lies in a plane: then no rotation-proof frame exists.
        """
        mean, covariance = vertex_moments(mesh)
        moments, axes = _principal_axes(covariance, mesh.name)
        slack = SYMMETRY * math.sqrt(moments[0])
        axes[2] = np.cross(axes[1], axes[0])
        spread, low, high, radius = kernels.sides_and_extent(mesh.vertices, mean, axes, slack)
        first, second = (_sign(*spread[axis], axis=axis, name=mesh.name) for axis in range(2))
        axes *= np.array([[first], [second], [first * second]])
        hmin, hmax = (low, high) if first > 0 else (-high, -low)
        return Cylinder(mean, axes, radius, hmin, hmax)


def _principal_axes(covariance: FloatArray, name: str) -> tuple[FloatArray, FloatArray]:
    """Eigenvalues, falling, and eigenvectors as rows."""
    moments, vectors = np.linalg.eigh(covariance)
    moments, vectors = moments[::-1], vectors[:, ::-1]
    if moments[2] < FLATNESS * moments[0]:
        raise Wm3dError(
            f"{name}: all vertices lie in a plane, so the mesh shows the scanner no surface; "
            "a flat mesh cannot carry this watermark."
        )
    gaps = (moments[:-1] - moments[1:]) / moments[0]
    if gaps.min() < DEGENERACY:
        raise Wm3dError(
            f"{name}: two principal moments of the vertices are equal (relative gap {gaps.min():.1e}), so "
            "the mesh has no unique axes; a sphere or a regular prism cannot carry this watermark."
        )
    return moments, np.ascontiguousarray(vectors.T)


def _sign(above: float, below: float, *, axis: int, name: str) -> float:
    """Sign of s1 or s2 from the mean squared distances D² on either side of the mean (eq. 3)."""
    if abs(above - below) <= SYMMETRY * max(above, below):
        raise Wm3dError(
            f"{name}: is symmetric along its principal axis s{axis + 1}, so the direction of that axis is "
            "undefined; such a mesh cannot carry this watermark."
        )
    return 1.0 if above > below else -1.0
