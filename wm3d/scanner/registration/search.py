"""Starts for a fit where nothing is known of the pose: turns, shifts and sizes of a part of the model."""

from typing import NamedTuple, Self

import numpy as np
from scipy.ndimage import distance_transform_edt

from wm3d.arrays import FloatArray, IntArray
from wm3d.scanner.registration import search_kernels as kernels
from wm3d.scanner.registration.landmarks import Landmarks
from wm3d.scanner.registration.search_kernels import CELL, FAR, GRID
from wm3d.scanner.registration.shifts import Runs, even_shifts
from wm3d.scanner.registration.surface import Surface
from wm3d.scanner.registration.warp import Warp
from wm3d.scanner.turns import apart, turns
from wm3d.threads import by_halves

STARTS, APART = 8, 20.0
"""How many starts are returned, the best first, and the least angle between two, in degrees."""

SIZES = (1.0, 0.85, 0.7, 0.55, 0.45)
"""Sizes of the surface tried, in that of the landmarks: a part of a model is smaller than the whole."""

SHIFT, SHIFT_AMID = 3, 2
"""Places of its middle tried: so many cells apart, fewer where the model may lie amid other things, for there
it is small."""

AMID = 0.5
"""Power of the size by which misfits are divided there."""

OWN = np.array([1.0, 1.0, -1.0])
"""Makes a rotation a way to lay a mesh that is no mirror image: the frame of a scanner is left-handed."""

TURNED, CANDIDATES, ROUNDS = 1000, 128, 6
"""How many turns are tried, one of them within 23° of any; how many of them, the best of each size, are led
nearer; and in how many rounds. Of all sizes together right ones would not be among the best: large ones meet
something anywhere."""

LEAST_SIZE, MOST_SIZE = 0.4, 1.1
"""Bounds of the sizes that are come to."""

PROBES, FEW_PROBES = 250, 64
"""Points of the surface by which the best and by which all places are compared: so many at least, where it
has them, and less than twice as many."""


class _Places(NamedTuple):
    """Ways to lay a surface on landmarks, whose middle is 0 and whose size is 1.

    Attributes
    ----------
    turn : (n, 3, 3) ndarray
    size : (n,) ndarray
    shift : (n, 3) ndarray
    """

    turn: FloatArray
    size: FloatArray
    shift: FloatArray


class _Field(NamedTuple):
    """Points as they are looked up from the cells of the cube.

    Attributes
    ----------
    points, normals : (k, 3) ndarray
        Their middle is 0, their size 1.
    nearest : (GRID³,) ndarray
        The one nearest to each cell.
    distance : (GRID³,) ndarray
        How far it is, `FAR` at most.
    power : float
        Misfits are divided by this power of the size: a model amid other things would fit best where it is
        small, on any even patch of them, and divided by all of its size where it is large.
    """

    points: FloatArray
    normals: FloatArray
    nearest: IntArray
    distance: FloatArray
    power: float

    @classmethod
    def of(cls, points: FloatArray, normals: FloatArray, power: float) -> Self:
        """Look up what is nearest to every cell."""
        cells = kernels.cells(points)
        landmark = np.full(GRID**3, -1)
        landmark[cells] = np.arange(len(points))
        cube = (landmark < 0).reshape((GRID,) * 3)
        distance, (i, j, k) = distance_transform_edt(cube, return_indices=True)
        nearest = landmark.reshape(cube.shape)[i, j, k]
        return cls(points, normals, nearest.ravel(), np.minimum(distance * CELL, FAR).ravel(), power)

    @property
    def looked_up(self) -> tuple[FloatArray, FloatArray, IntArray, FloatArray]:
        """What kernels take of this."""
        return self.points, self.normals, self.nearest, self.distance

    def misfit(self, places: _Places, probes: Landmarks) -> FloatArray:
        """Return how far probes lie off the points in each of (n,) places, on average."""
        misfit: FloatArray = kernels.misfits(probes.points, probes.normals, *places, *self.looked_up)
        return misfit / places.size**self.power


