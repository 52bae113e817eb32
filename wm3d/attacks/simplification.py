"""Simplification to a share of the faces, by three engines (section IV of the paper)."""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.arrays import FloatArray, IntArray
from wm3d.attacks.base import Attack
from wm3d.attacks.clustering import cluster_to
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, sewn


class Simplify(Attack):
    """Simplification that stops at a share of the faces; the row of a trial records the count achieved.

    Vertices in one place are welded first.

    Attributes
    ----------
    ratio : float
        Share of the faces that is kept; ½ in the paper.
    simplifier : str
        Reading of the engine: "fast-simplification" and "pymeshlab-quadric" collapse edges by quadric error
        (Garland & Heckbert 1997), "clustering" merges the vertices in each cell of a cubic grid into their
        mean, the nearest to the paper's ``plycrunch``.
    """

    name: Literal["simplify"] = "simplify"
    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("ratio", "simplifier")
    neutral: ClassVar[dict[str, float]] = {"ratio": 1}

    ratio: Annotated[float, Field(gt=0, le=1)] = 0.5
    simplifier: Literal["fast-simplification", "pymeshlab-quadric", "clustering"] = "fast-simplification"

    @property
    def engines(self) -> tuple[str, ...]:
        """The package that does the work; none for "clustering", which is ours."""
        packages = {"fast-simplification": ("fast-simplification",), "pymeshlab-quadric": ("pymeshlab",)}
        return packages.get(self.simplifier, ())

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the simplified mesh; see `Attack`."""
        target = max(4, round(self.ratio * len(mesh.faces)))
        if target >= len(mesh.faces):
            return mesh
        mesh = sewn(mesh).mesh
        # The engines hold errors against absolute bounds (in micrometres a bunny kept 99 % of its faces), so
        # all meshes come to them at one size: that of the cube from −1 to 1.
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        center, unit = 0.5 * (low + high), 0.5 * (high - low).max()
        vertices, faces = _ENGINES[self.simplifier]((mesh.vertices - center) / unit, mesh.faces, target)
        if len(faces) == 0:
            raise Wm3dError(f"{mesh.name}: {self.label()} left no faces of {len(mesh.faces)}.")
        return Mesh(vertices * unit + center, faces, mesh.name)


def _fast_simplification(vertices: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray]:
    import fast_simplification

    # a copy, because it refuses read-only arrays
    vertices, faces = fast_simplification.simplify(vertices, faces.copy(), target_count=target)
    return np.asarray(vertices, np.float64), np.asarray(faces, np.int64)


def _pymeshlab_quadric(vertices: FloatArray, faces: IntArray, target: int) -> tuple[FloatArray, IntArray]:
    import pymeshlab  # GPL: imported only where its engine is asked for

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=target)
    result = meshes.current_mesh()
    return result.vertex_matrix(), result.face_matrix().astype(np.int64)


_ENGINES = {
    "fast-simplification": _fast_simplification,
    "pymeshlab-quadric": _pymeshlab_quadric,
    "clustering": cluster_to,
}
