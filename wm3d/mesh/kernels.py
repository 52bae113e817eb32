"""Numba kernels of the mesh bounds, moments and hashes: one pass, one thread, sums in file order.

The order of the sums is fixed, so a result depends neither on a thread count nor on a BLAS build. Coordinates
are taken relative to a reference point near the mesh, which keeps the sums exact far from the origin.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from wm3d.arrays import FloatArray, IntArray

Vector = tuple[float, float, float]


@njit(cache=True)
def bounds(vertices: FloatArray) -> tuple[FloatArray, FloatArray, bool]:
    """Least and greatest coordinates, (3,) each, of (n, 3) vertices, and whether all are finite.

    Without meaning where they are not. numpy's take 30 times as long.
    """
    finite = True
    low_x, low_y, low_z = vertices[0]
    high_x, high_y, high_z = vertices[0]
    for i in range(vertices.shape[0]):
        x, y, z = vertices[i]
        finite &= (x - x == 0.0) & (y - y == 0.0) & (z - z == 0.0)
        low_x, low_y, low_z = min(low_x, x), min(low_y, y), min(low_z, z)
        high_x, high_y, high_z = max(high_x, x), max(high_y, y), max(high_z, z)
    return np.array([low_x, low_y, low_z]), np.array([high_x, high_y, high_z]), finite


@njit(cache=True)
def vertex_mean(vertices: FloatArray) -> FloatArray:
    """Mean (3,) of the rows of (n, 3) vertices, summed relative to the first row."""
    x0, y0, z0 = vertices[0, 0], vertices[0, 1], vertices[0, 2]
    sx = sy = sz = 0.0
    for i in range(vertices.shape[0]):
        sx += vertices[i, 0] - x0
        sy += vertices[i, 1] - y0
        sz += vertices[i, 2] - z0
    n = vertices.shape[0]
    return np.array([x0 + sx / n, y0 + sy / n, z0 + sz / n])


@njit(cache=True)
def vertex_covariance(vertices: FloatArray, mean: FloatArray) -> FloatArray:
    """Second moments (3, 3) of (n, 3) vertices about `mean`, over n."""
    xx = xy = xz = yy = yz = zz = 0.0
    for i in range(vertices.shape[0]):
        x, y, z = _relative(vertices, i, mean)
        xx += x * x
        xy += x * y
        xz += x * z
        yy += y * y
        yz += y * z
        zz += z * z
    covariance: FloatArray = _symmetric(xx, xy, xz, yy, yz, zz) / vertices.shape[0]
    return covariance


@njit(cache=True)
def signed_volume(vertices: FloatArray, faces: IntArray, apex: FloatArray) -> float:
    """Sum over the faces of the signed volume of the tetrahedron (apex, a, b, c)."""
    total = 0.0
    for f in range(faces.shape[0]):
        total += cone(vertices, faces, f, apex)
    return total / 6.0


@njit(cache=True)
def cone(vertices: FloatArray, faces: IntArray, f: int, apex: FloatArray) -> float:
    """Return six times the signed volume of the tetrahedron (apex, a, b, c) of one face."""
    a = _relative(vertices, faces[f, 0], apex)
    b = _relative(vertices, faces[f, 1], apex)
    c = _relative(vertices, faces[f, 2], apex)
    six_volumes: float = _determinant(a, b, c)
    return six_volumes


@njit(cache=True)
def surface_area(vertices: FloatArray, faces: IntArray) -> float:
    """Sum of the triangle areas."""
    total = 0.0
    for f in range(faces.shape[0]):
        total += _doubled_area(vertices, faces, f)
    return total / 2.0


@njit(cache=True)
def face_areas(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Area of each face: (m,)."""
    areas = np.empty(faces.shape[0])
    for f in range(faces.shape[0]):
        areas[f] = _doubled_area(vertices, faces, f) / 2.0
    return areas


