"""Remeshing: another mesh of the same surface, from edge operations or a Poisson solve.

pymeshlab does the work. It is GPL, so it is imported only where one of these attacks is asked for.
"""

from abc import abstractmethod
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.attacks.base import Attack
from wm3d.attacks.surface import without_unused
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, orientation, sewn


class Remeshing(Attack):
    """A filter of pymeshlab that makes another mesh of the surface; what all kinds of it share.

    Vertices in one place are welded first.
    """

    random: ClassVar[bool] = False

    @property
    def engines(self) -> tuple[str, ...]:
        """The package that does the work."""
        return ("pymeshlab",)

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the new mesh; see `Attack`."""
        import pymeshlab

        mesh = sewn(mesh).mesh
        # the filters take the outside from the winding
        inward = orientation(mesh) < 0
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.faces[:, ::-1] if inward else mesh.faces))
        try:
            self._filter(meshes, mesh)
        except pymeshlab.PyMeshLabException as error:
            reason = " ".join(str(error).split()).rstrip(".")
            raise Wm3dError(f"{mesh.name}: pymeshlab refuses {self.label()}; {reason}.") from error
        result = meshes.current_mesh()
        vertices, faces = result.vertex_matrix(), result.face_matrix().astype(np.int64)
        if len(faces) == 0:
            raise Wm3dError(
                f"{mesh.name}: {self.label()} leaves no face; the mesh is too coarse or too thin for it."
            )
        return Mesh(*without_unused(vertices, faces[:, ::-1] if inward else faces), mesh.name)

    @abstractmethod
    def _filter(self, meshes: Any, mesh: Mesh) -> None:
        """Apply the filter to the current mesh of a pymeshlab MeshSet."""


class IsotropicRemesh(Remeshing):
    """Edges split, collapsed, flipped and relaxed towards one length (Botsch & Kobbelt 2004).

    Attributes
    ----------
    edge_ratio : float
        Wanted edge length, in mean edge lengths of the mesh.
    iterations : int
        Rounds of the four operations.
    """

    name: Literal["isotropic-remesh"] = "isotropic-remesh"
    legend: ClassVar[tuple[str, ...]] = ("edge_ratio",)

    edge_ratio: Annotated[float, Field(gt=0)] = 1.0
    iterations: Annotated[int, Field(ge=1)] = 3

    def _filter(self, meshes: Any, mesh: Mesh) -> None:
        import pymeshlab

        start, end = mesh.vertices[mesh.faces], mesh.vertices[np.roll(mesh.faces, -1, axis=1)]
        length = self.edge_ratio * float(np.linalg.norm(end - start, axis=2).mean())
        # every round projects onto the input; the check of each step's distance doubles the time for nothing
        meshes.meshing_isotropic_explicit_remeshing(
            iterations=self.iterations, targetlen=pymeshlab.PureValue(length), checksurfdist=False
        )


class ScreenedPoisson(Remeshing):
    """The surface rebuilt from its vertices and their normals (Kazhdan & Hoppe 2013); closes holes.

    Attributes
    ----------
    depth : int
        Depth of the octree: the finest cells are 1.1/2^depth of the largest extent; 8 in MeshLab.
    """

    name: Literal["screened-poisson"] = "screened-poisson"
    legend: ClassVar[tuple[str, ...]] = ("depth",)

    depth: Annotated[int, Field(ge=4, le=12)] = 8

    def _filter(self, meshes: Any, mesh: Mesh) -> None:  # noqa: ARG002 (one signature)
        # one thread: the sums of several come in any order
        meshes.generate_surface_reconstruction_screened_poisson(depth=self.depth, preclean=True, threads=1)
