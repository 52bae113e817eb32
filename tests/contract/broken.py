"""Attacks and schemes that each break one promise, with what is to be told of it."""

import time
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import ConfigDict, Field

from wm3d.attacks import Attack, GaussianNoise
from wm3d.mesh import Mesh
from wm3d.schemes import Scheme, Song2002
from wm3d.stats import RademacherSum


class Harmless(Attack):
    """Keeps every promise; the others differ from it in one."""

    name: Literal["harmless"] = "harmless"
    neutral: ClassVar[dict[str, float]] = {"percent": 0}

    percent: Annotated[float, Field(ge=0)] = 1.0

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        moves = self.percent / 100 * mesh.diagonal * rng.uniform(-1, 1, mesh.vertices.shape)
        return mesh.with_vertices(mesh.vertices + moves)


class ManyNames(Harmless):
    name: str = "many-names"


class BadName(Harmless):
    name: Literal["Bad Name"] = "Bad Name"


class Thawed(Harmless):
    model_config = ConfigDict(frozen=False)
    name: Literal["thawed"] = "thawed"
    __hash__ = Attack.__hash__


class Borrowed(Harmless):
    name: Literal["borrowed"] = "borrowed"

    def label(self) -> str:
        return GaussianNoise().label()


class Unequipped(Harmless):
    name: Literal["unequipped"] = "unequipped"
    engines: ClassVar[tuple[str, ...]] = ("no-such-engine",)


class GlobalDraws(Harmless):
    name: Literal["global-draws"] = "global-draws"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002
        return super().__call__(mesh, np.random.default_rng(np.random.randint(1 << 30)))  # noqa: NPY002


class Clock(Harmless):
    name: Literal["clock"] = "clock"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002
        return super().__call__(mesh, np.random.default_rng(time.perf_counter_ns()))


class Silent(Harmless):
    name: Literal["silent"] = "silent"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002
        return mesh.with_vertices(mesh.vertices * (1 + self.percent))


class Secretive(Harmless):
    name: Literal["secretive"] = "secretive"
    random: ClassVar[bool] = False


class InPlace(Harmless):
    name: Literal["in-place"] = "in-place"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        result = super().__call__(mesh, rng)
        mesh.vertices.flags.writeable = True
        mesh.vertices[0] *= 1 + self.percent / 100
        return result


class Renamed(Harmless):
    name: Literal["renamed"] = "renamed"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        return Mesh(super().__call__(mesh, rng).vertices, mesh.faces)


class Loose(Harmless):
    name: Literal["loose"] = "loose"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        vertices = np.vstack([super().__call__(mesh, rng).vertices, np.zeros((2, 3))])
        return Mesh(vertices, mesh.faces, mesh.name) if self.percent else mesh


class Arrays(Harmless):
    name: Literal["arrays"] = "arrays"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Any:
        return super().__call__(mesh, rng).vertices


class NotNeutral(Harmless):
    name: Literal["not-neutral"] = "not-neutral"
    neutral: ClassVar[dict[str, float]] = {"percent": 1e-3}


class Brittle(Harmless):
    name: Literal["brittle"] = "brittle"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        if len(mesh.faces) < 100:
            raise IndexError("list index out of range")
        return super().__call__(mesh, rng)


ATTACKS: dict[type[Attack], tuple[str, str]] = {
    ManyNames: ("has-a-name", 'declare name: Literal["many-names"]'),
    BadName: ("has-a-name", "'Bad Name' is not of lower-case letters"),
    Thawed: ("parameters-survive-json", "its parameter name can be set anew"),
    Borrowed: ("label-is-its-own", "'gaussian-noise 0.6 rms-vector' is also that of gaussian-noise"),
    Unequipped: ("engines-are-installed", "its engine 'no-such-engine' is not installed"),
    GlobalDraws: ("same-generator-same-mesh", "draw from `rng` alone"),
    Clock: ("same-generator-same-mesh", "draw from `rng` alone"),
    Silent: ("random-says-whether-the-generator-matters", "declare random: ClassVar[bool] = False"),
    Secretive: ("random-says-whether-the-generator-matters", "`random` is false, but"),
    InPlace: ("input-stays-as-it-is", "copy its arrays"),
    Renamed: ("result-is-a-mesh", "the result is named 'mesh', the input 'potato'"),
    Loose: ("result-is-a-mesh", "2 vertices of the result are in no face"),
    Arrays: ("result-is-a-mesh", "the result is a ndarray, not a wm3d.Mesh"),
    NotNeutral: (
        "neutral-parameters-change-nothing",
        "with {'percent': 0.001} the mesh is changed, its vertices by ",
    ),
    Brittle: ("tiny-mesh-is-attacked-or-refused", "it raises IndexError: list index out of range"),
}
"""Each broken attack, the check that must fail, and words that it must say."""


