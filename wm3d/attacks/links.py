"""All attacks that a chain can hold: every one but the chain itself."""

from wm3d.attacks.added import Companion, Pedestal
from wm3d.attacks.base import Attack, Clean
from wm3d.attacks.cropping import Crop, HalfSpaceCrop
from wm3d.attacks.deformation import Bend, Shear, Stretch, Twist
from wm3d.attacks.exchange import Draco, RoundTrip, Weld
from wm3d.attacks.faces import DropFaces, FlipFaces, RepeatFaces
from wm3d.attacks.marking import Collusion, Remark
from wm3d.attacks.mirror import Mirror
from wm3d.attacks.noise import GaussianNoise, UniformNoise
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

BUILTIN: tuple[type[Attack], ...] = (
    Clean,
    GaussianNoise,
    UniformNoise,
    LaplacianSmoothing,
    TaubinSmoothing,
    Quantize,
    Simplify,
    Subdivide,
    IsotropicRemesh,
    MarchingCubes,
    ScreenedPoisson,
    Crop,
    HalfSpaceCrop,
    Pedestal,
    Companion,
    Similarity,
    Mirror,
    Stretch,
    Shear,
    Bend,
    Twist,
    Reorder,
    DropFaces,
    FlipFaces,
    RepeatFaces,
    Float32,
    RoundTrip,
    Weld,
    Draco,
    PrintScan,
    Collusion,
    Remark,
)

LINKS: Registry[Attack] = Registry("attack", Attack, *BUILTIN)  # type: ignore[type-abstract]
