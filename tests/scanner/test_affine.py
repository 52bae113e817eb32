"""The affine frame: found again under every linear map, and refused where another one looks the same."""

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation
from shapes import blob, box, fine_box, icosphere, inside_out, lathe, rotation, tetrahedron, uv_cylinder

from wm3d.attacks import Bend, Clean, Crop, GaussianNoise, Mirror, Simplify
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, SolidMoments, signed_volume, solid_moments
from wm3d.scanner.affine import (
    AGREEMENT,
    MOST_WAYS,
    AffineFrame,
    fitted_frame,
    principal_frame,
    recognized,
    ways,
)
from wm3d.scanner.turns import TURNS, turns

MESH = blob(0, 4)
FRAME = principal_frame(MESH)
REFERENCE = solid_moments(MESH).mapped(FRAME.matrix)


def linear_map(seed: int) -> np.ndarray:
    """Random matrix of positive determinant that stretches by 0.3 to 3 along three axes."""
    stretch = np.diag(np.random.default_rng(seed).uniform(0.3, 3, 3))
    return rotation(2 * seed) @ stretch @ rotation(2 * seed + 1)


def apart(frame: AffineFrame, mesh: Mesh) -> float:
    """Largest distance, along an axis of the frame, of a vertex from where `MESH` has it in its own."""
    return np.abs(frame.posed(mesh) - FRAME.posed(MESH)).max()


def test_principal_frame_has_the_axes_of_the_solid_and_its_unit():
    assert np.linalg.det(FRAME.matrix) < 0
    np.testing.assert_allclose(FRAME.centroid, solid_moments(MESH).centroid)
    second = REFERENCE.second
    np.testing.assert_allclose(second, np.diag(np.diag(second)), atol=1e-14)
    assert second[0, 0] > second[1, 1] > second[2, 2]
    assert np.trace(second) == pytest.approx(1)
    unit = np.linalg.norm(FRAME.matrix, axis=1)
    np.testing.assert_allclose(FRAME.matrix @ FRAME.matrix.T, np.diag(unit**2), atol=1e-13)
    np.testing.assert_allclose(unit, unit[0])


def test_posed_vertices_are_the_map_of_the_mesh():
    expected = (MESH.vertices - FRAME.centroid) @ FRAME.matrix.T
    np.testing.assert_allclose(FRAME.posed(MESH), expected, atol=1e-14)
    posed = Mesh(expected, MESH.faces)
    assert signed_volume(posed) == pytest.approx(np.linalg.det(FRAME.matrix) * signed_volume(MESH))


@pytest.mark.parametrize("seed", range(10))
def test_frame_is_exact_under_linear_maps(seed):
    matrix = linear_map(seed)
    moved = MESH.with_vertices(MESH.vertices @ matrix.T)
    frame = fitted_frame(solid_moments(moved), REFERENCE).frame
    assert apart(frame, moved) < 1e-9
    np.testing.assert_allclose(frame.matrix @ matrix, FRAME.matrix, atol=1e-9)


@pytest.mark.parametrize("scale", [0.1, 1.0, 10.0])
def test_frame_is_exact_under_similarities(scale):
    moved = MESH.with_vertices(scale * MESH.vertices @ rotation(9).T + [50, -70, 20])
    assert apart(fitted_frame(solid_moments(moved), REFERENCE).frame, moved) < 1e-9


def test_winding_does_not_matter():
    inward = inside_out(MESH)
    np.testing.assert_allclose(principal_frame(inward).matrix, FRAME.matrix, atol=1e-12)
    assert apart(fitted_frame(solid_moments(inward), REFERENCE).frame, inward) < 1e-9


def test_moments_of_any_other_frame_can_be_the_reference():
    # nothing in the fit asks that the reference be principal
    matrix = -linear_map(3)
    frame = fitted_frame(solid_moments(MESH), solid_moments(MESH).mapped(matrix)).frame
    np.testing.assert_allclose(frame.matrix, matrix, atol=1e-9)


def mirror_image(mesh: Mesh) -> Mesh:
    return Mirror()(mesh, np.random.default_rng())


