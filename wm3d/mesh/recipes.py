"""Recipes: meshes made from other meshes, kept on disk by the bytes of their base and by the engines."""

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np

from wm3d.errors import Wm3dError
from wm3d.mesh.io import load_mesh, save_mesh
from wm3d.mesh.mesh import Mesh


@dataclass(frozen=True)
class Recipe:
    """A mesh that is computed from the first of its bases at hand.

    Attributes
    ----------
    bases : tuple of str
        Dataset names, best first.
    make : callable
        From base mesh to result.
    summary : str
        What `make` does, for listings.
    engines : tuple of str
        Distributions whose release may change the result.
    edition : int
        Raised by hand when `make` starts to give another result.
    """

    bases: tuple[str, ...]
    make: Callable[[Mesh], Mesh]
    summary: str
    engines: tuple[str, ...]
    edition: int = 1

    def target(self, name: str, base: Path, folder: Path) -> Path:
        """Return where the result from this base file is kept."""
        identity = {
            "base": hashlib.sha256(base.read_bytes()).hexdigest(),
            "edition": self.edition,
            "engines": {engine: version(engine) for engine in self.engines},
        }
        digest = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()
        return folder / f"{name}-{digest[:12]}.ply"

    def cook(self, name: str, base: Path, folder: Path) -> Path:
        """Return the result from this base file, computing it where it is not kept yet.

        Raises
        ------
        Wm3dError
            If the base cannot be read or the folder cannot be written to.
        """
        target = self.target(name, base, folder)
        if not target.is_file():
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise Wm3dError(f"{folder}: cannot be made ({error.strerror}); set WM3D_CACHE.") from error
            save_mesh(self.make(load_mesh(base)), target)
        return target


def with_faces(mesh: Mesh, count: int) -> Mesh:
    """Simplify by quadric error to `count` faces; a coarser mesh is first subdivided at its edge midpoints.

    Parameters
    ----------
    mesh : Mesh
        The base.
    count : int
        Faces wanted; an edge collapse takes two at a time, so the result may have one fewer.

    Returns
    -------
    Mesh
        Vertices that no face uses are dropped by the simplifier.
    """
    import fast_simplification
    from trimesh.remesh import subdivide

    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    while len(faces) < count:
        vertices, faces = subdivide(vertices, faces)
    vertices, faces = fast_simplification.simplify(vertices, faces, target_count=count)
    return Mesh(vertices, faces, name=mesh.name)


RECIPES = {
    "happy-buddha-300k": Recipe(
        bases=("happy-buddha", "happy-buddha-50k"),
        make=partial(with_faces, count=300_074),
        summary="subdivided where coarser, simplified to the 300074 faces of the paper's second model",
        engines=("fast-simplification", "trimesh"),
    ),
}
