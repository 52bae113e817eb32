"""Time the ray casting against its numpy twin and against embree through trimesh, and check that they agree.

    python experiments/scanner_speed.py [MESH ...]

Every way starts from the vertices in the cylinder's frame and ends with 84 x 84 hits, on one thread, in the
same run. embree's time holds the building of its scene, which a benchmark pays for each attacked mesh. Its
first hit may be a face seen from behind; "all hits" are what it takes to find the first from the front.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

from wm3d.mesh import Mesh, datasets, orientation
from wm3d.scanner import VertexPca, kernels
from wm3d.scanner.reference import cast_reference

COLUMNS = ROWS = 84


def main(meshes: list[str], rounds: int) -> None:
    for name in meshes or ["igea" if "igea" in datasets.dataset_names() else "bunny"]:
        compare(datasets.resolve(name), rounds)


def compare(mesh: Mesh, rounds: int) -> None:
    cylinder = VertexPca()(mesh)
    planes, outward = cylinder.planes(ROWS), orientation(mesh)
    scene = (cylinder.posed(mesh), mesh.faces, planes, COLUMNS, cylinder.radius, outward)

    # s1, s3, s2: embree wants a right-handed frame
    cosine, sine = kernels.directions(COLUMNS)
    outwards = np.tile(np.column_stack([np.zeros(COLUMNS), cosine, sine]), (ROWS, 1))
    origins = cylinder.radius * outwards + np.repeat(planes, COLUMNS)[:, None] * [1.0, 0.0, 0.0]
    vertices, faces = np.ascontiguousarray(scene[0][:, [0, 2, 1]]), mesh.faces[:, ::outward]

    def embree() -> RayMeshIntersector:
        return RayMeshIntersector(trimesh.Trimesh(vertices, faces, process=False))

    ours, seconds = timed(lambda: kernels.cast(*scene), 5 * rounds)
    twin, twin_seconds = timed(lambda: cast_reference(*scene), 1)
    _, first_seconds = timed(lambda: embree().intersects_first(origins, -outwards), rounds)
    hits, all_seconds = timed(
        lambda: embree().intersects_location(origins, -outwards, multiple_hits=True), rounds
    )

    print(f"{mesh.name}: {len(faces)} faces, {ROWS} rows x {COLUMNS} columns, medians, one thread")
    print("                         ms    times ours")
    for label, value in (
        ("wm3d", seconds),
        ("numpy twin", twin_seconds),
        ("embree, first hit", first_seconds),
        ("embree, all hits", all_seconds),
    ):
        print(f"{label:18s} {1e3 * value:9.2f}  {value / seconds:9.1f}")

    points, ray, face = hits
    normals = np.cross(*np.diff(vertices[faces[face]], axis=1).swapaxes(0, 1))
    front = np.einsum("ij,ij->i", normals, outwards[ray]) > 0
    theirs = np.full(ROWS * COLUMNS, np.inf)
    np.minimum.at(theirs, ray[front], np.linalg.norm(points - origins[ray], axis=1)[front])
    theirs = np.where(np.isinf(theirs), np.nan, theirs).reshape(ROWS, COLUMNS)
    print(f"{np.isfinite(ours).sum()} rays hit; pixels that differ by more than 1e-9 r, and largest other:")
    for label, other in (("numpy twin", twin), ("embree", theirs)):
        error = np.where(np.isnan(ours) & np.isnan(other), 0.0, np.abs(ours - other) / cylinder.radius)
        agree = error <= 1e-9
        print(f"{label:18s} {(~agree).sum():4d}  {error[agree].max():.1e} r")
    print()


def timed(work: Callable[[], Any], rounds: int) -> tuple[Any, float]:
    """Return the result of the work and the median of its seconds; one round before the clock starts."""
    result, seconds = work(), []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return result, statistics.median(seconds)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("meshes", nargs="*", metavar="MESH", help="dataset or file; default igea or bunny")
    parser.add_argument("--rounds", type=int, default=7, help="timed rounds of embree; wm3d has five times")
    main(**vars(parser.parse_args()))
