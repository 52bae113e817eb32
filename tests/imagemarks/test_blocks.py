"""The block DCT: orthonormal, invertible, blocks and frequencies in row-major order."""

import numpy as np
from scipy.fft import dct

from wm3d.imagemarks.blocks import block_all, block_dct, inverse_block_dct


def test_block_dct_is_the_matrix_product_of_each_tile_in_row_major_order():
    image = np.random.default_rng(1).normal(size=(16, 24))
    matrix = dct(np.eye(8), axis=0, norm="ortho")
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(8), atol=1e-15)
    tiles = [image[8 * i : 8 * i + 8, 8 * j : 8 * j + 8] for i in range(2) for j in range(3)]
    expected = [(matrix @ tile @ matrix.T).ravel() for tile in tiles]
    np.testing.assert_allclose(block_dct(image), expected, atol=1e-14)


def test_inverse_gives_the_image_back():
    image = np.random.default_rng(2).normal(size=(24, 16))
    np.testing.assert_allclose(inverse_block_dct(block_dct(image), image.shape), image, atol=1e-14)


def test_a_block_counts_only_if_all_its_pixels_do():
    mask = np.ones((16, 24), bool)
    mask[3, 9] = mask[15, 23] = False
    assert block_all(mask).tolist() == [True, False, True, True, True, False]
