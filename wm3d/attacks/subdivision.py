"""Subdivision: midpoint, Loop's and √3 (LIRIS benchmark)."""

from typing import ClassVar, Literal

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.attacks.base import Attack
from wm3d.attacks.surface import neighbour_mean, without_collapsed, without_unused
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, sewn


class Subdivide(Attack):
    """One step of subdivision, as in the LIRIS benchmark (Wang et al., SMI 2010).

    Attributes
    ----------
    rule : "midpoint", "loop" or "sqrt3"
        "midpoint" quarters the faces and moves no vertex; "loop" (Loop 1987) quarters and smooths them;
        "sqrt3" (Kobbelt 2000) triples and smooths them, and leaves borders as they are. Vertices in one place
        are welded first.
    """

    name: Literal["subdivide"] = "subdivide"
    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("rule",)

    rule: Literal["midpoint", "loop", "sqrt3"] = "midpoint"

    @property
    def engines(self) -> tuple[str, ...]:
        """The package that does the work; none for "sqrt3", which is ours."""
        return () if self.rule == "sqrt3" else ("trimesh",)

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the subdivided mesh; see `Attack`."""
        mesh = sewn(mesh).mesh
        if self.rule == "sqrt3":
            vertices, faces = sqrt3(mesh)
        elif self.rule == "midpoint":
            from trimesh.remesh import subdivide  # which takes longer to load than most attacks to run

            vertices, faces = subdivide(mesh.vertices, mesh.faces)
        else:
            vertices, faces = _loop(mesh)
        return Mesh(vertices, faces, mesh.name)


def sqrt3(mesh: Mesh) -> tuple[FloatArray, IntArray]:
    """Return one step of √3 subdivision (Kobbelt, SIGGRAPH 2000, section 3).

    Every face gets a vertex at its centroid, every edge between two faces is flipped, and a vertex of valence
    n moves by α = (4 − 2 cos 2π/n)/9 towards the mean of its neighbours. Other edges and their ends stay.
    """
    n, m = mesh.vertices.shape[0], mesh.faces.shape[0]
    start, end = mesh.faces.ravel(), mesh.faces[:, [1, 2, 0]].ravel()
    code, opposite = start * n + end, end * n + start
    center = n + np.repeat(np.arange(m), 3)
    order = np.argsort(code, kind="stable")
    found = np.minimum(np.searchsorted(code[order], opposite), 3 * m - 1)
    twin = order[found]
    # flipped only where exactly two faces meet, wound alike
    _, first, count = np.unique(code, return_inverse=True, return_counts=True)
    inner = (code[twin] == opposite) & (count[first] == 1) & (count[first[twin]] == 1) & (start != end)
    faces = np.column_stack([start, np.where(inner, center[twin], end), center])

    mean = neighbour_mean(mesh)
    valence = np.diff(mean.indptr)
    alpha = (4 - 2 * np.cos(2 * np.pi / valence)) / 9
    alpha[start[~inner]] = alpha[end[~inner]] = 0
    moved = mesh.vertices + alpha[:, None] * (mean @ mesh.vertices - mesh.vertices)
    return np.vstack([moved, mesh.vertices[mesh.faces].mean(axis=1)]), faces


def _loop(mesh: Mesh) -> tuple[FloatArray, IntArray]:
    from trimesh.remesh import subdivide_loop

    try:
        # without vertices of valence 0, by which trimesh would divide
        used = without_unused(mesh.vertices, without_collapsed(mesh.faces))
        vertices, faces = subdivide_loop(*used, iterations=1)
    except ValueError as error:
        raise Wm3dError(
            f"{mesh.name}: subdivide loop needs a manifold surface ({error}); use midpoint or sqrt3."
        ) from error
    return vertices, faces
