"""The original as the keys of `RangeDct` find it: its frame, its cylinder, its volume image, its moves."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array

from wm3d.arrays import FloatArray, IntArray
from wm3d.errors import Wm3dError
from wm3d.imagemarks.blocks import BLOCK, block_dct
from wm3d.imagemarks.shaped_dct import ShapedDct
from wm3d.mesh import Mesh, face_areas, orientation, places, vertex_normals, whole_surface
from wm3d.scanner import kernels
from wm3d.scanner.affine import MOST_WAYS, AffineFrame, principal_frame, ways
from wm3d.scanner.scan import MAX_GRID
from wm3d.scanner.volume import VolumeImage, volume_image, volume_jacobian
from wm3d.schemes.movement import pooled

AXIS = 0.25
"""Distance from the axis, over the median, below which moves fade out: cells become thin wedges there."""

FEWEST_VERTICES = 1.5
"""Vertices a cell of the image, below which cells are made larger: what is finer than the mesh is lost."""

BLOCKS = 0.63
"""Blocks laid by default, over the square root of the number of vertices: finer meshes carry finer cells."""

FEWEST_BLOCKS, MOST_BLOCKS = 100, 300
"""Bounds of the default: fewer blocks carry too little, and of more noise of a given size leaves less."""


class Layout(NamedTuple):
    """Grid (N_v, N_u), lower end and height of the cylinder, in the unit of the frame."""

    grid: tuple[int, int]
    hmin: float
    height: float

    @classmethod
    def around(cls, posed: FloatArray, mesh: Mesh, blocks: float) -> "Layout":
        """Lay about so many blocks around a solid, of cells that are square at its mean distance."""
        area, square = face_areas(posed, mesh.faces), (posed[:, 1:] ** 2).sum(axis=1)
        radius = math.sqrt(float(area @ square[mesh.faces].sum(axis=1) / (3 * area.sum())))
        heights = posed[mesh.used, 0]
        hmin, height = float(heights.min()), float(np.ptp(heights))
        most = min(max(round(blocks), 1), MAX_GRID // BLOCK)  # on one side: a rod has all in a column
        up = min(max(round(math.sqrt(blocks * height / (2 * math.pi * radius))), 1), most)
        around = min(max(round(blocks / up), 1), most)
        return cls((BLOCK * around, BLOCK * up), hmin, height)

    def image(self, posed: FloatArray, mesh: Mesh) -> VolumeImage:
        """Return the volume image of a mesh whose vertices lie at ``posed`` in the frame."""
        return volume_image(posed, mesh.faces, self.grid, self.hmin, self.height, orientation(mesh))


class Host(NamedTuple):
    """What does not depend on the key.

    Attributes
    ----------
    whole : Mesh
        `whole_surface` of the original.
    frame : AffineFrame
    ways : int
        In how many ways the solid can be laid on itself.
    layout : Layout
    image : VolumeImage
    mark : ShapedDct
        Of the image.
    posed : (p, 3) ndarray
        The places where vertices lie, in the frame.
    place : (n,) ndarray
        The place of each vertex.
    directions : (p, 3) ndarray
        Outward normals there, in mesh coordinates; of length 1, less near the axis.
    jacobian : (N_u · N_v, p) sparse array
        How the volumes of the image grow with moves along the directions, in mesh units.
    area : (p,) ndarray
        Area of the surface around each place, in squared units of the frame.
    share : (p,) ndarray
        How much a squared move there counts in the mean square move of the vertices that a face uses.
    """

    whole: Mesh
    frame: AffineFrame
    ways: int
    layout: Layout
    image: VolumeImage
    mark: ShapedDct
    posed: FloatArray
    place: IntArray
    directions: FloatArray
    jacobian: csc_array
    area: FloatArray
    share: FloatArray

    def size(self, along: FloatArray) -> float:
        """Return the root mean square move of the vertices that a face uses: (p,) along the directions."""
        return math.sqrt(float((self.share * along**2).sum()))

    def coefficients(self, along: FloatArray) -> FloatArray:
        """Return the AC coefficients of the image once the places have moved: (blocks, 63)."""
        return block_dct(self.image_of(self.whole.vertices + self.moves(along)).volumes)[:, 1:]

    def image_of(self, vertices: FloatArray) -> VolumeImage:
        """Return the volume image of the original with its (n, 3) vertices elsewhere."""
        return self.layout.image(self.frame.posed(self.whole.with_vertices(vertices)), self.whole)

    def moves(self, along: FloatArray) -> FloatArray:
        """Return what every vertex moves by, for moves (p,) along the directions: (n, 3), in mesh units."""
        moves: FloatArray = (along[:, None] * self.directions)[self.place]
        return moves


# the original is marked with one key after the other, or at one strength after the other
@lru_cache(maxsize=1)
def host_of(mesh: Mesh, blocks: int | None) -> Host:
    """Pose a mesh and lay about so many blocks around it; by default as many as its vertices can carry."""
    whole = whole_surface(mesh)  # as it will be read; the vertices are the same
    frame = principal_frame(whole)
    count = _countable_ways(whole, frame)
    posed = frame.posed(mesh)
    first, place = places(posed)
    counted = place[mesh.used]
    vertices = np.bincount(counted, minlength=len(first))  # of the faces, in each place
    layout = Layout.around(posed, whole, laid(blocks, int(np.count_nonzero(vertices))))
    directions = _directions(posed, whole)[first]
    places_posed, faces = posed[first], place[whole.faces]
    turned = kernels.to_frame(directions, np.zeros(3), frame.matrix)
    image = layout.image(posed, whole)
    return Host(
        whole=whole,
        frame=frame,
        ways=count,
        layout=layout,
        image=image,
        mark=ShapedDct.of(image.volumes, image.areas),
        posed=places_posed,
        place=place,
        directions=directions,
        jacobian=volume_jacobian(places_posed, faces, turned, *layout, orientation(whole)),
        area=_area_around(places_posed, faces),
        share=vertices * (directions**2).sum(axis=1) / len(counted),
    )


def laid(blocks: int | None, vertices: int) -> float:
    """Return how many blocks to lay around a mesh of so many vertices if so many are asked for."""
    wanted = blocks or min(max(BLOCKS * math.sqrt(vertices), FEWEST_BLOCKS), MOST_BLOCKS)
    return min(wanted, vertices / (FEWEST_VERTICES * BLOCK**2))


def _countable_ways(mesh: Mesh, frame: AffineFrame) -> int:
    count = ways(mesh, frame)
    if count > MOST_WAYS:
        raise Wm3dError(
            f"{mesh.name}: looks the same, or nearly, from all sides or all around, so it has no unique "
            "axes; try another scheme."
        )
    return count


def _directions(posed: FloatArray, mesh: Mesh) -> FloatArray:
    normals = pooled(posed, vertex_normals(mesh))
    length = np.linalg.norm(normals, axis=1)
    distance = np.hypot(posed[:, 1], posed[:, 2])
    fade = np.minimum(1.0, distance / (AXIS * np.median(distance[mesh.used])))
    directions: FloatArray = normals * (fade / np.where(length > 0, length, 1.0))[:, None]
    return directions


def _area_around(posed: FloatArray, faces: IntArray) -> FloatArray:
    around = np.bincount(faces.ravel(), np.repeat(face_areas(posed, faces) / 3, 3), len(posed))
    return np.asarray(around, dtype=float)
