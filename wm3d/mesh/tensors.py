"""Symmetric tensors over three dimensions: their different entries, and what becomes of them under a map."""

import itertools
from functools import cache

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray


@cache
def rising(order: int) -> tuple[IntArray, ...]:
    """Return the indices of the different entries of a symmetric tensor, as numpy indexes with them."""
    rising = list(itertools.combinations_with_replacement(range(3), order))
    return tuple(np.array(column) for column in zip(*rising, strict=True))


@cache
def multiplicity(order: int) -> FloatArray:
    """How often each different entry stands in the tensor."""
    entries = zip(*rising(order), strict=True)
    return np.array([len(set(itertools.permutations(index))) for index in entries], dtype=float)


def symmetrized(tensor: FloatArray, terms: int) -> FloatArray:
    """Sum a tensor over the `terms` different ways of dealing out its indices."""
    orders = list(itertools.permutations(range(tensor.ndim)))
    mean: FloatArray = np.mean([np.transpose(tensor, order) for order in orders], axis=0)
    return terms * mean


def mapped(tensor: FloatArray, matrix: FloatArray) -> FloatArray:
    """Map all indices of a tensor by a matrix (3, 3)."""
    for _ in range(tensor.ndim):  # each turn maps the first index and makes it the last
        tensor = np.tensordot(tensor, matrix, axes=(0, 1))
    return tensor


def mapped_entries(tensor: FloatArray, matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the different entries of a mapped symmetric tensor and their derivatives by the matrix.

    Parameters
    ----------
    tensor : (3, ...) ndarray
        Of order k; symmetric in all indices.
    matrix : (3, 3) ndarray

    Returns
    -------
    entries : (n,) ndarray
        ``mapped(tensor, matrix)[rising(k)]``.
    slopes : (n, 9) ndarray
    """
    return _mapped_entries(tensor.ravel(), np.ascontiguousarray(matrix), _places(tensor.ndim))


@cache
def _places(order: int) -> IntArray:
    """Return `rising` with one row for an entry: (n, order)."""
    return np.column_stack(rising(order))


@njit(cache=True)
def _mapped_entries(
    tensor: FloatArray, matrix: FloatArray, places: IntArray
) -> tuple[FloatArray, FloatArray]:
    """`mapped_entries` of a flat tensor, (3ᵏ,), at places (n, k)."""
    count, order = places.shape
    half = tensor  # mapped in all indices but the last
    for _ in range(order - 1):
        half = _index_mapped(half, matrix)
    whole = _index_mapped(half, matrix)
    entries, slopes = np.empty(count), np.zeros((count, 9))
    for n in range(count):
        entries[n] = whole[_flat(places[n], order)]
        # d/dM_ij of Σ half_ab...j' M_cj' is half_ab...j wherever one of the indices is i
        for slot in range(order):
            rest = 3 * _flat(places[n], slot)
            for j in range(3):
                slopes[n, 3 * places[n, slot] + j] += half[rest + j]
    return entries, slopes


@njit(cache=True)
def _index_mapped(tensor: FloatArray, matrix: FloatArray) -> FloatArray:
    """Map the last index of a flat tensor and make it the first."""
    rest = len(tensor) // 3
    mapped = np.empty(len(tensor))
    for i in range(3):
        for r in range(rest):
            x, y, z = tensor[3 * r], tensor[3 * r + 1], tensor[3 * r + 2]
            mapped[i * rest + r] = matrix[i, 0] * x + matrix[i, 1] * y + matrix[i, 2] * z
    return mapped


@njit(cache=True)
def _flat(place: IntArray, omitted: int) -> int:
    """Where a place lies in a flat tensor, without the index that is omitted."""
    flat = 0
    for slot in range(len(place)):
        if slot != omitted:
            flat = 3 * flat + place[slot]
    return flat
