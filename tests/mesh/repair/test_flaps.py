"""Flaps are taken off, single faces on the wrong side turned over."""

import numpy as np
import pytest
from shapes import blob

from wm3d.attacks import Simplify
from wm3d.mesh import Mesh, is_closed, signed_volume, whole_surface

BLOB = blob(1, 3)


def with_faces(mesh: Mesh, *faces, outwards: float = 1.3) -> Mesh:
    """Glue faces on; vertex −1 − k of theirs is vertex k of the mesh, moved away from the origin."""
    faces = np.array(faces)
    moved = outwards * mesh.vertices[-1 - faces[faces < 0]]
    faces[faces < 0] = len(mesh.vertices) + np.arange(len(moved))
    return Mesh(np.vstack([mesh.vertices, moved]), np.vstack([mesh.faces, faces]))


def unbalanced(mesh: Mesh) -> int:
    """Count the edges that are run through more often one way than the other."""
    net: dict[tuple[int, int], int] = {}
    for face in mesh.faces.tolist():
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            edge = min(a, b), max(a, b)
            net[edge] = net.get(edge, 0) + (1 if a < b else -1)
    return sum(count != 0 for count in net.values())


@pytest.mark.parametrize("winding", [1, -1])
def test_a_flap_is_taken_off_and_the_solid_is_what_it_was(winding):
    a, b, _ = BLOB.faces[7].tolist()
    single = (a, b, -1 - a)[::winding]
    membrane = tuple(BLOB.faces[300].tolist())[::winding]  # over a face, with no rim of its own
    flapped = with_faces(BLOB, single, membrane)
    assert abs(signed_volume(flapped) / signed_volume(BLOB) - 1) > 1e-4
    healed = whole_surface(flapped)
    assert len(healed.faces) == len(BLOB.faces)
    assert is_closed(healed)
    assert signed_volume(healed) == pytest.approx(signed_volume(BLOB), rel=0.02)


def test_flaps_of_several_faces_go_one_after_the_other():
    a, b, _ = BLOB.faces[7].tolist()
    ladder = with_faces(BLOB, (b, a, -1 - a))
    tip = len(ladder.vertices) - 1
    longer = with_faces(ladder, (tip, a, -1 - a), outwards=1.5)
    healed = whole_surface(longer)
    np.testing.assert_array_equal(healed.faces, BLOB.faces)


def test_a_face_on_the_wrong_side_is_turned_over():
    faces = BLOB.faces.copy()
    faces[11] = faces[11, ::-1]
    healed = whole_surface(Mesh(BLOB.vertices, faces))
    assert len(healed.faces) == len(faces)
    assert is_closed(healed)
    assert signed_volume(healed) == pytest.approx(signed_volume(BLOB), rel=1e-12)


def test_what_clustering_leaves_unbalanced_is_nearly_all_set_right(bunny):
    clustered = Simplify(ratio=0.05, simplifier="clustering")(bunny, np.random.default_rng(0))
    before, after = unbalanced(clustered), unbalanced(whole_surface(clustered))
    assert before > 100
    assert after < 0.1 * before
