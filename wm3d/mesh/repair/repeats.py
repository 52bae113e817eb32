"""Faces that lie on each other, as where a surface was stored twice or with both its sides."""

import numpy as np

from wm3d.arrays import BoolArray, IntArray
from wm3d.mesh.mesh import Mesh
from wm3d.mesh.places import marks
from wm3d.mesh.repair.kernels import face_keys

DOUBLED = 0.1
"""Share of the faces that lie on others from which each counts once. Simplifiers leave up to 0.03, folds
whose two sides cancel."""


def is_doubled(mesh: Mesh) -> bool:
    """Tell whether more than `DOUBLED` of the faces span the same three places as another before them."""
    keys = np.sort(_keys(mesh))
    return int(np.count_nonzero(keys[1:] == keys[:-1])) > DOUBLED * len(keys)


def first_of_each(mesh: Mesh) -> BoolArray:
    """Return which faces span three places that none before them does: (m,)."""
    single = np.zeros(len(mesh.faces), dtype=bool)
    single[np.unique(_keys(mesh), return_index=True)[1]] = True
    return single


def _keys(mesh: Mesh) -> IntArray:
    keys: IntArray = face_keys(marks(mesh.vertices), mesh.faces)
    return keys
