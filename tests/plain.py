"""The plain signs of range-dct: those of the coefficients themselves, which rough attacks leave as well."""

from wm3d.imagemarks.fine_signs import LAYERS
from wm3d.mesh import Mesh
from wm3d.schemes import Scheme
from wm3d.stats import RademacherSum


def plain_z(scheme: Scheme, mesh: Mesh, seed: int) -> float:
    """Return z of the plain signs of a key alone."""
    evidence, plain = scheme.evidence(mesh), scheme.capacity // (1 + LAYERS)
    return RademacherSum(0.0, evidence.b[:plain]).score(scheme.signs(seed)[:plain]).z
