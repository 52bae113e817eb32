"""A small renderer for figures: orthographic, smoothly shaded, with the depth that overlays need."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import gaussian_filter

from wm3d.arrays import BoolArray, FloatArray, IntArray
from wm3d.bench import kernels
from wm3d.mesh import Mesh, vertex_normals
from wm3d.scanner import Cylinder

CLAY = (0.82, 0.80, 0.77)
"""Colour of a surface without a colour of its own, sRGB like all colours here."""

LIGHTS = (((-0.55, 0.55, 0.62), 0.78), ((0.75, 0.05, 0.65), 0.20), ((0.0, 1.0, 0.0), 0.10))
"""Directions (right, up, towards the viewer) and strengths: key, fill, sky."""

AMBIENT = 0.09
GAMMA = 2.2
SUBSAMPLES = 3
"""Rays along each side of a pixel."""

CREASE = 0.012
"""Radius of the darkening of creases, as a share of the picture's height."""


@dataclass(frozen=True, eq=False)
class View:
    """An orthographic camera.

    Attributes
    ----------
    axes : (3, 3) ndarray
        Rows: unit vectors to the right, upwards and towards the viewer, in mesh coordinates.
    center : (3,) ndarray
        Point in the middle of the picture, in mesh units.
    scale : float
        Pixels a mesh unit.
    size : (height, width)
        Pixels.
    """

    axes: FloatArray
    center: FloatArray
    scale: float
    size: tuple[int, int]

    @classmethod
    def around(
        cls, points: FloatArray, axes: FloatArray, size: tuple[int, int], margin: float = 0.03
    ) -> "View":
        """Return the view that shows all points, with a margin as a share of the picture."""
        seen = points @ axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        height, width = size
        extent = np.maximum(high - low, 1e-12)
        scale = (1 - 2 * margin) * min(width / extent[0], height / extent[1])
        return cls(axes, axes.T @ (0.5 * (low + high)), float(scale), size)

    def project(self, points: ArrayLike) -> FloatArray:
        """Return x to the right and y downwards in pixels, and depth towards the viewer in mesh units.

        Parameters
        ----------
        points : (..., 3) array_like

        Returns
        -------
        (..., 3) ndarray
        """
        seen = (np.asarray(points, np.float64) - self.center) @ self.axes.T
        height, width = self.size
        x, y = 0.5 * width + self.scale * seen[..., 0], 0.5 * height - self.scale * seen[..., 1]
        projected: FloatArray = np.stack([x, y, seen[..., 2]], axis=-1)
        return projected


def upright(cylinder: Cylinder, turn: float = 0.0, tilt: float = 0.0, *, up: int = 1) -> FloatArray:
    """Return the axes of a view in which the scanner's axis s1 stands upright.

    Parameters
    ----------
    cylinder : Cylinder
    turn : float
        Angle from s3 towards s2 of the side that faces the viewer, in degrees: that of column
        N_v · turn / 360.
    tilt : float
        How far the viewer looks down, in degrees.
    up : 1 or -1
        −1 lets s1 point downwards.
    """
    s1, s2, s3 = cylinder.axes
    phi, theta = np.radians([turn, tilt])
    outward = np.cos(phi) * s3 + np.sin(phi) * s2
    toward = np.cos(theta) * outward + np.sin(theta) * up * s1
    above = np.cos(theta) * up * s1 - np.sin(theta) * outward
    return np.stack([np.cross(above, toward), above, toward])


@dataclass(frozen=True, eq=False)
class Picture:
    """A rendered mesh.

    Attributes
    ----------
    image : (height, width, 3) ndarray
        RGB in [0, 1].
    depth : (height, width) ndarray
        Towards the viewer in mesh units, as `View.project` gives it; −inf beside the mesh.
    view : View
    """

    image: FloatArray
    depth: FloatArray
    view: View

    def hides(self, points: ArrayLike) -> BoolArray:
        """Return which points lie behind the mesh: (...,) of bool for (..., 3) points."""
        x, y, depth = np.moveaxis(self.view.project(points), -1, 0)
        height, width = self.view.size
        row, column = np.floor(y).astype(int), np.floor(x).astype(int)
        inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
        nearest = self.depth[row.clip(0, height - 1), column.clip(0, width - 1)]
        hidden: BoolArray = inside & (nearest > depth)
        return hidden