def test_no_map_mirrors():
    mirrored = mirror_image(MESH)
    frame = fitted_frame(solid_moments(mirrored), REFERENCE).frame
    assert np.linalg.det(frame.matrix) < 0
    there = solid_moments(mirrored).mapped(frame.matrix).components()
    goal = REFERENCE.components()
    assert np.linalg.norm(there - goal) > 5 * AGREEMENT * np.linalg.norm(goal)


@pytest.mark.parametrize("seed", range(5))
def test_mirror_image_is_recognized_and_posed_as_the_mesh_was(seed):
    noisy = GaussianNoise(percent=0.6)(MESH, np.random.default_rng(seed))
    moved = mirror_image(noisy.with_vertices(noisy.vertices @ linear_map(seed).T))
    found, (frame,) = recognized(moved, REFERENCE)
    np.testing.assert_allclose(frame.posed(found), FRAME.posed(noisy), atol=0.05)


@pytest.mark.parametrize(
    "attack",
    [Clean(), GaussianNoise(percent=1.0), Bend(degrees=20), Crop(percent=30)],
    ids=lambda a: a.label(),
)
def test_mesh_that_is_no_mirror_image_is_not_taken_for_one(attack):
    for seed in range(5):
        mesh = attack(MESH, np.random.default_rng(seed))
        assert recognized(mesh, REFERENCE)[0] is mesh


@pytest.mark.parametrize(
    ("attack", "most"),
    [(Simplify(ratio=0.3), 0.01), (GaussianNoise(percent=0.6), 0.03)],
    ids=lambda value: value.label() if not isinstance(value, float) else "",
)
def test_frame_hardly_moves_with_what_the_solid_does_not_feel(attack, most):
    # the mesh is 3.4 units long, so that one of 64 cells along the axis has 0.053
    frame = fitted_frame(solid_moments(attack(MESH, np.random.default_rng(1))), REFERENCE).frame
    assert apart(frame, MESH) < most


def test_starts_reach_every_rotation():
    even = turns(TURNS)
    np.testing.assert_allclose(even @ even.swapaxes(1, 2), np.broadcast_to(np.eye(3), even.shape), atol=1e-14)

    def off(turned: Rotation) -> np.ndarray:
        trace = turned.as_matrix().reshape(-1, 9) @ even.reshape(-1, 9).T
        return np.degrees(np.arccos((trace.max(axis=1) - 1) / 2))

    rng = np.random.default_rng(0)
    drawn = Rotation.random(1000, rng=rng)
    assert off(drawn).max() < 17
    worst = drawn[np.argsort(-off(drawn))[:40]]
    for size in np.repeat([3.0, 1.0, 0.3, 0.1], 30):  # degrees, on into the gaps
        aside = Rotation.from_rotvec(rng.normal(0, np.radians(size), (40, 3))) * worst
        farther = (off(aside) > off(worst))[:, None]
        worst = Rotation.from_quat(np.where(farther, aside.as_quat(), worst.as_quat()))
    assert 17 < off(worst).max() < 19


def relief() -> Mesh:
    """Plate with low waves on its upper face, without which it could be laid on itself in 24 ways."""
    plate = fine_box()
    x, y, z = plate.vertices.T
    waves = 0.04 * (z > 0.499) * (np.sin(4 * x + 1) * np.cos(3 * y - 0.5) + 0.5 * np.sin(2 * y + x))
    return plate.with_vertices(np.column_stack([x, y, z + waves]))


def test_frame_of_a_relief_is_exact_from_every_side():
    plate = relief()
    frame = principal_frame(plate)
    reference = solid_moments(plate).mapped(frame.matrix)
    for turn in Rotation.random(30, rng=np.random.default_rng(1)).as_matrix():
        turned = plate.with_vertices(plate.vertices @ turn.T)
        np.testing.assert_allclose(
            fitted_frame(solid_moments(turned), reference).frame.matrix @ turn, frame.matrix, atol=1e-6
        )


def flattened(mesh: Mesh, scale: tuple[float, float, float], name: str) -> Mesh:
    return Mesh(mesh.vertices * scale @ rotation(4).T + [5, 6, 7], mesh.faces, name=name)


