"""Dialects of the formats: vertices and faces come out as they stand in the file."""

import struct

import numpy as np
import pytest
import trimesh
from shapes import box

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, load_mesh, signed_volume
from wm3d.mesh.catalog import DATASETS

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
HALVES = [[0, 1, 2], [0, 2, 3]]
CORNERS = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def parsed(folder, ending: str, content: str | bytes) -> Mesh:
    file = folder / f"mesh{ending}"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return load_mesh(file)


OBJ_DIALECTS = {
    "plain": CORNERS + "f 1 2 3\nf 1 3 4\n",
    "quad": CORNERS + "f 1 2 3 4\n",
    "v/vt": CORNERS + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/4 3/3 4/1\n",
    "v/vt/vn": CORNERS + "vt 0 0\nvt 1 1\nvn 0 0 1\nvn 1 0 0\nf 1/1/1 2/2/2 3/1/2 4/2/1\n",
    "v//vn": CORNERS + "vn 0 0 1\nvn 1 0 0\nf 1//1 2//2 3//1\nf 1//2 3//2 4//1\n",
    "relative": CORNERS + "f -4 -3 -2\nf -4 -2 -1\n",
    "relative, interleaved": "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 1 0\nf 1 3 -1\n",
    "groups": CORNERS + "usemtl red\nf 1 2 3\nusemtl blue\ng part\no thing\ns off\nf 1 3 4\n",
    "coloured, wrapped": CORNERS.replace("\n", " 0.5 0.5 0.5\n") + "f 1 2 3 \\\n4\n",
    "comments": "# v 9 9 9\n" + CORNERS.replace("\n", " # corner\n") + "f 1 2 3 # half\nf 1 3 4#half\n",
    "crlf": ("# by hand\n\n  " + CORNERS + "f 1 2 3 4\n").replace("\n", "\r\n"),
    "byte order mark": "\ufeff" + CORNERS + "f 1 2 3 4",
}


@pytest.mark.parametrize("text", OBJ_DIALECTS.values(), ids=OBJ_DIALECTS)
def test_obj_dialects(tmp_path, text):
    mesh = parsed(tmp_path, ".obj", text)
    assert mesh.vertices.tolist() == SQUARE
    assert mesh.faces.tolist() == HALVES


def test_obj_of_the_wheel_is_read_as_trimesh_reads_it(bunny):
    # without textures and materials, the case in which trimesh keeps the order
    other = trimesh.load(DATASETS["bunny"].source.path(), process=False, maintain_order=True)
    assert np.array_equal(bunny.vertices, other.vertices)
    assert np.array_equal(bunny.faces, other.faces)


OFF_DIALECTS = {
    "quad": "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n",
    "counts in the first line": "OFF 4 2 5\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3",
    "glued counts": "OFF4 1 0\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n4  0 1 2 3\r\n",
    "comments": "# a\nOFF\n# 9 9 9\n4 1 0\n\n0 0 0 # b\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n",
    "colours": "COFF\n4 1 0\n0 0 0 9 9 9 9\n1 0 0 9 9 9 9\n1 1 0 9 9 9 9\n0 1 0 9 9 9 9\n4 0 1 2 3 8 8 8\n",
}


@pytest.mark.parametrize("text", OFF_DIALECTS.values(), ids=OFF_DIALECTS)
def test_off_dialects(tmp_path, text):
    mesh = parsed(tmp_path, ".off", text)
    assert mesh.vertices.tolist() == SQUARE
    assert mesh.faces.tolist() == HALVES


def ply_header(encoding: str, vertices: int, faces: int, *face_properties: str) -> bytes:
    lines = ["ply", f"format {encoding} 1.0", f"element vertex {vertices}"]
    lines += [f"property float {field}" for field in ("x", "y", "z", "confidence")]
    lines += [f"element face {faces}", "property list uchar int vertex_indices", *face_properties]
    return "\n".join([*lines, "end_header", ""]).encode()


#: Four corners and one vertex that no face uses, each with a confidence.
SCANNED = [(*corner, 0.5) for corner in [*SQUARE, [7, 7, 7]]]


def test_ascii_ply_with_faces_of_mixed_size(tmp_path):
    body = "".join(f"{x} {y} {z} {c}\n" for x, y, z, c in SCANNED) + "3 0 1 2\n4 0 1 2 3\n3 0 2 3\n"
    mesh = parsed(tmp_path, ".ply", ply_header("ascii", 5, 3) + body.encode())
    assert mesh.vertices.tolist() == [*SQUARE, [7, 7, 7]]
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3], [0, 2, 3]]
    for rows, end in ((4, len(body)), (3, -3)):  # a row is missing, or the end of the last
        with pytest.raises(Wm3dError, match=r"it ends before its [34] rows of element face do"):
            parsed(tmp_path, ".ply", ply_header("ascii", 5, rows) + body[:end].encode())


