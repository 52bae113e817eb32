"""Unwelded meshes: copies of a vertex move together."""

import numpy as np
from shapes import blob

from wm3d import embed
from wm3d.mesh import Mesh


def test_marking_does_not_tear_a_mesh_whose_faces_share_no_vertices():
    smooth = blob(3)  # made rough, so that faces of one vertex look to both sides of the axis
    rough = np.random.default_rng(0).normal(scale=0.03, size=smooth.vertices.shape)
    welded = smooth.with_vertices(smooth.vertices + rough)
    corners = welded.faces.ravel()
    soup = Mesh(welded.vertices[corners], np.arange(corners.size).reshape(-1, 3))
    marked, _ = embed(soup, seed=5, scheme="song2002")
    low = np.full(welded.vertices.shape, np.inf)
    high = np.full(welded.vertices.shape, -np.inf)
    np.minimum.at(low, corners, marked.vertices)
    np.maximum.at(high, corners, marked.vertices)
    assert (high == low).all()
    assert (marked.vertices != soup.vertices).any()
