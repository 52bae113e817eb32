"""Broken files: faces lost, wound at variance or stored twice, while every vertex stays in its place."""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field
from scipy.spatial import cKDTree

from wm3d.arrays import IntArray
from wm3d.attacks.base import Attack
from wm3d.attacks.surface import without_unused
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh


class DropFaces(Attack):
    """A share of the faces removed, drawn at random: a surface full of holes.

    Attributes
    ----------
    percent : float
        Share of the faces.
    """

    name: Literal["drop-faces"] = "drop-faces"
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(ge=0, lt=100)] = 10.0

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return what is left of the mesh; see `Attack`."""
        drawn = _drawn(mesh, self.percent, rng)
        if len(drawn) == 0:
            return mesh
        if len(drawn) == len(mesh.faces):
            raise Wm3dError(f"{mesh.name}: {self.label()} leaves no face; drop fewer.")
        return Mesh(*without_unused(mesh.vertices, np.delete(mesh.faces, drawn, axis=0)), mesh.name)


class FlipFaces(Attack):
    """A share of the faces turned over, drawn at random; a viewer that shows both sides shows the same.

    Attributes
    ----------
    percent : float
        Share of the faces, or of the patches; with 50 the winding of a face says nothing any more.
    patches : int, optional
        Turn over whole patches, as where a model was sewn together from sheets: each face belongs to the
        nearest of so many that are drawn. By default every face is drawn on its own.
    """

    name: Literal["flip-faces"] = "flip-faces"
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(ge=0, le=100)] = 50.0
    patches: Annotated[int, Field(ge=1)] | None = None

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the mesh with some faces wound the other way; see `Attack`."""
        if self.patches is None:
            drawn = _drawn(mesh, self.percent, rng)
        else:
            patch = _patches(mesh, self.patches, rng)
            drawn = np.flatnonzero(patch < round(self.percent / 100 * (patch.max() + 1)))
        if len(drawn) == 0:
            return mesh
        faces = mesh.faces.copy()
        faces[drawn] = faces[drawn, ::-1]
        return Mesh(mesh.vertices, faces, mesh.name)


class RepeatFaces(Attack):
    """A share of the faces stored twice, drawn at random.

    Attributes
    ----------
    percent : float
        Share of the faces.
    turned : bool
        Whether the second one shows its other side: with 100 percent a surface that was stored two-sided.
    """

    name: Literal["repeat-faces"] = "repeat-faces"
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(ge=0, le=100)] = 100.0
    turned: bool = False

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the mesh with the repeated faces behind the others, in a random order; see `Attack`."""
        drawn = _drawn(mesh, self.percent, rng)
        if len(drawn) == 0:
            return mesh
        again = mesh.faces[drawn]
        return Mesh(
            mesh.vertices, np.vstack([mesh.faces, again[:, ::-1] if self.turned else again]), mesh.name
        )


def _drawn(mesh: Mesh, percent: float, rng: np.random.Generator) -> IntArray:
    """Draw a share of the faces, in a random order."""
    return rng.permutation(len(mesh.faces))[: round(percent / 100 * len(mesh.faces))]


def _patches(mesh: Mesh, count: int, rng: np.random.Generator) -> IntArray:
    """Return the patch of each face, (m,): the nearest of so many faces that are drawn, in a random order."""
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    drawn = middles[rng.permutation(len(middles))[:count]]
    return np.asarray(cKDTree(drawn).query(middles)[1], dtype=np.int64)
