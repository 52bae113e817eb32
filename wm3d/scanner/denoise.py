"""Taking the crumples out of a noisy surface before it is scanned."""

import numpy as np

from wm3d.mesh import Mesh, surface_area, volume_moments
from wm3d.mesh.kernels import umbrella_step

CRUMPLED = 1.6
"""Surface area, over that of the marked mesh, above which a surface is smoothed; below, smoothing costs more
of the mark than of the noise."""

STEP = 0.3
"""How far a vertex goes towards the mean of its neighbours at a time."""

MOST_STEPS = 60


def relative_area(mesh: Mesh) -> float:
    """Return the surface area over the summed second moments of the solid; the same at any scale.

    Raises
    ------
    Wm3dError
        If the mesh encloses no volume.
    """
    return surface_area(mesh) / float(np.trace(volume_moments(mesh).covariance))


def denoised(mesh: Mesh, area: float) -> Mesh:
    """Return the mesh, smoothed until its relative area is no more than `CRUMPLED` times what it was.

    Noise on the coordinates that is as large as the edges folds the surface over; its area then grows with
    the square of the noise, and the error of the volume behind a cell with higher powers of it. A few steps
    of Laplacian smoothing move a vertex by less than a cell and take most of that away.

    Parameters
    ----------
    mesh : Mesh
    area : float
        `relative_area` of the marked mesh.

    Raises
    ------
    Wm3dError
        If the mesh encloses no volume.
    """
    allowed = CRUMPLED * area * float(np.trace(volume_moments(mesh).covariance))
    for _ in range(MOST_STEPS):
        if surface_area(mesh) <= allowed:
            break
        mesh = mesh.with_vertices(umbrella_step(mesh.vertices, mesh.faces, STEP))
    return mesh
