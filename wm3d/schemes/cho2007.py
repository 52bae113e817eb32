"""Cho, Prost, Jung, "An Oblivious Watermarking for 3-D Polygonal Meshes Using Distribution of Vertex Norms".

IEEE Transactions on Signal Processing 55(1), 2007.
"""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, vertex_moments
from wm3d.schemes.radial import MEAN, VARIANCE, Moment, RadialScheme, Spread


class _VertexNorms(RadialScheme):
    """Vertex norms ρ_i = ‖v_i − g‖ about the vertex mean g, in N equal bins from least to greatest."""

    def spread(self, mesh: Mesh) -> Spread:
        """Return the vertex norms; see `RadialScheme.spread`."""
        center = vertex_moments(mesh).mean
        radii = np.linalg.norm(mesh.vertices - center, axis=1)
        low, high = radii.min(), radii.max()
        if high - low <= 1e-9 * high:
            raise Wm3dError(
                f"{mesh.name}: all vertices are equally far from their mean, so their distances cannot "
                "carry a watermark; use a scheme that does without them."
            )
        return Spread(center, radii, np.ones(len(radii)), low, high, self.bits)


class Cho2007Mean(_VertexNorms):
    """Cho, Prost and Jung's blind scheme in the mean of the vertex norms of each bin.

    In bin n, the norms become t in [0, 1]. Their mean is brought to at least ½ + α for bit +1 and at most
    ½ − α for bit −1 by t → t^k, with k from bisection (the paper steps k until the target is passed). The bit
    is read by comparing the mean with ½.

    Attributes
    ----------
    alpha : float
        α; a bin whose mean is there already is left alone, so the distortion has a floor as α falls to 0.
    """

    name: Literal["cho2007-mean"] = "cho2007-mean"
    moment: ClassVar[Moment] = MEAN

    alpha: Annotated[float, Field(gt=0, lt=0.5)] = 0.05


class Cho2007Variance(_VertexNorms):
    """Cho, Prost and Jung's blind scheme in the variance of the vertex norms of each bin.

    In bin n, the norms become y in [−1, 1]. Their variance, about 0 as for a uniform law, is brought to at
    least ⅓ + α for bit +1 and at most ⅓ − α for bit −1 by y → sign(y)|y|^k. The bit is read by comparing the
    variance with ⅓.

    Attributes
    ----------
    alpha : float
        α; a bin whose variance is there already is left alone.
    """

    name: Literal["cho2007-variance"] = "cho2007-variance"
    moment: ClassVar[Moment] = VARIANCE

    alpha: Annotated[float, Field(gt=0, lt=1 / 3)] = 0.08
