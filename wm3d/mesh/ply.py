"""PLY as bytes: every vertex and face in its place, polygons of any size, coordinates as float64.

trimesh would round on writing. On reading it takes all faces of a binary file for as long as the first, and
an ASCII face that was cut short for a smaller one.
"""

import re
import struct
from typing import NamedTuple

import numpy as np

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh.mesh import Mesh
from wm3d.mesh.polygons import triangulated

_NUMBERS = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_TEXT = "<f8"  # ASCII files are read as binary ones in which every number has this type
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")
_SURFACES = {"face": "faces", "tristrips": "strips"}


class Property(NamedTuple):
    """A number, or a list of numbers behind its length.

    Attributes
    ----------
    name : str
    number : dtype
        What the header says that it is; the numbers of an ASCII file are rounded to it.
    item : dtype
        How it lies in the content.
    length : dtype, optional
        How the length of a list lies there.
    """

    name: str
    number: np.dtype
    item: np.dtype
    length: np.dtype | None = None


class Element(NamedTuple):
    """What a header announces of vertices, of faces, or of anything else."""

    name: str
    rows: int
    properties: list[Property]


class Column(NamedTuple):
    """Where in the content the values of a property begin, and how many there are: (rows,) each."""

    starts: IntArray
    lengths: IntArray


def read_ply(content: bytes) -> tuple[FloatArray, IntArray]:
    """Read PLY, ASCII or binary: vertices (n, 3) and triangles (m, 3), of polygons and of triangle strips.

    Raises
    ------
    ValueError
        If the content does not fit its header, or a face has fewer than three corners.
    """
    elements, content = _header_and_body(content)
    vertices, corners, lengths = np.empty((0, 3)), np.empty(0, np.int64), np.empty(0, np.int64)
    strips = np.empty((0, 3), np.int64)
    at = 0
    for element in elements:
        columns, at = _columns(content, at, element)
        if element.name == "vertex" and element.rows:
            vertices = _coordinates(content, element, columns)
        if element.name in _SURFACES and element.rows:
            listed = next((p for p in element.properties if p.name in _CORNERS), None)
            if listed is None or listed.length is None:
                raise ValueError(f"its {_SURFACES[element.name]} list no vertex_indices")
            found = _corners(content, columns[listed.name], listed.item)
            if element.name == "face":
                corners, lengths = found
                if lengths.min() < 3:
                    raise ValueError(f"a face of {lengths.min()} corners")
            else:
                strips = _of_strips(*found)
    if at != len(content):
        raise ValueError("it is longer than its header says")
    return vertices, np.vstack([triangulated(vertices, corners, lengths), strips])


