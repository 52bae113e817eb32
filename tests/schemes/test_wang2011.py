"""Volume moments of patches: the frame, the volumes and the deformation by other routes; what survives."""

import numpy as np
import pytest
from shapes import blob, box, icosphere, inside_out, rotation, uv_cylinder
from trimesh.intersections import slice_faces_plane

from wm3d.attacks import IsotropicRemesh, LaplacianSmoothing, Simplify, Subdivide, UniformNoise
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, signed_volume, volume_moments
from wm3d.schemes import SCHEMES
from wm3d.schemes.patches import Patches, deformed, kernels, volume_frame

MESH = blob(0, 5)
CELLS = Patches(5, 7)
SCHEME = SCHEMES.build("wang2011", {"bits": 24, "grid": (6, 5)})


def test_frame_turns_with_the_solid_and_does_not_see_the_winding():
    frame = volume_frame(MESH)
    for turn in map(rotation, range(10)):
        moved = volume_frame(Mesh(3 * MESH.vertices @ turn.T + [1, 2, 3], MESH.faces))
        np.testing.assert_allclose(moved.center, 3 * turn @ frame.center + [1, 2, 3], atol=1e-12)
        np.testing.assert_allclose(moved.axes, frame.axes @ turn.T, atol=1e-10)
        np.testing.assert_allclose([moved.low, moved.high], [3 * frame.low, 3 * frame.high], atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(frame.axes), 1)
    np.testing.assert_allclose(volume_frame(inside_out(MESH)).axes, frame.axes, atol=1e-12)


def test_axes_point_to_the_heavier_tail():
    # points of the solid, drawn in tetrahedra from the centroid: an independent third moment
    frame, rng = volume_frame(MESH), np.random.default_rng(0)
    corners = frame.posed(MESH)[MESH.faces]
    sizes = np.linalg.det(corners)
    assert (sizes > 0).all()
    face = rng.choice(len(sizes), 100_000, p=sizes / sizes.sum())
    shares = rng.dirichlet(np.ones(4), 100_000)[:, :3]
    points = np.einsum("kj,kji->ki", shares, corners[face])
    third = (points**3).mean(axis=0) / points.std(axis=0) ** 3
    assert third[0] > 0.01
    assert third[1] > 0.01


def test_patch_volumes_add_up_to_the_solid():
    frame = volume_frame(MESH)
    assert CELLS.volumes(MESH, frame).sum() == pytest.approx(CELLS.count, rel=1e-12)
    assert frame.volume == pytest.approx(signed_volume(MESH))


def test_patch_volume_is_that_of_the_surface_cut_by_planes():
    frame = volume_frame(MESH)
    posed = frame.posed(MESH)
    volumes = CELLS.volumes(MESH, frame).reshape(5, 7)
    step, turn = (frame.high - frame.low) / 5, 2 * np.pi / 7
    for i, j in ((0, 0), (2, 3), (4, 6)):
        bottom, left, right = frame.low + i * step, j * turn, (j + 1) * turn
        normals = [
            [1, 0, 0],
            [-1, 0, 0],
            [0, -np.sin(left), np.cos(left)],
            [0, np.sin(right), -np.cos(right)],
        ]
        vertices, faces = posed, MESH.faces
        for normal, at in zip(normals, (bottom, bottom + step, 0, 0), strict=True):
            vertices, faces, *_ = slice_faces_plane(vertices, faces, normal, [at, 0, 0])
        # the flux of (0, y, z)/2 through the piece
        a, b, c = vertices[faces].transpose(1, 0, 2)
        area = np.cross(b - a, c - a) / 2
        expected = (area[:, 1:] * (a + b + c)[:, 1:] / 3).sum() / 2
        assert volumes[i, j] * frame.volume / 35 == pytest.approx(expected, rel=1e-9)


def test_cylinder_has_equal_patches():
    mesh = uv_cylinder(radius=1.0, height=4.0, around=70, along=30)
    posed = Mesh(mesh.vertices[:, [2, 0, 1]], mesh.faces)
    cells = kernels.patch_volumes(posed.vertices, posed.faces, -2.0, 2.0, 4, 7)
    prism = 70 / 2 * np.sin(2 * np.pi / 70) * 4
    np.testing.assert_allclose(cells, prism / 28, rtol=1e-9)


def test_masks_vanish_at_the_borders_and_move_only_their_patch():
    frame = volume_frame(MESH)
    posed = frame.posed(MESH)
    index, u, v = CELLS.place(posed, frame)
    masks = CELLS.masks(posed, frame).toarray()
    own = masks[np.arange(len(posed))[:, None], 3 * index[:, None] + np.arange(3)]
    assert np.count_nonzero(masks) <= own.size
    border = np.maximum(np.abs(u), np.abs(v)) > 0.49
    assert 0 < np.abs(own[border]).max() < 0.002
    assert own[:, 0].max() > 0.9


