"""SNR by eq. 13: known values, and what it must not depend on."""

import math

import numpy as np
import pytest
from shapes import box, icosphere, rotation

from wm3d.errors import Wm3dError
from wm3d.metrics import snr

MESH = box((2, 2, 2))  # vertices at ±1: a variance of 1 along each axis, 3 in all


def test_moves_of_a_hundredth_of_the_spread_are_forty_decibels():
    # ±0.01 along each axis in the pattern of the corners: variance 3e-4 against 3
    assert snr(MESH, MESH.with_vertices(1.01 * MESH.vertices)) == pytest.approx(40, abs=1e-9)


def test_variance_is_summed_over_the_axes():
    moves = np.zeros((8, 3))
    moves[:4, 2] = 0.1  # mean 0.05, variance 0.0025
    expected = 10 * math.log10(3 / 0.0025)
    assert snr(MESH, MESH.with_vertices(MESH.vertices + moves)) == pytest.approx(expected, abs=1e-9)


def test_a_common_shift_is_no_distortion():
    assert snr(MESH, MESH) == math.inf
    assert snr(MESH, MESH.with_vertices(MESH.vertices + 0.5)) == math.inf


def test_rotation_and_scale_of_both_meshes_do_not_matter():
    marked = MESH.vertices + 0.01 * np.random.default_rng(1).normal(size=(8, 3))
    here = snr(MESH, MESH.with_vertices(marked))
    turn = 7 * rotation(2)
    there = snr(MESH.with_vertices(MESH.vertices @ turn.T), MESH.with_vertices(marked @ turn.T))
    assert there == pytest.approx(here, abs=1e-9)


def test_meshes_of_other_sizes_cannot_be_compared():
    with pytest.raises(Wm3dError, match=r"box has 8 vertices and icosphere has 42"):
        snr(MESH, icosphere(1))
