"""Moments of a mesh: vertex mean and covariance, area, signed volume and its moments, orientation."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.errors import NoSolidError
from wm3d.mesh import kernels
from wm3d.mesh.mesh import Mesh

LEAST_VOLUME = 1e-12
"""Least volume, relative to the cube of the bounding box's diagonal, that counts as a solid."""

NO_AREA = 1e-12
"""Area, relative to the square of the diagonal, up to which faces are lines and points."""


class VertexMoments(NamedTuple):
    """Mean m (3,) and centered second moments over n, C_v (3, 3), of the vertices; symmetric."""

    mean: FloatArray
    covariance: FloatArray


class VolumeMoments(NamedTuple):
    """Signed volume, centroid (3,) and covariance (3, 3) of the solid that a surface bounds."""

    volume: float
    centroid: FloatArray
    covariance: FloatArray


def vertex_moments(mesh: Mesh) -> VertexMoments:
    """Return mean and covariance of all vertices, used or not, as in section II-A of the paper.

    Parameters
    ----------
    mesh : Mesh
        Any mesh.

    Returns
    -------
    VertexMoments
        `mean` in the unit of the mesh, `covariance` in its square, divided by n.
    """
    mean = mesh.vertex_mean.copy()
    return VertexMoments(mean, kernels.vertex_covariance(mesh.vertices, mean))


def surface_area(mesh: Mesh) -> float:
    """Return the summed area of all faces, in squared units."""
    return float(kernels.surface_area(mesh.vertices, mesh.faces))


def has_area(mesh: Mesh) -> bool:
    """Tell whether the faces have an area to speak of, beside the square of the diagonal."""
    return surface_area(mesh) > NO_AREA * mesh.diagonal**2


def face_areas(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Return the area of each of (m, 3) faces with (n, 3) vertices: (m,), in squared units."""
    areas: FloatArray = kernels.face_areas(vertices, faces)
    return areas


def signed_volume(mesh: Mesh) -> float:
    """Return the summed signed volumes of the tetrahedra from `Mesh.middle` to each face.

    For a closed mesh this is the enclosed volume, positive when the faces are counter-clockwise seen from
    outside. For an open mesh it is the volume closed by cones from there to the holes, so it turns and shifts
    with the mesh.
    """
    return float(kernels.signed_volume(mesh.vertices, mesh.faces, mesh.middle))


def orientation(mesh: Mesh) -> int:
    """Return -1 when the faces are wound inwards, that is when `signed_volume` is negative, else +1.

    The rule needs no closed mesh: a few holes take away only the cones over them.
    """
    return -1 if signed_volume(mesh) < 0 else 1


def is_closed(mesh: Mesh) -> bool:
    """Tell whether every directed edge occurs once and has exactly one opposite."""
    start, end = mesh.faces.ravel(), mesh.faces[:, [1, 2, 0]].ravel()
    edges = np.sort(start * len(mesh.vertices) + end)
    return is_balanced(mesh) and bool((np.diff(edges) > 0).all())


def is_balanced(mesh: Mesh) -> bool:
    """Tell whether every directed edge occurs as often as its opposite.

    Then the winding number is whole everywhere off the surface. Beside closed surfaces these are such as
    touch themselves, with four faces or more at an edge. Told by hashes, so wrong with a chance of 2⁻⁶⁴.
    """
    return bool(kernels.edge_sum(mesh.faces) == 0)


@lru_cache(maxsize=1)  # who smooths a mesh asks for them, and so does its pose
def volume_moments(mesh: Mesh) -> VolumeMoments:
    """Return volume, centroid and covariance of the enclosed solid of unit density.

    The integrals run over signed tetrahedra with their apex in `Mesh.middle`. Centroid and covariance are
    the same for either winding; holes are closed as in `signed_volume`.

    Parameters
    ----------
    mesh : Mesh
        Closed, or nearly so.

    Returns
    -------
    VolumeMoments
        `volume` in cubed units, `centroid` (3,) in units, `covariance` (3, 3) in squared units.

    Raises
    ------
    NoSolidError
        If the faces enclose no volume, as those of a flat sheet.
    """
    apex = mesh.middle
    volume, first, second = kernels.volume_integrals(mesh.vertices, mesh.faces, apex)
    check_volume(mesh, volume)
    offset = first / volume
    covariance = second / volume - offset[:, None] * offset
    return VolumeMoments(float(volume), apex + offset, covariance)


def is_nothing(mesh: Mesh, volume: float) -> bool:
    """Tell whether a volume is next to nothing for a mesh of this size."""
    return abs(volume) <= LEAST_VOLUME * mesh.diagonal**3


def check_volume(mesh: Mesh, volume: float) -> None:
    """Raise NoSolidError if a volume is next to nothing for a mesh of this size."""
    if is_nothing(mesh, volume):
        raise NoSolidError(
            f"{mesh.name}: its faces enclose no volume, as if all lay in a plane, but only a solid has the "
            "moments that fix its pose."
        )
