"""Wang, Lavoué, Denis, Baskurt, "Robust and blind mesh watermarking based on volume moments".

Computers & Graphics 35(1), 2011.
"""

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from wm3d.arrays import FloatArray, IntArray, SignArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.schemes.base import Scheme
from wm3d.schemes.patches import Patches, deformed, volume_frame
from wm3d.stats import RademacherSum

MOST_CHANGE = 0.5
"""Of its volume by which a patch may grow or shrink."""

Rows = Annotated[int, Field(ge=1, le=256)]
Sectors = Annotated[int, Field(ge=3, le=256)]


class Wang2011(Scheme):
    """One bit in the quantized volume behind each of N patches; blind.

    The solid is posed by its volume moments and its surface cut into patches by steps of height and angle.
    The volume behind a patch goes towards the nearest multiple of Δ for bit +1, and the nearest odd multiple
    of Δ/2 for bit −1 (scalar Costa scheme; its dither by the key is left out, since the signs are the key).
    The patch is deformed smoothly, with no effect at its borders, and the global moments are kept, so that
    the detector finds the same frame. The paper moves the patches step by step and then compensates; here
    every patch has two more masks, and all that is wanted is met at once by the least sum of squares.

    Attributes
    ----------
    bits : int
        N, the number of bits; carried by the N patches of greatest volume.
    grid : (rows, sectors)
        Steps along the first axis and around it.
    step : float
        Δ, in units of the mean volume of a patch.
    costa : float
        Share of the way to the quantized volume that is gone.
    patches : tuple of int
        The patches that carry bits, set by embedding. A detector without them takes the N greatest.
    """

    name: Literal["wang2011"] = "wang2011"
    strength: ClassVar[str] = "step"
    message: ClassVar[bool] = True
    legend: ClassVar[tuple[str, ...]] = ("bits",)

    bits: Annotated[int, Field(ge=1, le=4096)] = 64
    grid: tuple[Rows, Sectors] = (11, 8)
    step: Annotated[float, Field(gt=0)] = 0.1
    costa: Annotated[float, Field(gt=0, le=1)] = 0.9
    patches: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(repr=False)] = ()

    @model_validator(mode="after")
    def _patches_of_the_grid(self) -> Self:
        count = self.grid[0] * self.grid[1]
        if self.bits > count:
            raise ValueError(f"{self.bits} bits do not fit a grid of {count} patches")
        if self.patches and (len(self.patches) != self.bits or max(self.patches) >= count):
            raise ValueError(f"patches must name {self.bits} of the {count} patches of the grid")
        return self

    @property
    def capacity(self) -> int:
        """One sign for each carrying patch."""
        return self.bits

    def label(self) -> str:
        """Return the legend text, without the numbers of the patches."""
        named: str = super(Wang2011, self.model_copy(update={"patches": ()})).label()
        return named

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        """Quantize the volumes and let the patches follow; see `Scheme.embed`."""
        frame = volume_frame(mesh)
        volumes = self._cells.volumes(mesh, frame)
        chosen = self._greatest(volumes, mesh)
        change = self.costa * (self._quantized(volumes[chosen], self.signs(seed)) - volumes[chosen])
        most = MOST_CHANGE * volumes[chosen]
        target = volumes[chosen] + np.clip(change, -most, most)
        marked = deformed(mesh, frame, self._cells, chosen, target)
        return marked, self.model_copy(update={"patches": tuple(map(int, chosen))})

    def evidence(self, mesh: Mesh) -> RademacherSum:
        """Read b_n = cos(2π V_n / Δ), ±1 on the lattices of the bits ±1; see `Scheme.evidence`."""
        frame = volume_frame(mesh)
        volumes = self._cells.volumes(mesh, frame)
        chosen = np.array(self.patches) if self.patches else self._greatest(volumes, mesh)
        return RademacherSum(0.0, np.cos(2 * np.pi * volumes[chosen] / self.step))

    @property
    def _cells(self) -> Patches:
        return Patches(*self.grid)

    def _quantized(self, volumes: FloatArray, signs: SignArray) -> FloatArray:
        offset = np.where(signs > 0, 0.0, 0.5)
        quantized: FloatArray = (np.rint(volumes / self.step - offset) + offset) * self.step
        return quantized

    def _greatest(self, volumes: FloatArray, mesh: Mesh) -> IntArray:
        """Return the numbers of the patches of greatest volume, in raster order."""
        filled = int((volumes > 0).sum())
        if filled < self.bits:
            raise Wm3dError(
                f"{mesh.name}: has a surface in {filled} of the {self._cells.count} patches, too few for "
                f"{self.bits} bits; use fewer bits or a finer grid."
            )
        return np.sort(np.argsort(-volumes, kind="stable")[: self.bits])
