"""Attacks: attack(mesh, rng) -> mesh, one file a family."""

from wm3d.attacks.added import Companion, Pedestal
from wm3d.attacks.base import Attack, Clean, Owner
from wm3d.attacks.chain import Chain
from wm3d.attacks.cropping import Crop, HalfSpaceCrop
from wm3d.attacks.deformation import Bend, Shear, Stretch, Twist
from wm3d.attacks.exchange import Draco, RoundTrip, Weld
from wm3d.attacks.faces import DropFaces, FlipFaces, RepeatFaces
from wm3d.attacks.links import BUILTIN
from wm3d.attacks.marking import Collusion, Remark
from wm3d.attacks.mirror import Mirror
from wm3d.attacks.noise import GaussianNoise, Noise, UniformNoise
from wm3d.attacks.order import Reorder
from wm3d.attacks.printing import PrintScan
from wm3d.attacks.quantization import Float32, Quantize
from wm3d.attacks.remeshing import IsotropicRemesh, ScreenedPoisson
from wm3d.attacks.similarity import Similarity
from wm3d.attacks.simplification import Simplify
from wm3d.attacks.smoothing import LaplacianSmoothing, TaubinSmoothing
from wm3d.attacks.subdivision import Subdivide
from wm3d.attacks.voxels import MarchingCubes
from wm3d.registry import Registry

ATTACKS: Registry[Attack] = Registry("attack", Attack, *BUILTIN, Chain)  # type: ignore[type-abstract]

__all__ = [
    "ATTACKS",
    "Attack",
    "Bend",
    "Chain",
    "Clean",
    "Collusion",
    "Companion",
    "Crop",
    "Draco",
    "DropFaces",
    "FlipFaces",
    "Float32",
    "GaussianNoise",
    "HalfSpaceCrop",
    "IsotropicRemesh",
    "LaplacianSmoothing",
    "MarchingCubes",
    "Mirror",
    "Noise",
    "Owner",
    "Pedestal",
    "PrintScan",
    "Quantize",
    "Remark",
    "Reorder",
    "RepeatFaces",
    "RoundTrip",
    "ScreenedPoisson",
    "Shear",
    "Similarity",
    "Simplify",
    "Stretch",
    "Subdivide",
    "TaubinSmoothing",
    "Twist",
    "UniformNoise",
    "Weld",
]
