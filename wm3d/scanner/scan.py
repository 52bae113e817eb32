"""The virtual scanner: mesh in, range image out (section II-B of the paper)."""

from dataclasses import dataclass

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, orientation
from wm3d.scanner import kernels
from wm3d.scanner.cylinder import Cylinder
from wm3d.scanner.pose import VertexPca

MAX_GRID = 1 << 15
DEFAULT_GRID = (84, 84)
"""(N_v, N_u) of the paper's rabbit."""


@dataclass(frozen=True, eq=False)
class RangeImage:
    """What the virtual scanner sees.

    Attributes
    ----------
    ranges : (N_u, N_v) ndarray
        l(u, v), distance from the cylinder's wall to the first face, in mesh units; NaN where a ray meets
        nothing.
    cylinder : Cylinder
        Where the rays started.
    """

    ranges: FloatArray
    cylinder: Cylinder

    @property
    def grid(self) -> tuple[int, int]:
        """Columns around and rows along the axis, (N_v, N_u), in the paper's order."""
        rows, columns = self.ranges.shape
        return columns, rows


def scan(mesh: Mesh, grid: tuple[int, int] = DEFAULT_GRID, cylinder: Cylinder | None = None) -> RangeImage:
    """Scan a mesh with a virtual cylindrical scanner.

    The ray of row u and column v starts on the wall at m + (hmin + (u + ½) h / N_u) s1 + r e_v(v), runs
    through the axis to the opposite wall and stops at the first face that it meets from the front (eqs. 4–7).

    Parameters
    ----------
    mesh : Mesh
        Wound either way; an inward-wound mesh (see `wm3d.mesh.orientation`) is read as if turned outward.
    grid : tuple of int
        (N_v, N_u): columns around, rows along the axis.
    cylinder : Cylinder, optional
        Where to scan from; by default the paper's pose of the mesh itself, `VertexPca`.

    Returns
    -------
    RangeImage

    Raises
    ------
    Wm3dError
        If the grid is empty or too large, or the mesh has no unique axes.
    """
    check_grid(grid)
    if cylinder is None:
        cylinder = VertexPca()(mesh)
    return scan_posed(cylinder.posed(mesh), mesh, grid, cylinder)


def scan_posed(posed: FloatArray, mesh: Mesh, grid: tuple[int, int], cylinder: Cylinder) -> RangeImage:
    """Scan a mesh whose vertices `posed`, (n, 3), are already in the frame of the cylinder."""
    columns, rows = grid
    ranges = kernels.cast(
        posed, mesh.faces, cylinder.planes(rows), columns, cylinder.radius, orientation(mesh)
    )
    return RangeImage(ranges, cylinder)


def check_grid(grid: tuple[int, int]) -> None:
    """Raise Wm3dError unless 1 ≤ N_v, N_u ≤ 32768."""
    if not all(1 <= size <= MAX_GRID for size in grid):
        raise Wm3dError(f"a grid of {grid[0]}x{grid[1]} is not between 1x1 and {MAX_GRID}x{MAX_GRID}.")