def test_deformation_meets_the_volumes_and_keeps_the_frame():
    frame = volume_frame(MESH)
    before, chosen = CELLS.volumes(MESH, frame), np.array([3, 10, 17, 30])
    target = before[chosen] * [1.02, 0.97, 1.03, 0.99]
    moved = deformed(MESH, frame, CELLS, chosen, target)
    after = volume_frame(moved)
    np.testing.assert_allclose(CELLS.volumes(moved, after)[chosen], target, atol=1e-8)
    np.testing.assert_allclose(after.center, frame.center, atol=1e-9)
    np.testing.assert_allclose(after.axes, frame.axes, atol=1e-7)
    assert after.volume == pytest.approx(frame.volume, rel=1e-9)
    assert (after.low, after.high) == pytest.approx((frame.low, frame.high), abs=1e-9)
    # height and angle stay
    np.testing.assert_allclose(frame.posed(moved)[:, 0], frame.posed(MESH)[:, 0], atol=1e-12)


def test_volumes_go_the_costa_share_of_the_way_to_the_lattice_of_their_bit():
    scheme = SCHEME.model_copy(update={"costa": 1.0, "step": 0.04})
    marked, read = scheme.embed(MESH, 3)
    volumes = Patches(6, 5).volumes(marked, volume_frame(marked))[list(read.patches)]
    offset = np.where(scheme.signs(3) > 0, 0.0, 0.5)
    np.testing.assert_allclose(
        (volumes / 0.04 - offset) % 1, np.rint((volumes / 0.04 - offset) % 1), atol=1e-6
    )
    np.testing.assert_allclose(read.evidence(marked).b, scheme.signs(3), atol=1e-9)
    partly = scheme.model_copy(update={"costa": 0.7}).embed(MESH, 3)[0]
    start = Patches(6, 5).volumes(MESH, volume_frame(MESH))[list(read.patches)]
    reached = Patches(6, 5).volumes(partly, volume_frame(partly))[list(read.patches)]
    np.testing.assert_allclose(reached - start, 0.7 * (volumes - start), atol=1e-8)


@pytest.mark.parametrize(
    "attack",
    [
        UniformNoise(percent=0.5),
        LaplacianSmoothing(iterations=10),
        Simplify(ratio=0.3),
        Subdivide(rule="loop"),
    ],
    ids=lambda attack: attack.label(),
)
def test_bits_survive(attack):
    marked, scheme = SCHEME.embed(MESH, 1)
    evidence = scheme.evidence(attack(marked, np.random.default_rng(0)))
    assert evidence.bit_error_rate(scheme.signs(1)) <= 1 / 24
    assert evidence.score(scheme.signs(1)).detected(1e-6)


def test_a_remeshed_solid_is_read_without_the_numbers_of_the_patches():
    marked, _ = SCHEME.embed(MESH, 1)
    remeshed = IsotropicRemesh()(marked, np.random.default_rng(0))
    assert SCHEME.patches == ()
    assert SCHEME.score(remeshed, 1).detected(1e-6)


@pytest.mark.parametrize(
    ("mesh", "parameters", "sentence"),
    [
        (icosphere(3), {}, "icosphere: two principal moments of its volume are equal"),
        (box((3, 2, 1)), {}, "box: its volume is symmetric along principal axis 1"),
        (
            Mesh([[0, 0, 0], [5, 0, 0], [5, 3, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]], "sheet"),
            {},
            "sheet: its ",
        ),
    ],
    ids=["sphere", "box", "sheet"],
)
def test_mesh_without_a_frame_is_refused(mesh, parameters, sentence):
    with pytest.raises(Wm3dError, match=f"^{sentence}"):
        SCHEMES.build("wang2011", parameters).embed(mesh, 1)


@pytest.mark.parametrize(
    ("parameters", "sentence"),
    [
        ({"bits": 89}, "89 bits do not fit a grid of 88 patches"),
        ({"bits": 2, "patches": (1, 88)}, "patches must name 2 of the 88 patches of the grid"),
        ({"step": 0}, "step = 0: input should be greater than 0"),
    ],
)
def test_wrong_parameters_are_named(parameters, sentence):
    with pytest.raises(Wm3dError) as refusal:
        SCHEMES.build("wang2011", parameters)
    assert sentence in str(refusal.value)


def test_volumes_of_an_open_mesh_are_closed_by_cones():
    assert volume_moments(MESH).volume == pytest.approx(volume_frame(MESH).volume)
    half = Mesh(MESH.vertices, MESH.faces[:-400], "open blob")
    marked, scheme = SCHEME.embed(half, 1)
    assert scheme.score(marked, 1).log10_p < -6


def test_a_mesh_on_which_the_deformation_goes_astray_is_refused():
    half = Mesh(MESH.vertices, MESH.faces[: len(MESH.faces) // 2], "half")
    with pytest.raises(Wm3dError, match=r"^half: no deformation gives 64 patches their volumes"):
        SCHEMES.build("wang2011", {}).embed(half, 1)
