"""Symmetric tensors over three dimensions: their different entries, and what becomes of them under a map."""

import itertools
from functools import cache

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh import kernels


@cache
def rising(order: int) -> tuple[IntArray, ...]:
    """Return the indices of the different entries of a symmetric tensor, as numpy indexes with them."""
    entries = itertools.combinations_with_replacement(range(3), order)
    return tuple(np.array(column) for column in zip(*entries, strict=True))


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
    entries: FloatArray
    slopes: FloatArray
    entries, slopes = kernels.mapped_entries(
        tensor.ravel(), np.ascontiguousarray(matrix), _places(tensor.ndim)
    )
    return entries, slopes


@cache
def _places(order: int) -> IntArray:
    """Return `rising` with one row for an entry: (n, order)."""
    return np.column_stack(rising(order))
