"""The zig-zag order: that of JPEG, on any rectangle."""

import numpy as np

from wm3d.imagemarks.zigzag import zigzag


def test_order_is_that_of_the_jpeg_standard():
    # ISO/IEC 10918-1, figure 5: the first 21 of an 8×8 block, row-major
    jpeg = [0, 1, 8, 16, 9, 2, 3, 10, 17, 24, 32, 25, 18, 11, 4, 5, 12, 19, 26, 33, 40]
    assert zigzag((8, 8))[:21].tolist() == jpeg


def test_order_walks_over_a_rectangle_in_single_steps():
    order = zigzag((5, 9))
    assert sorted(order) == list(range(45))
    row, column = np.divmod(order, 9)
    assert np.abs(np.diff(row)).max() == np.abs(np.diff(column)).max() == 1
