"""The least deformation that gives patches their volumes and leaves the frame where it is."""

import numpy as np
from scipy import sparse

from wm3d.arrays import FloatArray, IntArray
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh, volume_moments
from wm3d.schemes.patches.frame import Frame
from wm3d.schemes.patches.grid import Patches

STEPS = 8
"""Of Newton's method at most."""

TOLERANCE = 1e-9
"""Of volumes over their mean and of the global moments: far below the bits, and in reach of float64."""

_RIDGE = 1e-9  # of the trace: patches without vertices have masks without effect


def deformed(mesh: Mesh, frame: Frame, patches: Patches, chosen: IntArray, target: FloatArray) -> Mesh:
    """Return the mesh in which the chosen patches have the wanted volumes.

    The vertices move away from the axis, p⊥ → p⊥ (1 + Σ c_k φ_k) with the masks φ_k of their patch, by the
    least sum of squares that meets the volumes and keeps what the frame is made of: the total volume, the
    centroid and the off-diagonal second moments (the paper's compensation of the global moments). Height and
    angle of a vertex do not change, so its patch does not either.

    Parameters
    ----------
    mesh : Mesh
    frame : Frame
        That of the mesh.
    patches : Patches
    chosen : (c,) ndarray
        Numbers of patches.
    target : (c,) ndarray
        Their volumes, in units of the mean over all patches.

    Raises
    ------
    Wm3dError
        If Newton's method goes astray, as on surfaces with large holes, where the frame hangs on few patches.
    """
    posed = frame.posed(mesh)
    across = posed.copy()
    across[:, 0] = 0.0
    masks = patches.masks(posed, frame)
    index, _, _ = patches.place(posed, frame)
    weighed = masks.multiply(np.linalg.norm(across, axis=1)[:, None]).tocsr()
    norm = (weighed.T @ weighed).toarray()
    norm[np.diag_indices_from(norm)] += _RIDGE * max(np.trace(norm), 1e-300)
    start = _global(mesh, frame)

    def amiss(marked: Mesh) -> FloatArray:
        missed = target - patches.volumes(marked, frame)[chosen]
        return np.concatenate([missed, start - _global(marked, frame)])

    coefficients, marked = np.zeros(masks.shape[1]), mesh
    left = amiss(marked)
    asked = np.abs(left).max()
    for _ in range(STEPS):
        if np.abs(left).max() <= TOLERANCE:
            break
        growth = _growth(frame.posed(marked), across, mesh)
        jacobian = _jacobian(frame.posed(marked), growth, masks, index, frame, patches, chosen)
        spread = np.linalg.solve(norm, jacobian.T)
        step, *_ = np.linalg.lstsq(jacobian @ spread, left, rcond=1e-12)
        coefficients += spread @ step
        moves = across * (masks @ coefficients)[:, None]
        marked = mesh.with_vertices(mesh.vertices + moves @ frame.axes)
        left = amiss(marked)
    if not np.abs(left).max() <= asked:
        raise Wm3dError(
            f"{mesh.name}: no deformation gives {len(chosen)} patches their volumes and keeps the frame; use "
            "fewer bits, a smaller step, or a mesh without large holes."
        )
    return marked


def _growth(posed: FloatArray, across: FloatArray, mesh: Mesh) -> FloatArray:
    """Return the volume that each vertex adds when it moves by `across`, to first order."""
    a, b, c = (posed[mesh.faces[:, k]] for k in range(3))
    vector = np.cross(b - a, c - a) / 6  # a third of the area vector goes to each corner
    growth = np.zeros(len(posed))
    for k in range(3):
        share = np.einsum("ij,ij->i", vector, across[mesh.faces[:, k]])
        growth += np.bincount(mesh.faces[:, k], share, len(posed))
    return growth


def _jacobian(
    posed: FloatArray,
    growth: FloatArray,
    masks: sparse.csr_array,
    index: IntArray,
    frame: Frame,
    patches: Patches,
    chosen: IntArray,
) -> FloatArray:
    """Return d(volumes of the chosen patches, global moments)/d(coefficients): (c + 7, 3 · count)."""
    grown = masks.multiply(growth[:, None]).tocsr()
    places = index, np.arange(len(index))
    member = sparse.csr_array((np.ones(len(index)), places), shape=(patches.count, len(index)))
    local = (member @ grown).toarray()[chosen] * (patches.count / frame.volume)
    h, y, z = posed.T
    monomials = np.stack([np.ones_like(h), h, y, z, h * y, h * z, y * z]) / _scale(frame)[:, None]
    return np.vstack([local, (grown.T @ monomials.T).T])


def _global(mesh: Mesh, frame: Frame) -> FloatArray:
    """Return ∫ 1, h, y, z, hy, hz, yz over the solid in a frame, (7,), in natural units."""
    moments = volume_moments(mesh)
    center = frame.axes @ (moments.centroid - frame.center)
    second = frame.axes @ moments.covariance @ frame.axes.T + np.outer(center, center)
    products = second[[0, 0, 1], [1, 2, 2]]
    integrals = moments.volume * np.concatenate([[1.0], center, products])
    scaled: FloatArray = integrals / _scale(frame)
    return scaled


def _scale(frame: Frame) -> FloatArray:
    """Return the units of the seven integrals: volume times powers of a length."""
    length = abs(frame.volume) ** (1 / 3)
    scale: FloatArray = frame.volume * length ** np.array([0.0, 1, 1, 1, 2, 2, 2])
    return scale
