"""All metrics together: what they have in common."""

import numpy as np
import pytest
from shapes import blob

from wm3d.mesh import Mesh
from wm3d.metrics import compare


def test_a_vertex_that_no_face_uses_changes_no_metric() -> None:
    original = blob(0, 3)
    noise = 0.002 * np.random.default_rng(0).normal(size=original.vertices.shape)
    marked = original.with_vertices(original.vertices + noise)

    def beside(mesh: Mesh) -> Mesh:
        return Mesh(np.vstack([mesh.vertices, [[100.0, 0, 0]]]), mesh.faces)

    assert compare(beside(original), beside(marked)) == pytest.approx(compare(original, marked))
