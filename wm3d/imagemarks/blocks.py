"""The 8×8 block DCT of an image and its inverse."""

import numpy as np
from scipy.fft import dctn, idctn

from wm3d.arrays import BoolArray, FloatArray

BLOCK = 8
"""Side of a DCT block, in pixels."""

AC = BLOCK * BLOCK - 1
"""AC coefficients of a block: all but the mean."""


def block_dct(image: FloatArray) -> FloatArray:
    """Return the orthonormal 2-D DCT of each 8×8 block.

    Parameters
    ----------
    image : (8 p, 8 q) ndarray

    Returns
    -------
    (p q, 64) ndarray
        One row a block, blocks and coefficients in row-major order; column 0 is DC.
    """
    rows, columns = image.shape
    tiles = image.reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK).swapaxes(1, 2)
    coefficients: FloatArray = dctn(tiles, axes=(2, 3), norm="ortho")
    return coefficients.reshape(-1, BLOCK * BLOCK)


def inverse_block_dct(coefficients: FloatArray, shape: tuple[int, int]) -> FloatArray:
    """Return the image of the given shape whose `block_dct` is `coefficients`."""
    rows, columns = shape
    tiles = coefficients.reshape(rows // BLOCK, columns // BLOCK, BLOCK, BLOCK)
    image: FloatArray = idctn(tiles, axes=(2, 3), norm="ortho")
    return np.ascontiguousarray(image.swapaxes(1, 2)).reshape(shape)


def block_all(mask: BoolArray) -> BoolArray:
    """Return, for each block in the order of `block_dct`, whether all of its 64 pixels are set: (p q,)."""
    rows, columns = mask.shape
    tiles = mask.reshape(rows // BLOCK, BLOCK, columns // BLOCK, BLOCK)
    whole: BoolArray = tiles.all(axis=(1, 3)).reshape(-1)
    return whole
