"""A suspect mesh brought onto its original: registered by a similarity, and resampled at its vertices."""

import numpy as np
from scipy.spatial.transform import Rotation

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, face_areas, has_area
from wm3d.metrics.surface.nearest import Nearest, Surface

ITERATIONS = 30
"""Of the iterative closest points; what is left then moves less than the mark."""

_POINTS = 4000  # of the iterations
_TRIALS = 400  # for the choice of a starting pose
_FAR = 3.0  # medians: pairs farther apart do not count, so that a missing part does not pull
_LOST = 6.0  # medians: a vertex whose nearest point is farther has no counterpart


def resampled(original: Mesh, suspect: Mesh) -> FloatArray:
    """Return where each vertex of the original is found on a suspect, in the frame of the original.

    A suspect with the original's faces is taken vertex by vertex. Any other is registered by iterative
    closest points (Besl and McKay 1992) with scale, from the better of its own pose and the 24 ways to lay
    its principal axes on the original's; then each vertex goes to the nearest point of the suspect.

    Returns
    -------
    (n, 3) ndarray
        The original vertex itself where it has no counterpart, as where a part was cut away.

    Raises
    ------
    Wm3dError
        If the suspect's faces have no area, so that there is nothing to register.
    """
    if np.array_equal(suspect.faces, original.faces):
        return _vertex_by_vertex(original, suspect)
    if not has_area(suspect):
        raise Wm3dError(f"{suspect.name}: its faces have no area, so it cannot be laid on the original.")
    origin, unit = original.middle, original.diagonal
    mine = (original.vertices - origin) / unit
    center, size = suspect.middle, suspect.diagonal
    theirs = (suspect.vertices - center) / size
    surface = Surface(theirs, suspect.faces)
    own_pose = _similarity((theirs * size + center - origin) / unit, theirs)
    used = np.unique(original.faces)
    points = mine[used[:: max(1, len(used) // _POINTS)]]
    pose = _best(points, surface, [own_pose, *_principal(original, suspect, mine, theirs)])
    for _ in range(ITERATIONS):
        found = surface.nearest(_apply(pose, points))
        near = found.distance <= _FAR * np.median(found.distance) + 1e-12
        pose = _similarity(points[near], _places(surface, found)[near])
    found = surface.nearest(_apply(pose, mine))
    back = _apply(np.linalg.inv(pose).astype(np.float64), _places(surface, found))
    lost = found.distance > _LOST * np.median(found.distance)
    back[lost] = mine[lost]
    found_at: FloatArray = back * unit + origin
    return found_at


def _vertex_by_vertex(original: Mesh, suspect: Mesh) -> FloatArray:
    used = np.flatnonzero(original.used)  # the two may have any number of others
    pose = _similarity(suspect.vertices[used], original.vertices[used])
    found_at = original.vertices.copy()
    found_at[used] = _apply(pose, suspect.vertices[used])
    return found_at


def _similarity(points: FloatArray, targets: FloatArray) -> FloatArray:
    """Return the similarity (4, 4), without reflection, that brings points nearest to their targets."""
    from trimesh.registration import procrustes

    matrix: FloatArray = procrustes(points, targets, reflection=False, return_cost=False)
    return matrix


def _apply(matrix: FloatArray, points: FloatArray) -> FloatArray:
    from trimesh.transformations import transform_points

    moved: FloatArray = np.ascontiguousarray(transform_points(points, matrix))
    return moved


def _places(surface: Surface, found: Nearest) -> FloatArray:
    corners = surface.corners[found.face]
    places: FloatArray = np.einsum("kj,kji->ki", found.weights, corners)
    return places


def _best(points: FloatArray, surface: Surface, poses: list[FloatArray]) -> FloatArray:
    few = points[:: max(1, len(points) // _TRIALS)]
    misses = [np.median(surface.nearest(_apply(pose, few)).distance) for pose in poses]
    return poses[int(np.argmin(misses))]


def _principal(original: Mesh, suspect: Mesh, mine: FloatArray, theirs: FloatArray) -> list[FloatArray]:
    """Return the 24 similarities that lay the principal axes of the two surfaces on each other."""
    here, my_axes, my_size = _area_frame(mine, original)
    there, axes, size = _area_frame(theirs, suspect)
    poses = []
    for turn in Rotation.create_group("O").as_matrix():
        pose = np.eye(4)
        pose[:3, :3] = size / my_size * axes @ turn @ my_axes.T
        pose[:3, 3] = there - pose[:3, :3] @ here
        poses.append(pose)
    return poses


def _area_frame(vertices: FloatArray, mesh: Mesh) -> tuple[FloatArray, FloatArray, float]:
    """Return centroid, right-handed principal axes as columns, and root mean square radius over the area."""
    corners = vertices[mesh.faces]
    areas = face_areas(vertices, mesh.faces)
    middles = corners.mean(axis=1)
    centroid = areas @ middles / areas.sum()
    arms = middles - centroid
    covariance = (areas[:, None] * arms).T @ arms / areas.sum()
    _, axes = np.linalg.eigh(covariance)
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    return centroid, axes, float(np.sqrt(np.trace(covariance)))