def write_ply(mesh: Mesh) -> bytes:
    """Return binary little-endian PLY with float64 coordinates."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(mesh.vertices)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(mesh.faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(mesh.faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.faces
    return header.encode() + mesh.vertices.astype("<f8").tobytes() + faces.tobytes()


def _header_and_body(content: bytes) -> tuple[list[Element], bytes]:
    ends = re.search(rb"(?m)^end_header[^\n]*\n", content)
    if not content.startswith(b"ply") or ends is None:
        raise ValueError("no PLY header")
    elements: list[Element] = []
    order = None
    for line in content[: ends.start()].decode("latin-1").splitlines():
        match line.split():
            case ["format", encoding, *_]:
                order = _ORDERS.get(encoding)
            case ["element", name, rows]:
                elements.append(Element(name, int(rows), []))
            case ["property", "list", length, number, name]:
                types = (_type(number, "<"), _type(number, order), _type(length, order))
                elements[-1].properties.append(Property(name, *types))
            case ["property", number, name]:
                elements[-1].properties.append(Property(name, _type(number, "<"), _type(number, order)))
    body = content[ends.end() :]
    return elements, body if order else np.array(body.split(), dtype=_TEXT).tobytes()


def _type(name: str, order: str | None) -> np.dtype:
    if name not in _NUMBERS:
        raise ValueError(f"{name!r} is no type of PLY")
    return np.dtype(order + _NUMBERS[name] if order else _TEXT)


def _columns(content: bytes, at: int, element: Element) -> tuple[dict[str, Column], int]:
    """Return where every property of an element lies in the content, and where the element ends."""
    if not element.rows:
        return {}, at
    first, end = _walked(content, at, element, 1)
    width = end - at
    if at + element.rows * width <= len(content):  # as it is if all rows are as long as the first
        ahead = width * np.arange(element.rows)
        columns = {
            name: Column(found.starts + ahead, found.lengths.repeat(element.rows))
            for name, found in first.items()
        }
        if all(_as_long(content, columns[p.name], p) for p in element.properties):
            return columns, at + element.rows * width
    return _walked(content, at, element, element.rows)


def _as_long(content: bytes, column: Column, found: Property) -> bool:
    """Tell whether the lists of a column, if lists they are, have the lengths that are taken for granted."""
    if found.length is None:
        return True
    lengths = _values(content, column.starts - found.length.itemsize, 1, found.length)
    return bool((lengths[:, 0] == column.lengths).all())


def _walked(content: bytes, at: int, element: Element, rows: int) -> tuple[dict[str, Column], int]:
    """Do the same for some rows one by one, whatever the length of each."""
    starts: dict[str, list[int]] = {p.name: [] for p in element.properties}
    lengths: dict[str, list[int]] = {p.name: [] for p in element.properties}
    steps = [(starts[p.name], lengths[p.name], _reader(p), p.item.itemsize) for p in element.properties]
    least = sum((p.item if p.length is None else p.length).itemsize for p in element.properties)
    short = ValueError(f"it ends before its {element.rows} rows of element {element.name} do")
    if at + element.rows * least > len(content):
        raise short
    for _ in range(rows):
        for begins, counts, reader, size in steps:
            length = 1
            if reader is not None:
                if at + reader.size > len(content):
                    raise short
                length = int(reader.unpack_from(content, at)[0])
                at += reader.size
            begins.append(at)
            counts.append(length)
            at += length * size
    if at > len(content):
        raise short
    return {name: Column(np.array(starts[name]), np.array(lengths[name])) for name in starts}, at


def _reader(found: Property) -> struct.Struct | None:
    """Read the length of a list."""
    if found.length is None:
        return None
    return struct.Struct(found.length.str[0].replace("|", "<") + found.length.char)


def _values(content: bytes, starts: IntArray, length: int, item: np.dtype) -> np.ndarray:
    """Return the values (rows, length) that lie one behind the other from each start."""
    step = int(starts[1] - starts[0]) if len(starts) > 1 else 0
    if (np.diff(starts) == step).all():
        shape, strides = (len(starts), length), (step, item.itemsize)
        return np.ndarray(shape, item, content, int(starts[0]), strides)
    found = np.frombuffer(content, np.uint8)[starts[:, None] + np.arange(length * item.itemsize)]
    values: np.ndarray = found.view(item)
    return values


def _coordinates(content: bytes, element: Element, columns: dict[str, Column]) -> FloatArray:
    known = {p.name: p for p in element.properties}
    axes = [
        _values(content, columns[axis].starts, 1, known[axis].item)[:, 0].astype(known[axis].number)
        for axis in "xyz"
    ]
    return np.stack(axes, axis=1).astype(np.float64)


def _of_strips(corners: IntArray, lengths: IntArray) -> IntArray:
    """Return the triangles (m, 3) of strips, each as one list, or many in a list with −1 between them.

    Every second triangle of a strip runs the other way round; those of two equal corners only lead on.
    """
    if (corners < -1).any():
        raise ValueError(f"a strip has the corner {corners.min()}")
    ends = np.insert(corners, np.cumsum(lengths), -1)
    since = np.arange(len(ends)) - np.maximum.accumulate(np.where(ends < 0, np.arange(len(ends)) + 1, 0))
    triples = np.column_stack([ends[:-2], ends[1:-1], ends[2:]])
    triples = np.where((since[:-2] % 2 == 1)[:, None], triples[:, [1, 0, 2]], triples)
    a, b, c = triples.T
    triangles: IntArray = triples[(triples >= 0).all(axis=1) & (a != b) & (b != c) & (c != a)]
    return triangles


def _corners(content: bytes, polygons: Column, item: np.dtype) -> tuple[IntArray, IntArray]:
    """Return the corners of one polygon after the other, and how many each has."""
    lengths = np.asarray(polygons.lengths, np.int64)
    first = np.cumsum(lengths) - lengths
    corners = np.empty(int(lengths.sum()), np.int64)
    for length in np.unique(lengths):
        alike = lengths == length
        places = first[alike][:, None] + np.arange(length)
        corners[places] = _values(content, polygons.starts[alike], int(length), item)
    return corners, lengths