def test_comments_of_a_ply_header_announce_nothing(tmp_path):
    whole = ply_header("ascii", 4, 2).replace(b"1.0\n", b"1.0\ncomment element vertex 99\n")
    body = "".join(f"{x} {y} {z} {c}\n" for x, y, z, c in SCANNED[:4])
    assert len(parsed(tmp_path, ".ply", whole + f"{body}3 0 1 2\n3 0 2 3\n".encode()).vertices) == 4
    with pytest.raises(Wm3dError, match="is damaged, cut short"):
        parsed(tmp_path, ".ply", whole.replace(b"vertex 4", b"vertex 7") + f"{body}3 0 1 2\n".encode())


@pytest.mark.parametrize(("encoding", "order"), [("binary_little_endian", "<"), ("binary_big_endian", ">")])
def test_binary_ply_of_either_byte_order(tmp_path, encoding, order):
    body = b"".join(struct.pack(order + "4f", *row) for row in SCANNED)
    body += b"".join(struct.pack(order + "B3i", 3, *face) for face in [[2, 1, 0], *HALVES])
    mesh = parsed(tmp_path, ".ply", ply_header(encoding, 5, 3) + body)
    assert mesh.vertices.tolist() == [*SQUARE, [7, 7, 7]]
    assert mesh.faces.tolist() == [[2, 1, 0], *HALVES]


@pytest.mark.parametrize("sizes", [(3, 4, 5), (4, 3, 5)])  # the second is as long as three quads
@pytest.mark.parametrize(("encoding", "order"), [("binary_little_endian", "<"), ("binary_big_endian", ">")])
def test_binary_ply_with_faces_of_mixed_size_becomes_fans_in_its_order(tmp_path, encoding, order, sizes):
    # as Blender writes it, with more properties before and behind the corners
    behind = "property float weight\nelement edge 1\nproperty int vertex1\nproperty int vertex2"
    header = ply_header(encoding, 5, len(sizes), behind)
    body = b"".join(struct.pack(order + "4f", *row) for row in SCANNED)
    body += b"".join(struct.pack(f"{order}B{n}if", n, *range(n), 0.5) for n in sizes)
    mesh = parsed(tmp_path, ".ply", header + body + struct.pack(order + "2i", 0, 1))
    assert mesh.vertices.tolist() == [*SQUARE, [7, 7, 7]]
    assert mesh.faces.tolist() == [[0, k, k + 1] for n in sizes for k in range(1, n - 1)]
    with pytest.raises(Wm3dError, match="is damaged, cut short"):
        parsed(tmp_path, ".ply", header + body)


@pytest.mark.parametrize("lists", [["9 0 1 3 2 -1 2 3 4 4"], ["4 0 1 3 2", "2 0 1", "4 2 3 4 4"]])
def test_ply_triangle_strips_run_by_turns_and_end_at_minus_one(tmp_path, lists):
    header = ply_header("ascii", 5, len(lists)).replace(b"element face", b"element tristrips")
    body = "".join(f"{x} {y} {z} {c}\n" for x, y, z, c in SCANNED) + "\n".join(lists) + "\n"
    mesh = parsed(tmp_path, ".ply", header.replace(b"uchar int", b"int int") + body.encode())
    assert mesh.vertices.tolist() == [*SQUARE, [7, 7, 7]]
    assert mesh.faces.tolist() == [[0, 1, 3], [3, 1, 2], [2, 3, 4]]  # and a corner twice is no triangle
    with pytest.raises(Wm3dError, match="a strip has the corner -2"):
        parsed(
            tmp_path, ".ply", header.replace(b"uchar int", b"int int") + body.replace("4 4", "-2 4").encode()
        )


def test_ply_texture_coordinates_split_no_vertex(tmp_path):
    header = ply_header("ascii", 4, 2, "property list uchar float texcoord")
    body = "".join(f"{x} {y} {z} {c}\n" for x, y, z, c in SCANNED[:4])
    body += "3 0 1 2 6 0 0 1 0 1 1\n3 0 2 3 6 .5 .5 0 0 1 0\n"
    mesh = parsed(tmp_path, ".ply", header + body.encode())
    assert mesh.vertices.tolist() == SQUARE
    assert mesh.faces.tolist() == HALVES


def test_ascii_stl_with_two_solids(tmp_path):
    facet = "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n"
    corners = "vertex 0 0 {z}\nvertex 1 0 {z}\nvertex 0 1 {z}\n"
    text = "".join(f"solid s{z}\n{facet.format(corners.format(z=z))}endsolid s{z}\n" for z in (1, 2))
    mesh = parsed(tmp_path, ".stl", text)
    assert mesh.vertices[:, 2].tolist() == [1, 1, 1, 2, 2, 2]
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_glb_nodes_are_moved_and_appended_and_a_mirrored_one_stays_outward(tmp_path):
    part = trimesh.Trimesh(box().vertices, box().faces, process=False)
    scene = trimesh.Scene()
    scene.add_geometry(part, transform=np.diag([1.0, 3, 1, 1]))
    scene.add_geometry(part, transform=np.diag([-2.0, 1, 1, 1]))
    mesh = parsed(tmp_path, ".glb", scene.export(file_type="glb"))
    parts = sorted([mesh.vertices[:8].tolist(), mesh.vertices[8:].tolist()])
    assert parts == sorted([(box().vertices * scale).tolist() for scale in ([1, 3, 1], [-2, 1, 1])])
    assert signed_volume(mesh) == 3 + 2