def render(
    mesh: Mesh,
    view: View,
    colors: FloatArray | None = None,
    background: tuple[float, float, float] = (1, 1, 1),
) -> Picture:
    """Render a mesh.

    Parameters
    ----------
    mesh : Mesh
        Faces seen from behind are shaded like those seen from the front.
    view : View
    colors : (n, 3) ndarray, optional
        RGB of each vertex in [0, 1]; `CLAY` by default.
    background : (r, g, b)
    """
    fine = View(
        view.axes,
        view.center,
        view.scale * SUBSAMPLES,
        (view.size[0] * SUBSAMPLES, view.size[1] * SUBSAMPLES),
    )
    face, depth, weights = kernels.rasterize(fine.project(mesh.vertices), mesh.faces, *fine.size)
    hit = face >= 0
    corners, shares = mesh.faces[face[hit]], weights[hit]
    normals = _interpolated(vertex_normals(mesh) @ view.axes.T, corners, shares)
    base = np.array(CLAY) if colors is None else _interpolated(colors, corners, shares)
    light = _lit(normals, base**GAMMA) * _crease(depth, hit, CREASE * fine.size[0])[:, None]
    image = np.empty((*fine.size, 3))
    image[:] = background
    image[hit] = light.clip(0, 1) ** (1 / GAMMA)
    blocks = image.reshape(view.size[0], SUBSAMPLES, view.size[1], SUBSAMPLES, 3)
    nearest = depth.reshape(view.size[0], SUBSAMPLES, view.size[1], SUBSAMPLES).max(axis=(1, 3))
    return Picture(blocks.mean(axis=(1, 3)), nearest, view)


def _interpolated(values: FloatArray, corners: IntArray, shares: FloatArray) -> FloatArray:
    result: FloatArray = np.einsum("kj,kjc->kc", shares, values[corners])
    return result


def _lit(normals: FloatArray, base: FloatArray) -> FloatArray:
    """Lambert's law for the three lights, and a weak highlight of the first; (k, 3)."""
    unit = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    unit = np.where(unit[:, 2:] < 0, -unit, unit)
    light = np.full(len(unit), AMBIENT)
    for direction, strength in LIGHTS:
        light += strength * np.maximum(unit @ (np.array(direction) / np.linalg.norm(direction)), 0)
    half = np.array(LIGHTS[0][0]) / np.linalg.norm(LIGHTS[0][0]) + [0, 0, 1]
    shine = np.maximum(unit @ (half / np.linalg.norm(half)), 0) ** 40
    lit: FloatArray = light[:, None] * base + 0.06 * shine[:, None]
    return lit


def _crease(depth: FloatArray, hit: BoolArray, radius: float) -> FloatArray:
    """Darken what lies behind its surroundings: unsharp masking of the depth buffer (Luft et al. 2006)."""
    reach = np.ptp(depth[hit])
    behind = np.zeros(int(hit.sum()))
    if reach > 0:
        share = np.where(hit, (depth - depth[hit].min()) / reach, 0.0)
        # the mean over covered pixels only, so that the outline is not taken for a ridge
        mean = gaussian_filter(share, radius) / np.maximum(gaussian_filter(hit.astype(float), radius), 1e-9)
        behind = np.maximum(mean[hit] - share[hit], 0)
    return 1 - np.minimum(3.0 * behind, 0.55)


def rasterize_reference(
    points: FloatArray, faces: IntArray, height: int, width: int
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Plain numpy twin of `kernels.rasterize`: each face is tried against every pixel."""
    face = np.full((height, width), -1, np.int64)
    depth = np.full((height, width), -np.inf)
    weights = np.zeros((height, width, 3))
    y, x = np.mgrid[:height, :width] + 0.5
    for f, corners in enumerate(points[faces]):
        frame = np.vstack([corners[:, :2].T, np.ones(3)])
        if np.linalg.det(frame) == 0:
            continue
        shares = np.einsum("ij,jhw->hwi", np.linalg.inv(frame), np.stack([x, y, np.ones_like(x)]))
        z = shares @ corners[:, 2]
        nearer = (shares >= 0).all(axis=-1) & (z > depth)
        face[nearer], depth[nearer], weights[nearer] = f, z[nearer], shares[nearer]
    return face, depth, weights
