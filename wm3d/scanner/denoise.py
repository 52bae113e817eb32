"""Taking the crumples out of a noisy surface before it is scanned."""

import numpy as np

from wm3d.arrays import FloatArray
from wm3d.mesh import Mesh, kernels, places, volume_moments, whitening
from wm3d.mesh.kernels import umbrella_step
from wm3d.scanner.kernels import to_frame

CRUMPLED = 1.6
"""Whitened area, over that of the marked mesh, above which a surface is smoothed; below, smoothing costs more
of the mark than of the noise."""

STEP = 0.3
"""How far a vertex goes towards the mean of its neighbours at a time."""

MOST_STEPS = 60

CREASED = 0.9
"""Share of its area that a surface keeps in the first step, above which it has no crumples but another sheet:
the paper's noise leaves at most 0.75, a surface stored twice keeps 0.96."""


def whitened_area(mesh: Mesh) -> float:
    """Return the surface area in the coordinates in which the solid's second moments are a unit matrix.

    So the same for a mesh that was scaled, stretched or sheared.

    Raises
    ------
    Wm3dError
        If the mesh encloses no volume.
    """
    return _area(mesh.vertices, mesh, _whitener(mesh))


def denoised(mesh: Mesh, area: float) -> Mesh:
    """Return the mesh, smoothed until its whitened area is no more than `CRUMPLED` times what it was.

    As it is, if the area is no larger or smoothing takes next to nothing of it away (`CREASED`).

    Noise on the coordinates that is as large as the edges folds the surface over; its area then grows with
    the square of the noise, and the error of the volume behind a cell with higher powers of it. A few steps
    of Laplacian smoothing move a vertex by less than a cell and take most of that away. Vertices in one place
    are smoothed as one.

    Parameters
    ----------
    mesh : Mesh
    area : float
        `whitened_area` of the marked mesh.

    Raises
    ------
    Wm3dError
        If the mesh encloses no volume.
    """
    whitener = _whitener(mesh)
    before = _area(mesh.vertices, mesh, whitener)
    if before <= CRUMPLED * area:
        return mesh
    first, place = places(mesh.vertices)
    vertices, faces = mesh.vertices[first], place[mesh.faces]
    for step in range(MOST_STEPS):
        vertices = umbrella_step(vertices, faces, STEP)
        smoothed = _area(vertices[place], mesh, whitener)
        if step == 0 and smoothed > CREASED * before:
            return mesh
        if smoothed <= CRUMPLED * area:
            break
    return mesh.with_vertices(vertices[place])


def _whitener(mesh: Mesh) -> FloatArray:
    return whitening(volume_moments(mesh).covariance, mesh.name)[0]


def _area(vertices: FloatArray, mesh: Mesh, whitener: FloatArray) -> float:
    return float(kernels.surface_area(to_frame(vertices, np.zeros(3), whitener), mesh.faces))