def both_ways() -> Mesh:
    """Join two blobs, one wound outwards and one inwards."""
    one, other = blob(0, 3), inside_out(blob(1, 3))
    return Mesh(
        np.vstack([one.vertices, 0.8 * other.vertices + [4, 0, 0]]),
        np.vstack([one.faces, other.faces + len(one.vertices)]),
        "pair",
    )


def turned_blob(sides: int) -> Mesh:
    """Return a blob that a turn by 360°/sides about z maps onto itself."""
    mesh = icosphere(4)
    x, y, z = mesh.vertices.T
    around = np.arctan2(y, x)
    radius = 1 + 0.2 * np.sin(sides * around + 2 * z) * (1 - z**2) + 0.2 * z**3
    return Mesh(mesh.vertices * radius[:, None] * [1, 1, 1.5], mesh.faces, "turned blob")


@pytest.mark.parametrize(
    ("mesh", "count"),
    [
        (MESH, 1),
        (turned_blob(2), 2),
        (turned_blob(3), 3),
        (box((3, 2, 1)), 24),  # a linear map makes it a cube, which has as many
        (tetrahedron(), 12),
    ],
    ids=["blob", "twofold", "threefold", "box", "tetrahedron"],
)
@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_ways_to_lay_a_solid_on_itself_are_counted_in_any_unit(mesh, count, unit):
    scaled = mesh.with_vertices(unit * mesh.vertices @ rotation(5).T)
    assert ways(scaled, principal_frame(scaled)) == count


@pytest.mark.parametrize(
    "mesh",
    [
        icosphere(3),
        uv_cylinder(1, 5, 32, 4),
        flattened(icosphere(3), (3, 2, 1), "ellipsoid"),
        lathe(np.linspace(0, 3, 60), 0.6 + 0.3 * np.sin(np.linspace(0, 5, 60)), 80),
        lathe(np.linspace(0, 2, 60), np.linspace(1.01, 0.01, 60), 80),
    ],
    ids=["sphere", "cylinder", "ellipsoid", "vase", "cone"],
)
def test_what_is_round_has_more_ways_than_a_box(mesh):
    assert ways(mesh, principal_frame(mesh)) > MOST_WAYS


def test_every_frame_of_a_symmetric_solid_lays_it_as_it_was():
    mesh = turned_blob(3)
    own = principal_frame(mesh)
    moved = mesh.with_vertices(mesh.vertices @ linear_map(2).T + [1, 2, 3])
    found, frames = recognized(moved, solid_moments(mesh).mapped(own.matrix), ways=3)
    assert found is moved
    assert len(frames) == 3
    tree = KDTree(own.posed(mesh))
    for frame in frames:  # to the vertices nearest to where they were: the grid itself is not symmetric
        assert tree.query(frame.posed(found))[0].max() < 0.1


@pytest.mark.parametrize(
    ("mesh", "sentence"),
    [
        (flattened(box(), (3, 2, 0), "sheet"), "its faces enclose no volume"),
        (Mesh([[0, 0, 0], [3, 0, 0], [0, 1, 2]], [[0, 1, 2]], "triangle"), "its faces enclose no volume"),
        (both_ways(), "its faces bound no solid that extends in every direction; wind all parts alike"),
    ],
    ids=lambda value: value.name if isinstance(value, Mesh) else "",
)
def test_mesh_without_axes_is_refused_in_one_sentence(mesh, sentence):
    with pytest.raises(Wm3dError, match=f"^{mesh.name}: {sentence}") as refusal:
        principal_frame(mesh)
    assert str(refusal.value).count(". ") == 0


def test_whether_axes_are_unique_does_not_depend_on_a_stretch():
    upright = MESH.vertices @ rotation(0)
    for factor in (0.25, 4.0):
        stretched = MESH.with_vertices(upright * [factor, 1, 1])
        assert ways(stretched, principal_frame(stretched)) == 1


def test_mesh_without_a_volume_cannot_be_fitted():
    with pytest.raises(Wm3dError, match=r"^sheet: its faces enclose no volume"):
        recognized(flattened(box(), (3, 2, 0), "sheet"), SolidMoments.of_entries(REFERENCE.entries()))
