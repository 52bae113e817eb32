"""What files and viewers do to a mesh: round trips through formats, welding, Draco compression."""

from importlib.util import find_spec
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field
from scipy import sparse
from scipy.spatial import KDTree

from wm3d.arrays import IntArray
from wm3d.attacks.base import Attack
from wm3d.attacks.surface import without_collapsed, without_unused
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, decode_mesh, encode_mesh, places


class RoundTrip(Attack):
    """Written to a file format and read again; STL and GLB round to float32.

    Attributes
    ----------
    format : str
        STL gives three vertices a face.
    weld : bool
        Whether vertices in the same place are merged afterwards, as most programs do that read STL.
    """

    name: Literal["roundtrip"] = "roundtrip"
    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("format",)
    neutral: ClassVar[dict[str, float]] = {}

    format: Literal["ply", "obj", "stl", "off", "glb"] = "ply"
    weld: bool = False

    @property
    def engines(self) -> tuple[str, ...]:
        """The package behind the readers and writers."""
        return ("trimesh",)

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the mesh that was read; see `Attack`."""
        path = f"{mesh.name}.{self.format}"
        back = decode_mesh(encode_mesh(mesh, path), path, mesh.name)
        return welded(back, 0.0) if self.weld else back


class Weld(Attack):
    """Near vertices merged into the first of them; faces that collapse are dropped.

    Attributes
    ----------
    percent : float
        Vertices at most so far apart are merged, and so are chains of them; in percent of the diagonal of the
        bounding box. With 0, only vertices in the same place.
    """

    name: Literal["weld"] = "weld"
    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("percent",)
    neutral: ClassVar[dict[str, float]] = {}

    percent: Annotated[float, Field(ge=0, le=1)] = 0.0

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the welded mesh; see `Attack`."""
        return welded(mesh, self.percent / 100 * mesh.diagonal)


class Draco(Attack):
    """Compressed and decompressed by Google's Draco: coordinates on a cubic grid, another order of vertices.

    Needs the package DracoPy (``pip install DracoPy``).

    Attributes
    ----------
    bits : int
        Bits of a coordinate; 14 by default in glTF tools, 11 in Draco's own encoder.
    level : int
        Compression level, 0 to 10; from 1 the vertices are reordered along the connectivity.
    """

    name: Literal["draco"] = "draco"
    random: ClassVar[bool] = False
    legend: ClassVar[tuple[str, ...]] = ("bits",)

    bits: Annotated[int, Field(ge=1, le=30)] = 14
    level: Annotated[int, Field(ge=0, le=10)] = 7

    @property
    def engines(self) -> tuple[str, ...]:
        """DracoPy where it is installed."""
        return ("DracoPy",) if find_spec("DracoPy") else ()

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (nothing is random)
        """Return the decompressed mesh; see `Attack`."""
        try:
            import DracoPy
        except ImportError as error:
            raise Wm3dError(
                f"{mesh.name}: {self.label()} needs DracoPy; pip install DracoPy, or use quantize with "
                "grid = cubic, which moves the vertices alike."
            ) from error
        try:
            content = DracoPy.encode(
                mesh.vertices.astype(np.float32),
                mesh.faces.astype(np.uint32),
                quantization_bits=self.bits,
                compression_level=self.level,
            )
        except DracoPy.EncodingFailedException as error:
            raise Wm3dError(
                f"{mesh.name}: {self.label()} cannot encode it; see that a face has an area, and coordinates "
                "a size, that float32 can hold."
            ) from error
        back = DracoPy.decode(content)
        if len(back.faces) == 0:
            raise Wm3dError(f"{mesh.name}: {self.label()} leaves no face; use more bits.")
        vertices, faces = np.asarray(back.points, np.float64), np.asarray(back.faces, np.int64)
        return Mesh(*without_unused(vertices, faces), mesh.name)


def welded(mesh: Mesh, distance: float) -> Mesh:
    """Return the mesh with all vertices merged that chains of steps of at most `distance` connect.

    Raises
    ------
    Wm3dError
        If every face collapses.
    """
    representative = _coincident(mesh) if distance == 0 else _near(mesh, distance)
    faces = without_collapsed(representative[mesh.faces])
    if len(faces) == 0:
        raise Wm3dError(f"{mesh.name}: welding at {distance:g} leaves no face; weld less.")
    if np.array_equal(faces, mesh.faces):
        return mesh
    return Mesh(*without_unused(mesh.vertices, faces), mesh.name)


def _coincident(mesh: Mesh) -> IntArray:
    """For every vertex the first one in the same place (n,)."""
    first, place = places(mesh.vertices)
    return first[place]


def _near(mesh: Mesh, distance: float) -> IntArray:
    """For every vertex the first one that steps of at most `distance` lead to (n,)."""
    n = len(mesh.vertices)
    i, j = KDTree(mesh.vertices).query_pairs(distance, output_type="ndarray").T
    links = sparse.coo_array((np.ones(len(i), bool), (i, j)), shape=(n, n))
    _, group = sparse.csgraph.connected_components(links, directed=False)
    _, first = np.unique(group, return_index=True)
    return first[group]
