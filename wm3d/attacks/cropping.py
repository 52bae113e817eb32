"""Cropping: a share of the vertices, or all that lies beyond a plane."""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.arrays import FloatArray, IntArray
from wm3d.attacks.base import Attack
from wm3d.attacks.surface import without_unused
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh


class Crop(Attack):
    """The vertices farthest in a random direction removed, with their faces (LIRIS benchmark, SMI 2010).

    Attributes
    ----------
    percent : float
        Share of the vertices that is removed; 10, 30 and 50 in the benchmark.
    """

    name: Literal["crop"] = "crop"
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(ge=0, lt=100)] = 10.0

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return what is left of the mesh; see `Attack`."""
        depth = np.einsum("nj,j->n", mesh.vertices, _direction(rng))
        removed = round(self.percent / 100 * len(depth))
        if removed == 0:
            return mesh
        kept = np.ones(len(depth), bool)
        kept[np.argsort(depth, kind="stable")[-removed:]] = False
        faces = mesh.faces[kept[mesh.faces].all(axis=1)]
        if len(faces) == 0:
            raise Wm3dError(f"{mesh.name}: {self.label()} leaves no face; crop less.")
        return Mesh(*without_unused(mesh.vertices, faces), mesh.name)


class HalfSpaceCrop(Attack):
    """Everything beyond a plane across a random direction removed; faces are cut, the hole stays open.

    Attributes
    ----------
    percent : float
        Depth of the part that is removed, in percent of the extent of the mesh in that direction.
    """

    name: Literal["half-space-crop"] = "half-space-crop"
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(ge=0, lt=100)] = 10.0

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return what is left of the mesh; see `Attack`."""
        direction = _direction(rng)
        if self.percent == 0:
            return mesh
        depth = np.einsum("nj,j->n", mesh.vertices, direction)
        vertices, faces = cut(mesh, depth - depth.max() + self.percent / 100 * np.ptp(depth))
        if len(faces) == 0:
            raise Wm3dError(f"{mesh.name}: {self.label()} leaves no face; crop less.")
        return Mesh(*without_unused(vertices, faces), mesh.name)


def cut(mesh: Mesh, height: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the part of a surface where a linear function is not positive.

    Parameters
    ----------
    mesh : Mesh
    height : (n,) ndarray
        The function at the vertices. Edges get one vertex where it is 0, so neighbours stay connected.

    Returns
    -------
    vertices, faces : ndarray
        Also the vertices that no face names any more.
    """
    out = height > 0
    corners_out = out[mesh.faces].sum(axis=1)
    crossing = mesh.faces[(corners_out == 1) | (corners_out == 2)]
    lone_is_out = out[crossing].sum(axis=1) == 1
    lone = np.argmax(out[crossing] == lone_is_out[:, None], axis=1)  # the corner alone on its side
    a, b, c = (crossing[np.arange(len(crossing)), (lone + k) % 3] for k in range(3))

    n = len(mesh.vertices)
    ends = np.sort(np.column_stack([np.r_[a, c], np.r_[b, a]]), axis=1)
    code, place = np.unique(ends[:, 0] * n + ends[:, 1], return_inverse=True)
    low, high = code // n, code % n
    share = (height[low] / (height[low] - height[high]))[:, None]
    vertices = np.vstack(
        [mesh.vertices, mesh.vertices[low] + share * (mesh.vertices[high] - mesh.vertices[low])]
    )
    ab, ca = n + place[: len(a)], n + place[len(a) :]

    tips = np.column_stack([a, ab, ca])[~lone_is_out]
    halves = [np.column_stack(corners)[lone_is_out] for corners in ((b, c, ca), (b, ca, ab))]
    return vertices, np.vstack([mesh.faces[corners_out == 0], tips, *halves])


def _direction(rng: np.random.Generator) -> FloatArray:
    """Random unit vector (3,)."""
    direction = rng.standard_normal(3)
    unit: FloatArray = direction / np.linalg.norm(direction)
    return unit
