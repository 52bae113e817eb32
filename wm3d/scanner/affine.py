"""The affine pose: the linear map under which the moments of a solid are those that a key holds."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from wm3d.arrays import FloatArray
from wm3d.mesh import Mesh, SolidMoments, solid_moments, whitening
from wm3d.scanner import kernels
from wm3d.scanner.turns import TURNS, apart, turns

STARTS = 6
"""How many starts are tried to the end, the best first."""

APART = 30.0
"""Least angle between two starts, in degrees; about the reach of the fit from one."""

SETTLING, FARTHEST_STEP, NUDGE = 8, 10.0, 1e-6
"""Rounds in which starts are turned on, by how many degrees at most in one, and the turn in radians by which
slopes are taken."""

AGREEMENT = 1e-3
"""Misfit, relative to the moments themselves, at which a fit needs no further start and no mirror image."""

AMBIGUITY = 1e-2
"""Misfit below which another way to lay the axes is taken for as good; attacks come near to it."""

ELSEWHERE = 0.05
"""Least difference of an entry, relative to the axes, of two maps that lay the axes in another way."""

MOST_WAYS = 24
"""Most ways to lay a solid on itself: those of a box. A sphere or a cylinder has no end of them."""

ROUND = 0.015
"""Slope of the moments along the map that changes them least, relative to them, below which a solid is round.
A vase has 0.002, a cone of 80 sides 0.009; a cow has 0.1, and the least of other models, a blob, 0.024."""

ALIKE_STARTS, PATIENCE = 2 * MOST_WAYS, 60
"""How many starts are compared, tried to find all ways, and how many evaluations each is given: the right one
takes 2 to 25, one of a part that has none may take hundreds."""

MIRROR = np.array([1.0, 1.0, -1.0])
"""What the coordinates of a mesh are multiplied with to make its mirror image."""

MIRRORED = 0.5
"""Misfit of the mirror image, over that of the mesh, below which the mesh is taken for a mirror image itself;
where parts are cut off, which no linear map undoes, it is 0.67 or more."""


@dataclass(frozen=True, eq=False)
class AffineFrame:
    """Where a mesh lies in the frame of a scanner: x ↦ matrix (x − centroid).

    Attributes
    ----------
    centroid : (3,) ndarray
        Of the solid, in mesh units.
    matrix : (3, 3) ndarray
        From mesh units to the unit of the frame, in which the solid's second moments add up to 1. Its
        determinant is negative: the axes s1, s2, s3 of the scanner are left-handed.
    """

    centroid: FloatArray
    matrix: FloatArray

    def posed(self, mesh: Mesh) -> FloatArray:
        """Return the vertices in the frame: (n, 3), with the solid's centroid as origin."""
        posed: FloatArray = kernels.to_frame(mesh.vertices, self.centroid, self.matrix)
        return posed


def principal_frame(mesh: Mesh) -> AffineFrame:
    """Return the frame of a solid's own principal axes, the longest first.

    Which way the axes point does not matter to those who keep the moments: `recognized` finds it again.

    Raises
    ------
    Wm3dError
        If the mesh encloses no volume.
    """
    moments = solid_moments(mesh)
    axes = np.linalg.eigh(moments.second)[1].T[::-1]
    if np.linalg.det(axes) > 0:
        axes[2] *= -1
    return AffineFrame(moments.centroid, axes / np.sqrt(np.trace(moments.second)))


def ways(mesh: Mesh, frame: AffineFrame) -> int:
    """Count the linear maps that lay a solid on itself, or nearly: 1, unless it has a symmetry.

    None of them mirrors. What is round can be laid on itself in more ways than `MOST_WAYS`.
    """
    moments = solid_moments(mesh)
    reference = moments.mapped(frame.matrix)
    others = (fit for fit in _fits(moments, reference) if _apart(fit.matrix, frame.matrix))
    if min((fit.misfit for fit in others), default=math.inf) >= AMBIGUITY:
        return 1
    whitened = moments.mapped(whitening(moments.second, mesh.name)[0])
    values, slopes = whitened.components_of(np.eye(3))
    least = np.linalg.norm(slopes, ord=-2)  # of what is round, by a turn about its axis
    if least < ROUND * np.linalg.norm(values):
        return MOST_WAYS + 1
    return len(_alike(moments, reference))


class FittedFrame(NamedTuple):
    """A frame, and how far it leaves the moments from the reference, over the norm of the reference."""

    frame: AffineFrame
    misfit: float


def recognized(mesh: Mesh, reference: SolidMoments, ways: int = 1) -> tuple[Mesh, list[AffineFrame]]:
    """Return a mesh, not mirrored any more, and the frames in which its moments come nearest to given ones.

    Parameters
    ----------
    mesh : Mesh
        If it was mirrored, its mirror image is returned.
    reference : SolidMoments
    ways : int
        In how many ways the solid of the reference can be laid on itself. With one, one frame is returned;
        with more, all that come near, for the moments do not tell which it was, nor whether it was mirrored.

    Raises
    ------
    Wm3dError
        If the mesh encloses no volume.
    """
    moments = solid_moments(mesh)
    if ways > 1:
        return mesh, [AffineFrame(moments.centroid, fit.matrix) for fit in _alike(moments, reference)]
    fit = fitted_frame(moments, reference)
    if fit.misfit > AGREEMENT:
        image = moments.mapped(np.diag(MIRROR))._replace(centroid=moments.centroid * MIRROR)
        mirrored = fitted_frame(image, reference)
        if mirrored.misfit < MIRRORED * fit.misfit:
            return mirror_image(mesh), [mirrored.frame]
    return mesh, [fit.frame]


