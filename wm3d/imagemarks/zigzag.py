"""The zig-zag order of DCT coefficients: from low to high frequency, one anti-diagonal after the other."""

import numpy as np

from wm3d.arrays import IntArray


def zigzag(shape: tuple[int, int]) -> IntArray:
    """Return the flat indices of an array in the zig-zag order of JPEG; the first is DC.

    Parameters
    ----------
    shape : (rows, columns)

    Returns
    -------
    (rows columns,) ndarray of int
    """
    row, column = np.indices(shape)
    diagonal = row + column
    along = np.where(diagonal % 2 == 1, row, -row)  # down on odd diagonals, up on even ones
    order: IntArray = np.lexsort((along.ravel(), diagonal.ravel()))
    return order
