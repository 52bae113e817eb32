"""Taking out crumples: nothing where there are none, no more than is needed where there are."""

import numpy as np
import pytest
from shapes import blob, box, inside_out, rotation, soup

from wm3d.attacks import GaussianNoise
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.mesh.kernels import umbrella_step
from wm3d.scanner.affine import principal_frame
from wm3d.scanner.denoise import CRUMPLED, MOST_STEPS, STEP, denoised, whitened_area
from wm3d.scanner.volume import volume_image

MESH = blob(0, 4)
AREA = whitened_area(MESH)


def noisy(percent: float) -> Mesh:
    return GaussianNoise(percent=percent)(MESH, np.random.default_rng(1))


def smoothed(mesh: Mesh, steps: int) -> Mesh:
    for _ in range(steps):
        mesh = mesh.with_vertices(umbrella_step(mesh.vertices, mesh.faces, STEP))
    return mesh


def test_whitened_area_of_a_box():
    extents = (1.0, 2.0, 3.0)
    # a cube of side √12 has unit second moments
    for mesh in (box(extents), inside_out(box(extents))):
        moved = mesh.with_vertices(7 * mesh.vertices @ rotation(1).T + [4, 5, 6])
        assert whitened_area(mesh) == pytest.approx(6 * 12, rel=1e-12)
        assert whitened_area(moved) == pytest.approx(6 * 12, rel=1e-9)


@pytest.mark.parametrize("percent", [0.0, 0.6, 1.0])
def test_surface_that_is_not_crumpled_stays_bit_for_bit(percent):
    mesh = noisy(percent)
    assert whitened_area(mesh) < CRUMPLED * AREA
    assert denoised(mesh, AREA) is mesh


@pytest.mark.parametrize("percent", [2.0, 4.0, 8.0])
def test_crumpled_surface_is_smoothed_until_its_area_is_near_what_it_was(percent):
    mesh = noisy(percent)
    result = denoised(mesh, AREA)
    assert whitened_area(mesh) > CRUMPLED * AREA
    assert whitened_area(result) <= CRUMPLED * AREA
    assert result.faces is mesh.faces
    # by the fewest steps that do
    steps = next(k for k in range(MOST_STEPS) if np.array_equal(smoothed(mesh, k).vertices, result.vertices))
    assert whitened_area(smoothed(mesh, steps - 1)) > CRUMPLED * AREA


def test_volume_image_comes_nearer_to_that_of_the_clean_mesh():
    frame = principal_frame(MESH)

    def image(mesh):
        return volume_image(frame.posed(mesh), mesh.faces, (32, 24), -1.8, 3.5, 1).volumes

    clean, mesh = image(MESH), noisy(6.0)
    before, after = (np.linalg.norm(image(m) - clean) for m in (mesh, denoised(mesh, AREA)))
    assert after < before / 2


def test_smoothing_ends_where_it_cannot_succeed():
    result = denoised(noisy(6.0), 1e-3 * AREA)
    np.testing.assert_array_equal(result.vertices, smoothed(noisy(6.0), MOST_STEPS).vertices)


def test_a_smooth_surface_that_is_there_twice_is_not_smoothed():
    n = len(MESH.vertices)
    beside = Mesh(np.vstack([MESH.vertices, MESH.vertices + 1e-9]), np.vstack([MESH.faces, MESH.faces + n]))
    assert whitened_area(beside) == pytest.approx(2 * AREA, rel=1e-6)
    assert denoised(beside, AREA) is beside


def test_mesh_without_a_volume_is_refused():
    sheet = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], "sheet")
    for call in (whitened_area, lambda mesh: denoised(mesh, AREA)):
        with pytest.raises(Wm3dError, match=r"^sheet: its faces enclose no volume"):
            call(sheet)


def test_faces_of_an_stl_file_are_smoothed_as_one_surface():
    mesh = noisy(4.0)
    np.testing.assert_allclose(
        denoised(soup(mesh), AREA).vertices, soup(denoised(mesh, AREA)).vertices, rtol=0, atol=1e-12
    )
