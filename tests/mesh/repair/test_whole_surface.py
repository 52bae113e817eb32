"""Faces stored twice count once, all are wound alike, small holes are covered; large ones stay open."""

import numpy as np
import pytest
from scipy.spatial import KDTree
from shapes import blob, box, soup, together

from wm3d.attacks import DropFaces, FlipFaces, HalfSpaceCrop, Reorder, RepeatFaces
from wm3d.mesh import Mesh, is_balanced, is_closed, signed_volume, surface_area, whole_surface
from wm3d.mesh.repair.kernels import face_keys
from wm3d.mesh.repair.sides import Sides
from wm3d.mesh.repair.winding import winding_turns

BLOB = blob(1, 4)


def rng() -> np.random.Generator:
    return np.random.default_rng(7)


@pytest.mark.parametrize(
    "mesh", [BLOB, soup(BLOB), together(BLOB, box())], ids=["closed", "unwelded", "parts"]
)
def test_a_surface_without_fault_is_returned_itself(mesh):
    assert whole_surface(mesh) is mesh


@pytest.mark.parametrize("percent", [1, 10, 50, 90])
@pytest.mark.parametrize("make", [lambda mesh: mesh, soup], ids=["welded", "unwelded"])
def test_faces_turned_over_at_random_are_wound_alike_again(percent, make):
    flipped = FlipFaces(percent=percent)(make(BLOB), rng())
    assert not is_balanced(flipped)
    assert abs(signed_volume(whole_surface(flipped))) == pytest.approx(abs(signed_volume(BLOB)), rel=1e-5)


@pytest.mark.parametrize("percent", [2, 20, 50, 90])
@pytest.mark.parametrize("torn", [False, True], ids=["closed", "torn"])
def test_patches_turned_over_are_wound_alike_again(percent, torn):
    surface = HalfSpaceCrop(percent=20)(BLOB, rng()) if torn else BLOB
    flipped = FlipFaces(percent=percent, patches=50)(surface, rng())
    whole = whole_surface(flipped).faces[: len(surface.faces)]  # without covers
    as_before = (whole == surface.faces).all(axis=1)
    assert not (flipped.faces == surface.faces).all()
    assert as_before.all() or not as_before.any()


def test_every_part_is_wound_outwards_where_the_winding_says_nothing():
    aside = Mesh(box().vertices + 9.0, box().faces)
    both = together(BLOB, aside)
    whole = whole_surface(FlipFaces(percent=50)(both, rng()))
    assert is_closed(whole)
    volume = abs(signed_volume(BLOB)) + abs(signed_volume(aside))
    assert signed_volume(whole) == pytest.approx(volume, rel=1e-9)


def test_a_part_wound_inwards_stays_so_where_most_of_it_is():
    inwards = Mesh(BLOB.vertices, BLOB.faces[:, ::-1])
    whole = whole_surface(FlipFaces(percent=20)(inwards, rng()))
    assert signed_volume(whole) == pytest.approx(-signed_volume(BLOB), rel=1e-12)


def test_a_moebius_band_has_no_two_windings_and_keeps_what_it_has():
    near, far = np.arange(0, 40, 2), np.arange(1, 40, 2)
    after_near, after_far = np.r_[near[1:], far[0]], np.r_[far[1:], near[0]]
    band = np.vstack([np.c_[near, after_near, far], np.c_[after_near, after_far, far]])
    band[::2] = band[::2, ::-1]
    turns = winding_turns(Sides.of(band), np.ones(len(band)))
    assert (turns == 1).all()


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("percent", [30, 100])
def test_faces_stored_twice_count_once(percent, turned):
    whole = whole_surface(RepeatFaces(percent=percent, turned=turned)(BLOB, rng()))
    np.testing.assert_array_equal(whole.faces, BLOB.faces)


def test_a_copy_with_vertices_of_its_own_counts_once():
    whole = whole_surface(together(BLOB, BLOB))
    assert surface_area(whole) == pytest.approx(surface_area(BLOB), rel=1e-12)


def test_the_two_sides_of_a_small_fold_stay_and_cancel():
    a, b, c = BLOB.faces[7]
    folded = Mesh(BLOB.vertices, np.vstack([BLOB.faces, [[a, b, c], [c, b, a]]]))
    assert whole_surface(folded) is folded


