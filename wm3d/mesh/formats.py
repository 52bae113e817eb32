"""Mesh formats as bytes: PLY, OBJ, OFF, STL and GLB, with vertices and faces in the order of the file.

trimesh does the work wherever it keeps that order, and is imported there, for it takes longer to load than a
PLY file takes to read. It does not in three places, which are written out: its
OBJ reader splits vertices by texture index and groups faces by material, its OFF reader takes a file that was
cut short for a smaller mesh, and for PLY see `ply`.
"""

import codecs
import io
import re
from collections.abc import Callable
from itertools import chain

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh.mesh import Mesh
from wm3d.mesh.ply import read_ply, write_ply
from wm3d.mesh.polygons import triangulated

Arrays = tuple[FloatArray, IntArray]

#: A float32 format may move a vertex by this part of the bounding-box diagonal, about 1/100 of a faint mark.
FLOAT32_TOLERANCE = 1e-5


def read_obj(content: bytes) -> Arrays:
    """Read the `v` and `f` lines of Wavefront OBJ; polygons are split, relative indices resolved."""
    vertices: list[list[bytes]] = []
    polygons: list[list[int]] = []
    text = content.removeprefix(codecs.BOM_UTF8).replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    for number, line in enumerate(text.splitlines(), start=1):
        fields = line.partition(b"#")[0].split()
        if not fields or fields[0] not in (b"v", b"f"):
            continue
        if len(fields) < 4:
            raise ValueError(f"line {number} has {len(fields) - 1} entries, expected 3 or more")
        if fields[0] == b"v":
            vertices.append(fields[1:4])
        else:
            polygons.append([_obj_index(field, len(vertices)) for field in fields[1:]])
    if not vertices:
        raise ValueError("no v lines")
    return _split(np.array(vertices, dtype=np.float64), polygons)


def _obj_index(corner: bytes, defined: int) -> int:
    """Zero-based vertex index of `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative ones count back from here."""
    index = int(corner.partition(b"/")[0])
    if index == 0:
        raise ValueError("vertex index 0; OBJ counts from 1")
    return index - 1 if index > 0 else defined + index


def read_off(content: bytes) -> Arrays:
    """Read ASCII OFF, also with colours or normals behind the coordinates; polygons are split."""
    text = re.sub(rb"#.*", b"", content.removeprefix(codecs.BOM_UTF8))
    header = re.match(rb"\s*[A-Z]*OFF\s*(\d+)\s+(\d+).*", text)
    if header is None:
        raise ValueError("no OFF header with the counts")
    n, m = int(header[1]), int(header[2])
    rows = [fields for line in text[header.end() :].splitlines() if (fields := line.split())]
    if len(rows) < n + m:
        raise ValueError(f"{n} vertices and {m} faces announced, {len(rows)} lines found")
    vertices = np.array([row[:3] for row in rows[:n]], dtype=np.float64).reshape(n, 3)
    polygons: list[list[int]] = []
    for count, *corners in rows[n : n + m]:
        if len(corners) < int(count) or int(count) < 3:
            raise ValueError(f"a face of {int(count)} corners lists {len(corners)}")
        polygons.append([int(corner) for corner in corners[: int(count)]])
    return _split(vertices, polygons)


def read_stl(content: bytes) -> Arrays:
    """Read STL, binary or ASCII: three vertices a face, in file order, nothing merged."""
    from trimesh.exchange.stl import load_stl

    loaded = load_stl(io.BytesIO(content))
    solids = list(loaded["geometry"].values()) if "geometry" in loaded else [loaded]
    if not solids:
        raise ValueError("neither ASCII solids nor a binary STL of the length that its header states")
    vertices = np.concatenate([solid["vertices"] for solid in solids]).astype(np.float64)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def read_glb(content: bytes) -> Arrays:
    """Read binary glTF 2: the triangle meshes of its scene, moved by their nodes, as trimesh walks them."""
    if b"KHR_draco_mesh_compression" in content or b"EXT_meshopt_compression" in content:
        raise ValueError("its geometry is compressed, which wm3d does not decode")
    from trimesh import load_scene

    scene = load_scene(io.BytesIO(content), file_type="glb", process=False, skip_materials=True)
    mesh = scene.to_mesh()
    return np.asarray(mesh.vertices, np.float64).reshape(-1, 3), np.asarray(mesh.faces, np.int64).reshape(
        -1, 3
    )


def write_obj(mesh: Mesh) -> bytes:
    """Return OBJ text whose decimals give back every float64 coordinate."""
    return _export(mesh, "obj", digits=_decimals(mesh), header=None)


def write_off(mesh: Mesh) -> bytes:
    """Return OFF text whose decimals give back every float64 coordinate."""
    return _export(mesh, "off", digits=_decimals(mesh))


def write_stl(mesh: Mesh) -> bytes:
    """Return binary STL: 3 m vertices, float32; vertices without a face are lost."""
    _refuse_coarse_float32(mesh, "STL")
    return _export(mesh, "stl")


def write_glb(mesh: Mesh) -> bytes:
    """Return binary glTF 2 with one mesh, float32."""
    _refuse_coarse_float32(mesh, "GLB")
    return _export(mesh, "glb")


READERS: dict[str, Callable[[bytes], Arrays]] = {
    ".ply": read_ply,
    ".obj": read_obj,
    ".off": read_off,
    ".stl": read_stl,
    ".glb": read_glb,
}
WRITERS: dict[str, Callable[[Mesh], bytes]] = {
    ".ply": write_ply,
    ".obj": write_obj,
    ".off": write_off,
    ".stl": write_stl,
    ".glb": write_glb,
}


def _export(mesh: Mesh, file_type: str, **options: object) -> bytes:
    from trimesh import Trimesh

    exported = Trimesh(mesh.vertices, mesh.faces, process=False).export(file_type=file_type, **options)
    return exported.encode() if isinstance(exported, str) else bytes(exported)


def _decimals(mesh: Mesh) -> int:
    """Digits behind the point that leave 17 significant ones to the smallest coordinate."""
    sizes = np.abs(mesh.vertices[mesh.vertices != 0])
    return max(0, 16 - int(np.floor(np.log10(sizes.min()))))


def _refuse_coarse_float32(mesh: Mesh, what: str) -> None:
    with np.errstate(over="ignore", invalid="ignore"):
        moved = np.abs(mesh.vertices.astype(np.float32).astype(np.float64) - mesh.vertices).max()
    if not moved <= FLOAT32_TOLERANCE * mesh.diagonal:
        raise ValueError(
            f"{what} holds float32, which would move a vertex by {moved:.3g}; move the mesh to the origin "
            "or write PLY, OBJ or OFF"
        )


def _split(vertices: FloatArray, polygons: list[list[int]]) -> Arrays:
    lengths = np.array([len(polygon) for polygon in polygons], dtype=np.int64)
    corners = np.array(list(chain.from_iterable(polygons)), dtype=np.int64)
    return vertices, triangulated(vertices, corners, lengths)
