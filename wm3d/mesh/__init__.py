"""Meshes: the immutable triangle mesh, its files, its moments and the registry of named data."""

from wm3d.mesh import datasets
from wm3d.mesh.adjacency import adjacency
from wm3d.mesh.files import Secret, check_target, write_together, write_whole
from wm3d.mesh.io import ENDINGS, decode_mesh, encode_mesh, load_mesh, save_mesh
from wm3d.mesh.mesh import Mesh
from wm3d.mesh.moments import (
    VertexMoments,
    VolumeMoments,
    face_areas,
    has_area,
    is_balanced,
    is_closed,
    orientation,
    signed_volume,
    surface_area,
    vertex_moments,
    volume_moments,
)
from wm3d.mesh.normals import vertex_normals
from wm3d.mesh.places import places, sewn
from wm3d.mesh.repair import Part, large_parts, whole_surface
from wm3d.mesh.sampling import surface_points
from wm3d.mesh.solid import SolidMoments, solid_moments, whitening

__all__ = [
    "ENDINGS",
    "Mesh",
    "Part",
    "Secret",
    "SolidMoments",
    "VertexMoments",
    "VolumeMoments",
    "adjacency",
    "check_target",
    "datasets",
    "decode_mesh",
    "encode_mesh",
    "face_areas",
    "has_area",
    "is_balanced",
    "is_closed",
    "large_parts",
    "load_mesh",
    "orientation",
    "places",
    "save_mesh",
    "sewn",
    "signed_volume",
    "solid_moments",
    "surface_area",
    "surface_points",
    "vertex_moments",
    "vertex_normals",
    "volume_moments",
    "whitening",
    "whole_surface",
    "write_together",
    "write_whole",
]