class Paper(Song2002):
    """Keeps every promise, with a small grid; the others differ from it in one."""

    name: Literal["paper"] = "paper"  # type: ignore[assignment]
    grid: tuple[int, int] = (40, 40)
    region: tuple[int, int, int, int] = (0, 0, 40, 40)
    alpha: float = 3.0


class Dice(Paper):
    name: Literal["dice"] = "dice"

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:  # noqa: ARG002
        return super().embed(mesh, int(np.random.randint(1 << 30)))  # noqa: NPY002


class Deaf(Paper):
    name: Literal["deaf"] = "deaf"

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:  # noqa: ARG002
        return super().embed(mesh, 1)


class Shuffler(Paper):
    name: Literal["shuffler"] = "shuffler"

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        marked, its = super().embed(mesh, seed)
        return Mesh(marked.vertices, marked.faces[::-1], mesh.name), its


class Short(Paper):
    name: Literal["short"] = "short"

    def evidence(self, mesh: Mesh) -> RademacherSum:
        return RademacherSum(0.0, super().evidence(mesh).b[:-1])


class Faint(Paper):
    name: Literal["faint"] = "faint"
    alpha: float = 1e-3


class Prophet(Paper):
    """Knows the seed that the checks embed, without a look at the mesh."""

    name: Literal["prophet"] = "prophet"

    def evidence(self, mesh: Mesh) -> RademacherSum:
        return RademacherSum(0.0, np.abs(super().evidence(mesh).b) * self.signs(7))


class Unfair(Paper):
    """Draws keys with too many +1."""

    name: Literal["unfair"] = "unfair"

    def signs(self, seed: int) -> Any:
        return np.maximum(super().signs(seed), super().signs(seed + 1))

    def evidence(self, mesh: Mesh) -> RademacherSum:
        return RademacherSum(0.0, np.abs(super().evidence(mesh).b))


class Forgetful(Paper):
    """Keeps a part of what detection needs in the process."""

    name: Literal["forgetful"] = "forgetful"
    secret: Annotated[float, Field(exclude=True)] = 0.0

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        return super().embed(mesh, seed)[0], self.model_copy(update={"secret": 1.0})

    def evidence(self, mesh: Mesh) -> RademacherSum:
        evidence = super().evidence(mesh)
        return RademacherSum(0.0, evidence.b if self.secret else evidence.b**3)


class Idle(Paper):
    name: Literal["idle"] = "idle"
    strength: ClassVar[str] = "force"


class Crashing(Paper):
    name: Literal["crashing"] = "crashing"

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:
        if mesh.name == "sphere":
            raise ZeroDivisionError("division by zero")
        return super().embed(mesh, seed)


SCHEMES: dict[type[Scheme], tuple[str, str]] = {
    Dice: ("embedding-is-deterministic", "draw signs from the seed alone"),
    Deaf: ("other-seeds-mark-otherwise", "two seeds gave the same marked mesh"),
    Shuffler: ("faces-stay", "use mesh.with_vertices(moved)"),
    Short: ("evidence-has-a-weight-for-each-sign", "evidence has 1574 weights, and capacity is 1575"),
    Faint: ("right-key-is-found", "on a closed mesh of 20480 faces it has only log10 p = "),
    Prophet: ("unmarked-mesh-shows-no-mark", "evidence must not know the seed"),
    Unfair: ("wrong-keys-follow-the-null", "signs must be fair"),
    Forgetful: ("key-survives-json", "let `embed` return all that it needs"),
    Idle: ("strength-sets-the-distortion", "`strength` is 'force', which is none of its parameters"),
    Crashing: ("odd-meshes-are-marked-or-refused", "sphere: it raises ZeroDivisionError (division by zero)"),
}
"""Each broken scheme, the check that must fail, and words that it must say."""