class Search(NamedTuple):
    """What is looked for: the suspect or its mirror image, as a part of the model or as all and more."""

    mirrored: bool
    whole: bool


def turned_starts(surface: Surface, landmarks: Landmarks, search: Search) -> list[Warp]:
    """Return the ways to lay a surface on landmarks under which points come nearest.

    Of a model that lost a part every point still has its landmark, and of one to which something was added
    every landmark has its point. So the points of the surface that would be landmarks themselves look for
    landmarks, or with `whole` the other way round. Turns are tried all around in some sizes, each at its best
    shift; the best places of each size are led to where points lie in tangent planes, and compared by these
    and by the normals.
    """
    suspect = Landmarks.of(surface, Warp.linear(np.eye(3), np.zeros(3)))
    if search.whole:
        middle, size = landmarks.points.mean(axis=0), float(np.linalg.norm(landmarks.points.std(axis=0)))
        model = Landmarks((landmarks.points - middle) / size, landmarks.normals)
        inverse = [
            Warp.linear(pose.matrix / size, pose.coefficients[0] - pose.matrix @ middle / size)
            for pose in _laid(model, suspect, search.mirrored, amid=True)
        ]
        return [pose.inverted() for pose in inverse]
    return _laid(suspect, landmarks, search.mirrored, amid=False)


def _laid(probes: Landmarks, others: Landmarks, mirrored: bool, amid: bool) -> list[Warp]:
    """Return the ways to lay probes, of middle 0 and size 1, on points among which all have their place."""
    goal = others.points.mean(axis=0)
    size = float(np.linalg.norm(others.points.std(axis=0)))
    field = _Field.of((others.points - goal) / size, others.normals, AMID if amid else 0.0)

    few, probes = (probes.every(max(len(probes.points) // count, 1)) for count in (FEW_PROBES, PROBES))
    hand, step = -OWN if mirrored else OWN, SHIFT_AMID if amid else SHIFT
    places = _approached(_tried(few, turns(TURNED) * hand, step, field), probes, field)
    order = np.argsort(field.misfit(places, probes), kind="stable")
    chosen = order[apart(places.turn[order], APART, STARTS)]
    return [
        Warp.linear(size * places.size[k] * places.turn[k], goal + size * places.shift[k]) for k in chosen
    ]


def _tried(probes: Landmarks, candidates: FloatArray, step: int, field: _Field) -> _Places:
    """Return the best of (n, 3, 3) turns for each of the sizes, each at its best shift."""
    sizes, shifts = np.array(SIZES), even_shifts(field.points, step)
    axes = np.argsort(np.abs(shifts).max(axis=0), kind="stable")  # for the longest runs
    runs = Runs.of(shifts[:, axes], step, field.distance.reshape((GRID,) * 3).transpose(axes))
    halves = by_halves(
        lambda half: kernels.nearest_tried(probes.points, half, sizes, *runs),
        np.ascontiguousarray(candidates[:, axes]),
    )
    misfit, shift = (np.concatenate(parts) for parts in zip(*halves, strict=True))
    best = np.argsort(misfit, axis=0, kind="stable")[:CANDIDATES]
    shifted = shifts[np.take_along_axis(shift, best, axis=0).T.ravel()]
    return _Places(candidates[best.T.ravel()], np.repeat(sizes, len(best)), CELL * shifted)


def _approached(places: _Places, probes: Landmarks, field: _Field) -> _Places:
    """Lead each place to where probes lie in the tangent planes of the points near them."""

    def led(which: IntArray) -> _Places:
        some = (part[which] for part in places)
        found = kernels.approached(
            probes.points, probes.normals, *some, *field.looked_up, ROUNDS, LEAST_SIZE, MOST_SIZE
        )
        return _Places(*found)

    one, other = by_halves(led, np.arange(len(places.size)))
    return _Places(*(np.concatenate(parts) for parts in zip(one, other, strict=True)))
