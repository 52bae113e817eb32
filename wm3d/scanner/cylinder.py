"""The scanning cylinder: a reference frame with a radius and a height, and coordinates relative to it."""

from dataclasses import dataclass

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.scanner import kernels


@dataclass(frozen=True, eq=False)
class Cylinder:
    """The virtual scanner's cylinder around a model (section II-A of the paper).

    Attributes
    ----------
    center : (3,) ndarray
        m, a point on the axis, in mesh units.
    axes : (3, 3) ndarray
        Rows s1 (the cylinder's axis), s2, s3 = s2 × s1, unit length. As the paper defines them they are
        left-handed: columns run counter-clockwise for a reader who looks along s1 from its tip.
    radius : float
        r of eq. 1, in mesh units.
    hmin, hmax : float
        Ends of the cylinder along s1, measured from `center` (eq. 2), in mesh units.
    """

    center: FloatArray
    axes: FloatArray
    radius: float
    hmin: float
    hmax: float

    def __post_init__(self) -> None:
        orthonormal = np.allclose(self.axes @ self.axes.T, np.eye(3))
        if not (orthonormal and np.allclose(self.axes[2], np.cross(self.axes[1], self.axes[0]))):
            raise Wm3dError(
                "the axes of a cylinder must be unit rows s1, s2, s3 at right angles, with s3 = s2 × s1 "
                "(left-handed)."
            )
        if not (self.radius > 0 and self.hmax > self.hmin):
            raise Wm3dError(
                f"a cylinder of radius {self.radius:g} and height {self.hmax - self.hmin:g} is empty; "
                "the mesh must extend along and across its first axis."
            )

    @property
    def height(self) -> float:
        """Height h = hmax − hmin (eq. 2), in mesh units."""
        return self.hmax - self.hmin

    def posed(self, mesh: Mesh) -> FloatArray:
        """Return the vertices in the frame of the cylinder.

        Returns
        -------
        (n, 3) ndarray
            Columns s1·(v−m), s2·(v−m), s3·(v−m), in mesh units.
        """
        posed: FloatArray = kernels.to_frame(mesh.vertices, self.center, self.axes)
        return posed

    def planes(self, rows: int) -> FloatArray:
        """Return the heights along s1 at which the `rows` rows of rays lie: hmin + (u + ½) h / N_u."""
        heights: FloatArray = self.hmin + (np.arange(rows, dtype=np.float64) + 0.5) * (self.height / rows)
        return heights

    def axis_deviation(self, other: "Cylinder") -> float:
        """Return the largest angle between corresponding axes of two frames, in degrees."""
        cross = np.linalg.norm(np.cross(self.axes, other.axes), axis=1)
        dot = np.einsum("ij,ij->i", self.axes, other.axes)
        return float(np.degrees(np.arctan2(cross, dot).max()))
