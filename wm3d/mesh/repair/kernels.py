"""Numba kernels of the repair: what tells faces and parts apart, and the triangles that cover holes."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from wm3d.arrays import BoolArray, FloatArray, IntArray
from wm3d.mesh.kernels import cone, directed, mixed


@njit(cache=True)
def face_keys(marks: NDArray[np.uint64], faces: IntArray) -> IntArray:
    """Hash what each face spans: (m,), the same for faces of the same corners in any order.

    Faces that are a line or a point get a key of their own. Others that differ have the same one with a
    chance of 2⁻⁶⁴ a pair.

    Parameters
    ----------
    marks : (n,) ndarray
        A number for each vertex, the same in the same place.
    faces : (m, 3) ndarray
    """
    keys = np.empty(faces.shape[0], np.uint64)
    for f in range(faces.shape[0]):
        a, b, c = marks[faces[f, 0]], marks[faces[f, 1]], marks[faces[f, 2]]
        if a == b or b == c or c == a:
            keys[f] = mixed(np.uint64(f) ^ np.uint64(0x9E3779B97F4A7C15))
        else:
            keys[f] = mixed(mixed(a) + mixed(b) + mixed(c))
    return keys.view(np.int64)


@njit(cache=True)
def face_parts(vertices: int, faces: IntArray) -> tuple[IntArray, int]:
    """Give each face the number of its part, which hangs together by vertices: (m,), and how many there are.

    Parameters
    ----------
    vertices : int
        How many the faces are numbered among.
    faces : (m, 3) ndarray
    """
    above = np.arange(vertices)
    for f in range(faces.shape[0]):
        root = _root(above, faces[f, 0])
        for t in range(1, 3):
            other = _root(above, faces[f, t])
            above[max(root, other)] = root = min(root, other)
    number, part, parts = np.full(vertices, -1), np.empty(faces.shape[0], np.int64), 0
    for f in range(faces.shape[0]):
        root = _root(above, faces[f, 0])
        if number[root] < 0:
            number[root] = parts
            parts += 1
        part[f] = number[root]
    return part, parts


@njit(cache=True)
def _root(above: IntArray, node: int) -> int:
    while above[node] != node:
        above[node] = above[above[node]]
        node = above[node]
    return node


@njit(cache=True)
def part_volumes(
    vertices: FloatArray, faces: IntArray, part: IntArray, parts: int
) -> tuple[FloatArray, BoolArray]:
    """Return the signed volume of each part, and whether it is closed and wound alike: (parts,) each.

    The volume of an open part is that of the cones from one of its vertices.

    Parameters
    ----------
    vertices : (n, 3) ndarray
    faces : (m, 3) ndarray
    part : (m,) ndarray
    parts : int
        As `face_parts` returns them.
    """
    volumes, edges, apex = np.zeros(parts), np.zeros(parts, np.uint64), np.full(parts, -1)
    for f in range(faces.shape[0]):
        k = part[f]
        if apex[k] < 0:
            apex[k] = faces[f, 0]
        volumes[k] += cone(vertices, faces, f, vertices[apex[k]]) / 6.0
        a, b, c = np.uint64(faces[f, 0]), np.uint64(faces[f, 1]), np.uint64(faces[f, 2])
        edges[k] += directed(a, b) + directed(b, c) + directed(c, a)  # as `wm3d.mesh.kernels.edge_sum`
    return volumes, edges == 0


@njit(cache=True)
def hole_caps(
    end: IntArray, length: FloatArray, first: IntArray, most: int, longest: float
) -> tuple[IntArray, IntArray]:
    """Cover the loops of a rim by fans of triangles, wound against it: (k, 3) places, (k,) loops.

    From each place along the rim until a place is reached again: the loop since then is cut off and covered,
    if it has no more than so many sides and is no longer than that.

    Parameters
    ----------
    end : (r,) ndarray
        Where each directed side of the rim leads, those that leave the same place one after the other. As
        many lead to a place as leave it.
    length : (r,) ndarray
        Of those sides.
    first : (p + 1,) ndarray
        The first side that leaves each place.
    most : int
    longest : float
    """
    waiting = first[:-1].copy()  # the next side to leave each place by
    step = np.full(len(waiting), -1)  # at which step of the path a place was reached, if it lies on it
    path = np.empty(len(end) + 1, np.int64)
    gone = np.zeros(len(end) + 1)  # how long the path is up to each of its places
    caps, loop = np.empty((len(end), 3), np.int64), np.empty(len(end), np.int64)
    count = loops = 0
    for origin in range(len(waiting)):
        last, path[0], step[origin] = 0, origin, 0
        while waiting[path[last]] < first[path[last] + 1]:
            side = waiting[path[last]]
            waiting[path[last]] += 1
            reached, so_far = end[side], gone[last] + length[side]
            if step[reached] < 0:
                last += 1
                path[last], step[reached], gone[last] = reached, last, so_far
                continue
            begin = step[reached]
            if last - begin < most and so_far - gone[begin] <= longest:
                for k in range(begin + 1, last):
                    caps[count] = path[begin], path[k + 1], path[k]
                    loop[count] = loops
                    count += 1
                loops += 1
            for k in range(begin + 1, last + 1):
                step[path[k]] = -1
            last = begin
        step[origin] = -1
    return caps[:count], loop[:count]
