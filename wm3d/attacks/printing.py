"""Printing and scanning, simulated: the staircase of the layers, blur, noise, and a new pose."""

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field
from scipy.spatial.transform import Rotation

from wm3d.attacks.base import Attack
from wm3d.attacks.deformation import Axis
from wm3d.attacks.smoothing import LIRIS_WEIGHT, smoothed
from wm3d.mesh import Mesh, sewn, vertex_normals


class PrintScan(Attack):
    """A print in layers, scanned again: our simulation, to first order in the layer height.

    1. Each layer has the cross-section of the model at its middle height w_k, pulled upright. So a vertex at
       height w moves by (w − w_k) n_w along its normal n, at most half a layer.
    2. Melt and scanner blur: Laplacian smoothing.
    3. Scanner noise: Gaussian, on every coordinate.
    4. The scan lies askew: a rotation about a random axis through the mean of the vertices.

    The connectivity stays; a chain with marching-cubes or screened-poisson gives that of a scan.

    Attributes
    ----------
    layer_percent : float
        Layer height in percent of the diagonal of the bounding box: 0.2 mm of 10 cm.
    axis : "x", "y" or "z"
        Direction of the layers.
    smoothing : int
        Laplacian steps with λ = 0.1.
    noise_percent : float
        Standard deviation of each coordinate in percent of the diagonal.
    tilt_degrees : float
        The angle of the rotation is uniform between 0 and this.
    """

    name: Literal["print-scan"] = "print-scan"
    turns: ClassVar[bool] = True
    legend: ClassVar[tuple[str, ...]] = ("layer_percent", "noise_percent")
    neutral: ClassVar[dict[str, float]] = {
        "layer_percent": 0,
        "smoothing": 0,
        "noise_percent": 0,
        "tilt_degrees": 0,
    }

    layer_percent: Annotated[float, Field(ge=0)] = 0.2
    axis: Axis = "z"
    smoothing: Annotated[int, Field(ge=0)] = 5
    noise_percent: Annotated[float, Field(ge=0)] = 0.05
    tilt_degrees: Annotated[float, Field(ge=0, le=180)] = 5.0

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the mesh that was scanned; see `Attack`."""
        surface, place = sewn(mesh)
        noise = rng.standard_normal(surface.vertices.shape)
        direction, angle = rng.standard_normal(3), rng.uniform(0, self.tilt_degrees)
        scan = smoothed(self._printed(surface), (LIRIS_WEIGHT,) * self.smoothing)
        vertices = scan.vertices + noise * (self.noise_percent / 100 * mesh.diagonal)
        if self.tilt_degrees > 0:
            turn = Rotation.from_rotvec(angle * direction / np.linalg.norm(direction), degrees=True)
            center = vertices.mean(axis=0)
            # not BLAS: the same bits on any thread count
            vertices = center + np.einsum("ij,nj->ni", turn.as_matrix(), vertices - center)
        return mesh.with_vertices(vertices[place])

    def _printed(self, mesh: Mesh) -> Mesh:
        """Return the mesh with the staircase of the layers, which are counted from the lowest vertex."""
        layer = self.layer_percent / 100 * mesh.diagonal
        if layer == 0:
            return mesh
        normals, k = vertex_normals(mesh), "xyz".index(self.axis)
        height = mesh.vertices[:, k] - mesh.vertices[:, k].min()
        above_middle = height - layer * (np.floor(height / layer) + 0.5)
        return mesh.with_vertices(mesh.vertices + (above_middle * normals[:, k])[:, None] * normals)
