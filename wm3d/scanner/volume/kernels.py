"""Numba kernel of the volume image: faces in parts, each dealt out to the four cells around it.

Sums run in face order on one thread, so a result never depends on the machine's cores. Its plain numpy twin
is `wm3d.scanner.volume.volume_image_reference`.
"""

import math

import numpy as np
from numba import njit

from wm3d.arrays import FloatArray, IntArray

MOST_PARTS = 512
"""Most parts along a side of a face."""


@njit(cache=True, error_model="numpy")
def deposit(
    posed: FloatArray, faces: IntArray, rows: int, columns: int, hmin: float, height: float, samples: float
) -> tuple[FloatArray, FloatArray]:
    """Return ∮ φ (ρ/2) e_ρ·n dA and ∮ φ dA of each cell, (N_u, N_v), n by the winding and the right hand."""
    flux, area = np.zeros((rows, columns)), np.zeros((rows, columns))
    for f in range(len(faces)):
        a, b, c = np.uintp(faces[f, 0]), np.uintp(faces[f, 1]), np.uintp(faces[f, 2])
        d0, d1, d2 = posed[b, 0] - posed[a, 0], posed[b, 1] - posed[a, 1], posed[b, 2] - posed[a, 2]
        e0, e1, e2 = posed[c, 0] - posed[a, 0], posed[c, 1] - posed[a, 1], posed[c, 2] - posed[a, 2]
        n0, n1, n2 = d1 * e2 - d2 * e1, d2 * e0 - d0 * e2, d0 * e1 - d1 * e0
        doubled = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        if doubled == 0.0:
            continue
        parts = _parts(posed, a, b, c, rows / height, columns / (2.0 * math.pi), samples)
        share = 1.0 / (3 * parts * parts)
        for i in range(parts):
            for k in range(2 * (parts - i) - 1):  # upright and turned parts of a strip in turn
                side = 1.0 - 2.0 * (k % 2)
                s0, t0 = (i + k % 2) / parts, (k // 2 + k % 2) / parts
                for q in range(3):
                    s = s0 + side * (4.0 if q == 1 else 1.0) / (6 * parts)
                    t = t0 + side * (4.0 if q == 2 else 1.0) / (6 * parts)
                    across, depth = posed[a, 1] + s * d1 + t * e1, posed[a, 2] + s * d2 + t * e2
                    u = (posed[a, 0] + s * d0 + t * e0 - hmin) / height * rows - 0.5
                    v = math.atan2(across, depth) / (2.0 * math.pi) * columns
                    through = 0.25 * share * (across * n1 + depth * n2)
                    _deal(flux, area, u, v, through, 0.5 * share * doubled)
    return flux, area


@njit(cache=True, error_model="numpy")
def _parts(
    posed: FloatArray,
    a: np.uintp,
    b: np.uintp,
    c: np.uintp,
    per_height: float,
    per_angle: float,
    samples: float,
) -> int:
    """Parts along a side, from the cells that the face spans along the axis and around it."""
    tall = max(posed[a, 0], posed[b, 0], posed[c, 0]) - min(posed[a, 0], posed[b, 0], posed[c, 0])
    wide = math.hypot(
        max(posed[a, 1], posed[b, 1], posed[c, 1]) - min(posed[a, 1], posed[b, 1], posed[c, 1]),
        max(posed[a, 2], posed[b, 2], posed[c, 2]) - min(posed[a, 2], posed[b, 2], posed[c, 2]),
    )
    near = min(
        math.hypot(posed[a, 1], posed[a, 2]),
        math.hypot(posed[b, 1], posed[b, 2]),
        math.hypot(posed[c, 1], posed[c, 2]),
    )
    cells = max(tall * per_height, wide / max(near, 0.25 * wide, 1e-300) * per_angle)
    parts: int = min(max(math.ceil(samples * cells), 1), MOST_PARTS)
    return parts


@njit(cache=True, error_model="numpy")
def _deal(flux: FloatArray, area: FloatArray, u: float, v: float, through: float, extent: float) -> None:
    """Deal the flux through a part and its area out to the four cells around it, by eqs. 10 and 11."""
    rows, columns = flux.shape
    u0, v0 = math.floor(u), math.floor(v)
    fu, fv = 0.5 + 0.5 * math.cos(math.pi * (u - u0)), 0.5 + 0.5 * math.cos(math.pi * (v - v0))
    left, right = v0 % columns, (v0 + 1) % columns
    if 0 <= u0 < rows:
        flux[u0, left] += through * fu * fv
        flux[u0, right] += through * fu * (1.0 - fv)
        area[u0, left] += extent * fu * fv
        area[u0, right] += extent * fu * (1.0 - fv)
    if 0 <= u0 + 1 < rows:
        flux[u0 + 1, left] += through * (1.0 - fu) * fv
        flux[u0 + 1, right] += through * (1.0 - fu) * (1.0 - fv)
        area[u0 + 1, left] += extent * (1.0 - fu) * fv
        area[u0 + 1, right] += extent * (1.0 - fu) * (1.0 - fv)
