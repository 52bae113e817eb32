"""The compiled Hadamard kernel against its numpy twin and against the matrix itself."""

import numpy as np
import pytest
from scipy.linalg import hadamard

from wm3d.stats.kernels import LANES, hadamard_exceedances, hadamard_exceedances_numpy


@pytest.mark.parametrize("order", [16, 32, 64, 512, 1024, 2048, 8192])
def test_kernel_matches_its_numpy_twin(order, rng):
    weights = rng.integers(-9, 10, order).astype(np.float32)  # whole numbers: float32 sums them exactly
    bits = rng.integers(0, 1 << 16, (3, order)).astype(np.uint16)
    thresholds = np.sort(rng.integers(-3, 4, 9) * np.sqrt(order)).astype(np.float32).round()
    counts = hadamard_exceedances(weights, bits, thresholds)
    assert counts.shape == (3, 9, LANES)
    np.testing.assert_array_equal(counts, hadamard_exceedances_numpy(weights, bits, thresholds))


def test_keys_are_the_rows_of_the_signed_hadamard_matrix(rng):
    weights = rng.integers(1, 9, 16).astype(np.float32)
    bits = rng.integers(0, 1 << 16, (1, 16)).astype(np.uint16)
    thresholds = np.unique(rng.integers(-40, 40, 30)).astype(np.float32)
    signs = 1 - 2 * ((bits[0][:, None] >> np.arange(LANES)) & 1)
    statistics = hadamard(16) @ (signs * weights[:, None])  # (key, lane)
    expected = (statistics[None] >= thresholds[:, None, None]).sum(axis=1)
    np.testing.assert_array_equal(hadamard_exceedances(weights, bits, thresholds)[0], expected)
