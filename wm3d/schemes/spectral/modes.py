"""The lowest eigenvectors of the combinatorial Laplacian K = D − A of a mesh, also of a large one."""

from functools import lru_cache

import numpy as np
from scipy import sparse
from scipy.linalg import eigh
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.sparse.linalg import eigsh, splu

from wm3d.arrays import FloatArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, adjacency

EXACT = 6000
"""Vertices up to which shift-invert Lanczos finds the modes; with more of them it would take minutes."""

MOST_PARTS = 256
"""Parts of a mesh: each has a constant among the lowest modes, so they must be found, too."""

_CLUSTERS_A_MODE = 10
_SMOOTHING = 2 / 3  # over the degree: the damped Jacobi step of smoothed aggregation
_SHIFT = 1e-6  # K is singular
_SPARE = 20  # modes beyond the wanted ones, where the subspace is less exact
_NULL = 1e-9  # an eigenvalue below this belongs to a constant over a component


# the original is asked for with each key of a trial, and its modes are the dearest step
@lru_cache(maxsize=2)
def lowest_modes(mesh: Mesh, count: int) -> FloatArray:
    """Return the orthonormal eigenvectors of K = D − A of the least eigenvalues above 0.

    Parameters
    ----------
    mesh : Mesh
        With A its adjacency by edges and D its degrees. Vertices that no face uses are in no mode.
    count : int

    Returns
    -------
    (n, count) ndarray
        By rising eigenvalue, each with a positive sum of cubes.

    Raises
    ------
    Wm3dError
        If the mesh has fewer than four vertices a mode, or falls into more than `MOST_PARTS` parts.

    Notes
    -----
    Beyond `EXACT` vertices: Rayleigh–Ritz on the smoothed aggregates of about 10 clusters a mode, then one
    step of inverse iteration on the whole subspace, after which the eigenvalues are right to two per cent.
    """
    used = np.unique(mesh.faces)
    if len(used) < 4 * count:
        raise Wm3dError(
            f"{mesh.name}: has {len(used)} vertices, too few for {count} spectral modes; use at most "
            f"{len(used) // 4}."
        )
    joined = adjacency(mesh)[used][:, used]
    degrees = np.asarray(joined.sum(axis=0), dtype=np.float64).ravel()
    laplacian = (sparse.diags_array(degrees) - joined).tocsc()
    parts = connected_components(joined, directed=False)[0]
    if parts > MOST_PARTS:
        raise Wm3dError(f"{mesh.name}: falls into {parts} parts, each with a constant mode; weld it first.")
    wanted = count + parts
    if len(used) <= max(EXACT, 4 * wanted):
        start = np.random.default_rng(0).normal(size=len(used))
        values, vectors = eigsh(laplacian, min(wanted, len(used) - 1), sigma=-_SHIFT, v0=start)
    else:
        subspace = _aggregates(joined, laplacian, degrees, wanted + _SPARE)
        solver = splu(
            (laplacian + _SHIFT * sparse.eye_array(len(used))).tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        subspace = solver.solve(subspace)
        subspace /= np.linalg.norm(subspace, axis=0)
        values, mixing = eigh(subspace.T @ (laplacian @ subspace), subspace.T @ subspace)
        vectors = subspace @ mixing
    order = [i for i in np.argsort(values) if values[i] > _NULL][:count]
    modes = np.zeros((len(mesh.vertices), count))
    modes[used, : len(order)] = vectors[:, order]
    modes *= np.where((modes**3).sum(axis=0) < 0, -1.0, 1.0)
    modes.flags.writeable = False
    return modes


def _aggregates(
    adjacency: sparse.csr_array, laplacian: sparse.csc_array, degrees: FloatArray, count: int
) -> FloatArray:
    """Return approximate modes (n, count) from the graph's Voronoi cells of seeds spread at random.

    Vaněk, Mandel, Brezina, "Algebraic Multigrid by Smoothed Aggregation", Computing 56, 1996: the indicator
    of each cell, smoothed by two Jacobi steps, spans the coarse space.
    """
    n = len(degrees)
    seeds = np.sort(np.random.default_rng(0).choice(n, min(_CLUSTERS_A_MODE * count, n // 2), replace=False))
    _, _, sources = dijkstra(
        adjacency, directed=False, indices=seeds, unweighted=True, min_only=True, return_predecessors=True
    )
    reached = np.flatnonzero(sources >= 0)  # a small component may hold no seed
    cell = np.searchsorted(seeds, sources[reached])
    indicator = sparse.csr_array((np.ones(len(reached)), (reached, cell)), shape=(n, len(seeds)))
    step = sparse.eye_array(n) - _SMOOTHING * sparse.diags_array(1 / degrees) @ laplacian
    coarse = (step @ (step @ indicator)).tocsr()
    stiffness, mass = (coarse.T @ laplacian @ coarse).toarray(), (coarse.T @ coarse).toarray()
    _, mixing = eigh(stiffness, mass, subset_by_index=[0, count - 1])
    modes: FloatArray = coarse @ mixing
    return modes