def mirror_image(mesh: Mesh) -> Mesh:
    """Return the mirror image of a mesh."""
    return Mesh(mesh.vertices * MIRROR, mesh.faces[:, ::-1], mesh.name)


def fitted_frame(moments: SolidMoments, reference: SolidMoments) -> FittedFrame:
    """Return the frame in which the moments of a mesh come nearest to given ones, over all linear maps.

    So a stretched or sheared mesh is scanned as it was. By least squares over the nine entries of the matrix;
    none of the maps mirrors.
    """
    best = None
    for fit in _fits(moments, reference):
        if best is None or fit.misfit < best.misfit:
            best = fit
        if best.misfit < AGREEMENT:
            break
    assert best is not None  # there is a start, whatever the mesh
    return FittedFrame(AffineFrame(moments.centroid, best.matrix), best.misfit)


class _Fit(NamedTuple):
    """A map and how far it leaves the moments from the reference, over the norm of the reference."""

    matrix: FloatArray
    misfit: float


def _alike(moments: SolidMoments, reference: SolidMoments) -> list[_Fit]:
    """Return the maps that meet the reference nearly as well as the best, which is the first."""
    found: list[_Fit] = []
    fits = sorted(_fits(moments, reference, ALIKE_STARTS), key=lambda fit: fit.misfit)
    for fit in fits:
        alike = fit.misfit < max(AMBIGUITY, 2 * fits[0].misfit)
        if alike and all(_apart(fit.matrix, other.matrix) for other in found):
            found.append(fit)
    return found


def _apart(one: FloatArray, other: FloatArray) -> bool:
    """Tell whether two maps lay the axes differently, whatever the unit of the mesh."""
    return not np.allclose(one @ np.linalg.inv(other), np.eye(3), rtol=0, atol=ELSEWHERE)


def _fits(moments: SolidMoments, reference: SolidMoments, starts: int = STARTS) -> Iterator[_Fit]:
    """Yield the maps to which least squares lead from each start.

    In coordinates in which the second moments of both are unit matrices: there the misfit does not depend on
    how long the solid is, and the map sought is nearly a rotation.
    """
    whiten = whitening(moments.second, "the mesh")[0]
    whiten_reference, colour = whitening(reference.second, "the reference")
    here, goal = moments.mapped(whiten), reference.mapped(whiten_reference)
    aim = goal.components()
    size = float(np.linalg.norm(aim))

    def residual(entries: FloatArray) -> FloatArray:
        return here.components_of(entries.reshape(3, 3))[0] - aim

    def slopes(entries: FloatArray) -> FloatArray:
        return here.components_of(entries.reshape(3, 3))[1]

    # the frame is left-handed
    mirror = -float(np.sign(np.linalg.det(colour) * np.linalg.det(whiten)))
    for start in _starts(here, goal, turns(TURNS) * [1.0, 1.0, mirror], starts):
        fit = least_squares(residual, start.ravel(), jac=slopes, method="lm", max_nfev=PATIENCE)
        yield _Fit(colour @ fit.x.reshape(3, 3) @ whiten, math.sqrt(2 * fit.cost) / size)


def _starts(here: SolidMoments, goal: SolidMoments, candidates: FloatArray, most: int) -> FloatArray:
    """Return the (k, 3, 3) turns under which the higher moments nearly agree, the best first.

    Candidates lie too far apart to say which is best where a solid is nearly symmetric: a plate with a low
    relief is a cube in these coordinates, and the relief tells its sides apart only where it lies exactly. So
    those that come nearest are turned on, until each is as near as it can come.
    """

    def differences(rotations: FloatArray) -> FloatArray:
        tensors = ((here.third, goal.third), (here.fourth, goal.fourth))
        return np.hstack(
            [(_turned(one, rotations) - aim).reshape(len(rotations), -1) for one, aim in tensors]
        )

    def ordered(rotations: FloatArray) -> FloatArray:
        ordered: FloatArray = rotations[np.argsort((differences(rotations) ** 2).sum(axis=1), kind="stable")]
        return ordered

    coarse = ordered(candidates)
    finer = ordered(_settled(coarse[apart(coarse, APART, ALIKE_STARTS)], differences))
    return finer[apart(finer, APART, most)]


def _settled(rotations: FloatArray, differences: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Turn (k, 3, 3) rotations on to where the sums of the squared differences are least, by Gauss-Newton."""
    nudges = Rotation.from_rotvec(NUDGE * np.eye(3)).as_matrix()
    longest = np.radians(FARTHEST_STEP)
    for _ in range(SETTLING):
        here = differences(rotations)
        slopes = np.stack([(differences(rotations @ nudge) - here) / NUDGE for nudge in nudges], axis=1)
        normal = slopes @ slopes.swapaxes(1, 2)
        damping = 1e-9 * np.trace(normal, axis1=1, axis2=2) + np.finfo(float).tiny  # a ball has no slopes
        normal += damping[:, None, None] * np.eye(3)
        step = np.linalg.solve(normal, -slopes @ here[:, :, None])[:, :, 0]
        length = np.linalg.norm(step, axis=1, keepdims=True)
        step *= np.minimum(1, longest / np.maximum(length, longest))
        rotations = rotations @ Rotation.from_rotvec(step).as_matrix()
    return rotations


def _turned(tensor: FloatArray, rotations: FloatArray) -> FloatArray:
    """Map all indices of a tensor by each of (k, 3, 3) matrices: (k, 3, ...)."""
    count, shape = len(rotations), tensor.shape
    tensors = np.broadcast_to(tensor, (count, *shape))
    for _ in shape:  # each maps the first index and makes it the last
        mapped = rotations @ tensors.reshape(count, 3, -1)
        tensors = np.moveaxis(mapped.reshape(count, *shape), 1, -1)
    return tensors
