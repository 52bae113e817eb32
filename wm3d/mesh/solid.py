"""Moments up to order four of the solid that a surface bounds, as symmetric tensors."""

import itertools
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from wm3d.arrays import FloatArray
from wm3d.errors import NoSolidError
from wm3d.mesh import kernels
from wm3d.mesh.mesh import Mesh
from wm3d.mesh.moments import check_volume, volume_moments
from wm3d.mesh.tensors import mapped, mapped_entries, multiplicity, rising, symmetrized

ORDERS = (2, 3, 4)
ENTRIES = 31
"""Different entries of the symmetric tensors of these orders: 6 + 10 + 15."""

LEAST_MOMENT = 1e-9
"""Least second moment of a solid, relative to the largest."""


class SolidMoments(NamedTuple):
    """Moments of a solid of unit density about its centroid, divided by its volume.

    Attributes
    ----------
    centroid : (3,) ndarray
        In the unit of the mesh.
    second, third, fourth : (3, 3), (3, 3, 3), (3, 3, 3, 3) ndarray
        Means of x xᵀ, x ⊗ x ⊗ x and x ⊗ x ⊗ x ⊗ x over the solid, x relative to the centroid.
    """

    centroid: FloatArray
    second: FloatArray
    third: FloatArray
    fourth: FloatArray

    def mapped(self, matrix: FloatArray) -> "SolidMoments":
        """Return the moments of the solid under x ↦ matrix x, with the centroid as origin: it maps to 0."""
        tensors = (self.second, self.third, self.fourth)
        return SolidMoments(np.zeros(3), *(mapped(tensor, matrix) for tensor in tensors))

    def entries(self) -> FloatArray:
        """Return the 6 + 10 + 15 different entries of the tensors: (31,)."""
        tensors = (self.second, self.third, self.fourth)
        return np.concatenate([t[rising(k)] for k, t in zip(ORDERS, tensors, strict=True)])

    @classmethod
    def of_entries(cls, entries: ArrayLike) -> "SolidMoments":
        """Return the moments with these `entries`, and the centroid as origin."""
        parts = np.split(
            np.asarray(entries, dtype=float), np.cumsum([len(rising(k)[0]) for k in ORDERS])[:-1]
        )
        tensors = [np.empty((3,) * k) for k in ORDERS]
        for order, tensor, values in zip(ORDERS, tensors, parts, strict=True):
            for axes in itertools.permutations(range(order)):
                tensor[tuple(rising(order)[axis] for axis in axes)] = values
        return cls(np.zeros(3), *tensors)

    def components(self) -> FloatArray:
        """Return `entries`, weighted so that their norm is that of the tensors: (31,)."""
        weights = np.concatenate([np.sqrt(multiplicity(order)) for order in ORDERS])
        components: FloatArray = weights * self.entries()
        return components

    def components_of(self, matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ``mapped(matrix).components()`` and its derivatives by the nine entries of the matrix.

        Returns
        -------
        components : (31,) ndarray
        derivatives : (31, 9) ndarray
        """
        values, derivatives = [], []
        for order, tensor in zip(ORDERS, (self.second, self.third, self.fourth), strict=True):
            entries, slopes = mapped_entries(tensor, matrix)
            weight = np.sqrt(multiplicity(order))
            values.append(weight * entries)
            derivatives.append(weight[:, None] * slopes)
        return np.concatenate(values), np.concatenate(derivatives)


@lru_cache(maxsize=1)  # a frame and the symmetries of a solid are asked for one after the other
def solid_moments(mesh: Mesh) -> SolidMoments:
    """Return the moments of the solid that the faces enclose.

    The integrals run over signed tetrahedra from one apex to the faces. Holes are closed by cones from the
    apex, `Mesh.middle` at first and then the centroid that came of it, so the moments of an open mesh
    hardly depend on where its vertices lie densely; if those are no solid's, the middle again. The
    winding does not matter.

    Raises
    ------
    NoSolidError
        If the faces enclose no volume, as those of a flat sheet, or are wound so at variance that the second
        moments are not those of a solid.
    """
    moments = _seen_from(mesh, volume_moments(mesh).centroid)
    if not _is_solid(moments.second):
        moments = _seen_from(mesh, mesh.middle)  # the cones over a large hole can be too much from there
    whitening(moments.second, mesh.name)
    return moments


def _seen_from(mesh: Mesh, apex: FloatArray) -> SolidMoments:
    """Return the moments of the solid of which an apex sees the faces."""
    unit = mesh.diagonal
    integrals = kernels.cone_integrals(mesh.vertices, mesh.faces, apex, unit)
    volume = integrals[0, 0, 0]
    check_volume(mesh, volume * unit**3)
    shift = _tensor(integrals, 1) / volume
    central = _centred(shift, *(_tensor(integrals, order) / volume for order in ORDERS))
    return SolidMoments(
        apex + unit * shift, *(unit**order * t for order, t in zip(ORDERS, central, strict=True))
    )


def _is_solid(second: FloatArray) -> bool:
    """Tell whether second moments are positive, as those of a solid are, and not as flat as a sheet's."""
    values = np.linalg.eigvalsh(second)
    return bool(values[0] > LEAST_MOMENT * abs(values[2]))


def whitening(second: FloatArray, name: str) -> tuple[FloatArray, FloatArray]:
    """Return the symmetric maps that make second moments a unit matrix, and of a unit matrix them.

    Parameters
    ----------
    second : (3, 3) ndarray
        Second moments of a solid.
    name : str
        Of the mesh, for the message.

    Raises
    ------
    NoSolidError
        If they are not positive, as can be where parts of a mesh are wound inwards and others outwards, or
        where it is a sheet.
    """
    values, axes = np.linalg.eigh(second)
    if not _is_solid(second):
        raise NoSolidError(
            f"{name}: its faces bound no solid that extends in every direction; wind all parts alike, and "
            "close an open sheet."
        )
    return (axes / np.sqrt(values)) @ axes.T, (axes * np.sqrt(values)) @ axes.T


def _centred(
    d: FloatArray, second: FloatArray, third: FloatArray, fourth: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Move moments from the apex to the centroid, which lies at d from it; zero but for open meshes."""
    dd = np.multiply.outer(d, d)
    central2 = second - dd
    central3 = third - symmetrized(np.multiply.outer(central2, d), 3) - np.multiply.outer(dd, d)
    central4 = (
        fourth
        - symmetrized(np.multiply.outer(central3, d), 4)
        - symmetrized(np.multiply.outer(central2, dd), 6)
        - np.multiply.outer(dd, dd)
    )
    return central2, central3, central4


def _tensor(integrals: FloatArray, order: int) -> FloatArray:
    """Put ∫ xⁱ yʲ zᵏ, i + j + k = order, into a symmetric tensor."""
    indices = np.indices((3,) * order).reshape(order, -1)
    i, j, k = ((indices == axis).sum(axis=0) for axis in range(3))
    return np.asarray(integrals[i, j, k]).reshape((3,) * order)
