"""Patches of a surface: the cells of a cylindrical grid, the volumes behind them, and masks over them."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from wm3d.arrays import FloatArray, IntArray
from wm3d.mesh import Mesh
from wm3d.schemes.patches import kernels
from wm3d.schemes.patches.frame import Frame

MASKS = 3
"""Deformations of a patch: one that fills it, and two that shift it along and around."""


@dataclass(frozen=True)
class Patches:
    """Equal steps of the height and of the angle in a frame.

    Attributes
    ----------
    rows, sectors : int
        Steps along the first axis, from end to end, and around it.
    """

    rows: int
    sectors: int

    @property
    def count(self) -> int:
        """Number of patches; patch (i, j) is number i · sectors + j."""
        return self.rows * self.sectors

    def volumes(self, mesh: Mesh, frame: Frame) -> FloatArray:
        """Return the volume behind each patch over the mean of all, (count,)."""
        posed = frame.posed(mesh)
        cells = kernels.patch_volumes(posed, mesh.faces, frame.low, frame.high, self.rows, self.sectors)
        volumes: FloatArray = cells.ravel() * (self.count / frame.volume)
        return volumes

    def place(self, posed: FloatArray, frame: Frame) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return the patch of posed vertices and where they lie in it, u along and v around, in ±½."""
        along = (posed[:, 0] - frame.low) / (frame.high - frame.low) * self.rows
        around = np.arctan2(posed[:, 2], posed[:, 1]) % (2 * np.pi) / (2 * np.pi) * self.sectors
        row = np.clip(np.floor(along), 0, self.rows - 1)
        sector = np.clip(np.floor(around), 0, self.sectors - 1)
        index = (row * self.sectors + sector).astype(np.int64)
        return index, np.clip(along - row, 0, 1) - 0.5, np.clip(around - sector, 0, 1) - 0.5

    def masks(self, posed: FloatArray, frame: Frame) -> sparse.csr_array:
        """Return the masks at the vertices, (n, 3 · count): smooth, and 0 with their slope at the borders.

        W = cos²πu cos²πv, and 2u W and 2v W, which move volume within the patch.
        """
        index, u, v = self.place(posed, frame)
        window = np.cos(np.pi * u) ** 2 * np.cos(np.pi * v) ** 2
        values = np.column_stack([window, 2 * u * window, 2 * v * window])
        columns = MASKS * index[:, None] + np.arange(MASKS)
        rows = np.repeat(np.arange(len(posed)), MASKS)
        shape = (len(posed), MASKS * self.count)
        return sparse.coo_array((values.ravel(), (rows, columns.ravel())), shape=shape).tocsr()
