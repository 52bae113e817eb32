"""Meshes: the immutable triangle mesh, its files, its moments and the registry of named data."""

from wm3d.mesh.io import ENDINGS, load_mesh, save_mesh
from wm3d.mesh.mesh import FloatArray, IntArray, Mesh

__all__ = ["ENDINGS", "FloatArray", "IntArray", "Mesh", "load_mesh", "save_mesh"]
