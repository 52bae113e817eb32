"""Settling: coefficients come to where their fine signs want them, by small moves of the asked size."""

import numpy as np
import pytest
from plain import plain_z
from shapes import blob

from wm3d.attacks import RoundTrip, Similarity, Simplify
from wm3d.errors import Wm3dError
from wm3d.imagemarks.fine_signs import FineSigns
from wm3d.schemes import RangeDct
from wm3d.schemes.informed import change_of, informed_moves
from wm3d.schemes.settled import settled_moves
from wm3d.schemes.volume_host import host_of
from wm3d.stats import key_signs

MESH = blob(0, 5)


@pytest.mark.parametrize("size", [6e-4, 6e-3])
def test_most_coefficients_come_to_their_places_by_moves_of_the_same_size(size):
    host = host_of(MESH, None)
    signs = key_signs(1, host.mark.amplitude.size)
    along = informed_moves(host, signs, size)
    fine = FineSigns.beside(host.mark, host.mark.strength_of(change_of(host, along), signs))
    wanted = key_signs(2, fine.capacity)
    settled = settled_moves(host, fine, wanted, along, size)
    assert host.size(settled) == pytest.approx(size, rel=1e-12)
    assert host.size(settled - along) < 0.4 * size

    def apart(moves):
        found = host.coefficients(moves)
        return float(np.median(np.abs(fine.nearest(found, wanted) - found) / fine.step))

    assert apart(along) > 0.2  # a quarter if they lie anywhere
    assert apart(settled) < 0.04


def test_fine_signs_outlive_what_changes_the_surface_little(embedded):
    marked, scheme = embedded
    plain = plain_z(scheme, marked, 1)
    for attack, times in ((Similarity(), 1.7), (RoundTrip(format="stl"), 1.7), (Simplify(ratio=0.8), 1.2)):
        attacked = attack(marked, np.random.default_rng(0))
        assert scheme.score(attacked, 1).z > times * plain


def test_a_mark_too_faint_for_its_plain_signs_is_refused_though_fine_ones_could_be_read():
    # 120 dB: what the plain signs of a coefficient say drowns in the host
    with pytest.raises(Wm3dError, match="the mark cannot be read even from the marked mesh"):
        RangeDct(alpha=1e-4).embed(MESH, 1)