def test_single_missing_faces_come_back():
    kept = np.ones(len(BLOB.faces), bool)
    kept[::97] = False
    whole = whole_surface(Mesh(BLOB.vertices, BLOB.faces[kept]))
    assert is_closed(whole)
    assert signed_volume(whole) == pytest.approx(signed_volume(BLOB), rel=1e-12)


@pytest.mark.parametrize("percent", [5, 20])
def test_small_holes_are_covered_nearly_as_the_surface_was(percent):
    torn = DropFaces(percent=percent)(BLOB, rng())
    whole = whole_surface(torn)
    assert is_balanced(whole)
    assert signed_volume(whole) == pytest.approx(signed_volume(BLOB), rel=2e-4 * percent)


@pytest.mark.parametrize("seed", range(4))
def test_holes_that_touch_are_covered_close_by_in_whatever_order_the_file_is(seed):
    fine = blob(1, 5)
    holed = DropFaces(percent=40)(fine, np.random.default_rng(seed))
    volume = abs(signed_volume(whole_surface(holed)))
    assert volume == pytest.approx(abs(signed_volume(fine)), rel=0.06)
    shuffled = whole_surface(Reorder()(holed, rng()))
    assert abs(signed_volume(shuffled)) == pytest.approx(volume, rel=1e-9)


def test_the_rim_where_a_part_was_cut_off_stays():
    height = BLOB.vertices[BLOB.faces].mean(axis=1)[:, 2]
    bowl = Mesh(BLOB.vertices, BLOB.faces[height < np.quantile(height, 0.6)])
    assert whole_surface(bowl) is bowl


def test_faces_that_hang_together_nowhere_are_not_covered():
    apart = Mesh(soup(BLOB).vertices + rng().normal(size=(3 * len(BLOB.faces), 3)) * 1e-3, soup(BLOB).faces)
    assert whole_surface(apart) is apart


@pytest.mark.parametrize("size", [10, 50])
def test_patches_that_hang_together_with_no_other_are_not_given_their_other_side(size):
    middles = BLOB.vertices[BLOB.faces].mean(axis=1)
    seeds = middles[rng().permutation(len(middles))[: len(middles) // size]]
    patch = KDTree(seeds).query(middles)[1]
    corners = BLOB.vertices[BLOB.faces] + 1e-9 * patch[:, None, None]
    apart = Mesh(corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3))
    assert signed_volume(whole_surface(apart)) == pytest.approx(signed_volume(BLOB), rel=0.03)


def test_a_rim_of_few_sides_that_is_long_for_the_model_stays():
    coarse = blob(1, 2)
    bowl = Mesh(coarse.vertices, coarse.faces[coarse.vertices[coarse.faces].mean(axis=1)[:, 2] < 0.2])
    stray = Mesh(np.vstack([bowl.vertices, [[100, 0, 0]]]), bowl.faces)
    for mesh in (bowl, stray):  # a vertex that no face uses decides nothing
        assert whole_surface(mesh) is mesh


def test_keys_tell_faces_apart_as_their_sorted_corners_do():
    faces = rng().integers(0, 9, size=(500, 3))
    keys = face_keys(np.arange(9, dtype=np.uint64) ** 5, faces)
    flat = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    expected = len(np.unique(np.sort(faces[~flat], axis=1), axis=0)) + np.count_nonzero(flat)
    assert len(np.unique(keys)) == expected


def test_faces_are_at_variance_where_two_alone_at_an_edge_run_through_it_in_one_direction():
    draws, seen = rng(), set()
    for _ in range(500):  # some corners coincide, some faces repeat, some edges have three faces and more
        sides = Sides.of(draws.integers(7, size=(draws.integers(1, 7), 3)))
        ways = {}
        for edge, way in zip(sides.edges.ravel(), sides.direction.ravel(), strict=True):
            ways.setdefault(edge, []).append(way)
        expected = any(pair in ([1, 1], [-1, -1]) for pair in ways.values())
        assert sides.at_variance == expected
        seen.add(expected)
    assert seen == {True, False}