@njit(cache=True)
def normal_sums(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Sum of the normals of the faces around each vertex, twice as long as their areas: (n, 3)."""
    sums = np.zeros_like(vertices)
    for f in range(faces.shape[0]):
        normal = _doubled_normal(vertices, faces, f)
        for k in range(3):
            for axis in range(3):
                sums[faces[f, k], axis] += normal[axis]
    return sums


@njit(cache=True)
def cumulated_area(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Area of each face and of all before it: (m,)."""
    reached, total = np.empty(faces.shape[0]), 0.0
    for f in range(faces.shape[0]):
        total += _doubled_area(vertices, faces, f)
        reached[f] = total / 2.0
    return reached


@njit(cache=True)
def volume_integrals(
    vertices: FloatArray, faces: IntArray, apex: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """Integrals of 1, x (3,) and x xᵀ (3, 3) over the signed tetrahedra (apex, a, b, c), x relative to apex.

    With s = a + b + c and d = det[a b c]: ∫1 = d/6, ∫x = d s/24, ∫x xᵀ = d (s sᵀ + a aᵀ + b bᵀ + c cᵀ)/120.
    """
    volume = sx = sy = sz = 0.0
    xx = xy = xz = yy = yz = zz = 0.0
    for f in range(faces.shape[0]):
        a = _relative(vertices, faces[f, 0], apex)
        b = _relative(vertices, faces[f, 1], apex)
        c = _relative(vertices, faces[f, 2], apex)
        d = _determinant(a, b, c)
        x, y, z = a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]
        volume += d
        sx += d * x
        sy += d * y
        sz += d * z
        xx += d * (x * x + a[0] * a[0] + b[0] * b[0] + c[0] * c[0])
        xy += d * (x * y + a[0] * a[1] + b[0] * b[1] + c[0] * c[1])
        xz += d * (x * z + a[0] * a[2] + b[0] * b[2] + c[0] * c[2])
        yy += d * (y * y + a[1] * a[1] + b[1] * b[1] + c[1] * c[1])
        yz += d * (y * z + a[1] * a[2] + b[1] * b[2] + c[1] * c[2])
        zz += d * (z * z + a[2] * a[2] + b[2] * b[2] + c[2] * c[2])
    return volume / 6.0, np.array([sx, sy, sz]) / 24.0, _symmetric(xx, xy, xz, yy, yz, zz) / 120.0


@njit(cache=True)
def edge_sum(faces: IntArray) -> np.uint64:
    """Sum ± a hash of each side of each face modulo 2⁶⁴, by the direction in which the side runs.

    0 where every directed edge occurs as often as its opposite; else 0 with a chance of 2⁻⁶⁴.
    """
    total = np.uint64(0)
    for f in range(faces.shape[0]):
        a, b, c = np.uint64(faces[f, 0]), np.uint64(faces[f, 1]), np.uint64(faces[f, 2])
        total += directed(a, b) + directed(b, c) + directed(c, a)
    return total


@njit(cache=True)
def umbrella_step(vertices: FloatArray, faces: IntArray, weight: float) -> FloatArray:
    """Move every vertex by `weight` of the way to the mean of its neighbours, all at once: (n, 3).

    Neighbours count once for each face they share, so twice inside a closed surface.
    """
    total, count = np.zeros_like(vertices), np.zeros(vertices.shape[0])
    for f in range(faces.shape[0]):
        i, j, k = np.uintp(faces[f, 0]), np.uintp(faces[f, 1]), np.uintp(faces[f, 2])
        for t in range(3):
            x, y, z = vertices[i, t], vertices[j, t], vertices[k, t]
            total[i, t] += y + z
            total[j, t] += z + x
            total[k, t] += x + y
        count[i] += 2.0
        count[j] += 2.0
        count[k] += 2.0
    moved = vertices.copy()
    for n in range(vertices.shape[0]):
        if count[n] > 0.0:
            for t in range(3):
                moved[n, t] += weight * (total[n, t] / count[n] - vertices[n, t])
    return moved


_WIDE, _NARROW = 0.445948490915965, 0.091576213509771
_DUNAVANT = np.array(
    [
        [1 - 2 * _WIDE, _WIDE, _WIDE, 0.223381589678011],
        [_WIDE, 1 - 2 * _WIDE, _WIDE, 0.223381589678011],
        [_WIDE, _WIDE, 1 - 2 * _WIDE, 0.223381589678011],
        [1 - 2 * _NARROW, _NARROW, _NARROW, 0.109951743655322],
        [_NARROW, 1 - 2 * _NARROW, _NARROW, 0.109951743655322],
        [_NARROW, _NARROW, 1 - 2 * _NARROW, 0.109951743655322],
    ]
)
"""Barycentric points and weights that integrate polynomials of degree 4 exactly (Dunavant 1985)."""


@njit(cache=True)
def cone_integrals(vertices: FloatArray, faces: IntArray, apex: FloatArray, unit: float) -> FloatArray:
    """Integrals of xⁱ yʲ zᵏ over the signed tetrahedra (apex, a, b, c), from the apex, in a unit: (5, 5, 5).

    Entries with i + j + k > 4 are zero. For f of degree p, ∫ f = det[a b c] / (2 (p + 3)) times the mean of f
    over the face, which six points give exactly.
    """
    total = np.zeros((5, 5, 5))
    for f in range(faces.shape[0]):
        a = _shrunk(_relative(vertices, faces[f, 0], apex), unit)
        b = _shrunk(_relative(vertices, faces[f, 1], apex), unit)
        c = _shrunk(_relative(vertices, faces[f, 2], apex), unit)
        d = _determinant(a, b, c)
        for q in range(6):
            p, r, s, weight = _DUNAVANT[q]
            x, y, z = (
                p * a[0] + r * b[0] + s * c[0],
                p * a[1] + r * b[1] + s * c[1],
                p * a[2] + r * b[2] + s * c[2],
            )
            xi = d * weight
            for i in range(5):
                yj = xi
                for j in range(5 - i):
                    zk = yj
                    for k in range(5 - i - j):
                        total[i, j, k] += zk
                        zk *= z
                    yj *= y
                xi *= x
    for i in range(5):
        for j in range(5):
            for k in range(5):
                total[i, j, k] /= 2.0 * (i + j + k + 3)
    return total


@njit(cache=True)
def mapped_entries(tensor: FloatArray, matrix: FloatArray, places: IntArray) -> tuple[FloatArray, FloatArray]:
    """Entries at places (n, k) of a flat symmetric tensor (3ᵏ,), mapped, and slopes (n, 9) by the matrix."""
    count, order = places.shape
    half = tensor  # mapped in all indices but the last
    for _ in range(order - 1):
        half = _index_mapped(half, matrix)
    whole = _index_mapped(half, matrix)
    entries, slopes = np.empty(count), np.zeros((count, 9))
    for n in range(count):
        entries[n] = whole[_flat(places[n], order)]
        # d/dM_ij of Σ half_ab...j' M_cj' is half_ab...j wherever one of the indices is i
        for slot in range(order):
            rest = 3 * _flat(places[n], slot)
            for j in range(3):
                slopes[n, 3 * places[n, slot] + j] += half[rest + j]
    return entries, slopes


@njit(cache=True)
def _index_mapped(tensor: FloatArray, matrix: FloatArray) -> FloatArray:
    """Map the last index of a flat tensor and make it the first."""
    rest = len(tensor) // 3
    mapped = np.empty(len(tensor))
    for i in range(3):
        for r in range(rest):
            x, y, z = tensor[3 * r], tensor[3 * r + 1], tensor[3 * r + 2]
            mapped[i * rest + r] = matrix[i, 0] * x + matrix[i, 1] * y + matrix[i, 2] * z
    return mapped


@njit(cache=True)
def _flat(place: IntArray, omitted: int) -> int:
    """Where a place lies in a flat tensor, without the index that is omitted."""
    flat = 0
    for slot in range(len(place)):
        if slot != omitted:
            flat = 3 * flat + place[slot]
    return flat


@njit(cache=True)
def mixed(key: np.uint64) -> np.uint64:
    """Mix the bits of a number (splitmix64, Steele, Lea & Flood 2014)."""
    key = (key ^ (key >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    key = (key ^ (key >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return key ^ (key >> np.uint64(31))


@njit(cache=True)
def directed(a: np.uint64, b: np.uint64) -> np.uint64:
    """Hash the edge from a to b; from b to a it is the negative."""
    key = mixed((min(a, b) << np.uint64(32)) + max(a, b) + np.uint64(0x9E3779B97F4A7C15))
    return key if a < b else np.uint64(0) - key if a > b else np.uint64(0)


@njit(cache=True)
def _relative(vertices: FloatArray, index: int, origin: FloatArray) -> Vector:
    i = np.uintp(index)  # unsigned: numba then omits the test for negative indices, which Mesh has done
    return vertices[i, 0] - origin[0], vertices[i, 1] - origin[1], vertices[i, 2] - origin[2]


@njit(cache=True)
def _doubled_area(vertices: FloatArray, faces: IntArray, f: int) -> float:
    nx, ny, nz = _doubled_normal(vertices, faces, f)
    doubled: float = np.sqrt(nx * nx + ny * ny + nz * nz)
    return doubled


@njit(cache=True)
def _doubled_normal(vertices: FloatArray, faces: IntArray, f: int) -> Vector:
    """Return the normal of a face by its winding and the right hand, twice as long as its area."""
    corner = vertices[faces[f, 0]]
    ux, uy, uz = _relative(vertices, faces[f, 1], corner)
    wx, wy, wz = _relative(vertices, faces[f, 2], corner)
    return uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx


@njit(cache=True)
def _shrunk(vector: Vector, unit: float) -> Vector:
    x, y, z = vector
    return x / unit, y / unit, z / unit


@njit(cache=True)
def _determinant(a: Vector, b: Vector, c: Vector) -> float:
    ax, ay, az = a
    bx, by, bz = b
    cx, cy, cz = c
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


@njit(cache=True)
def _symmetric(xx: float, xy: float, xz: float, yy: float, yz: float, zz: float) -> FloatArray:
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@njit(cache=True)
def row_hashes(rows: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Hash each row of (n, k) numbers: (n,). Unlike rows have the same one with a chance of 2⁻⁶⁴ a pair."""
    hashes = np.zeros(rows.shape[0], np.uint64)
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            hashes[i] = mixed(hashes[i] ^ rows[i, k])
    return hashes
