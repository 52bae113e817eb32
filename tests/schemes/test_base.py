"""What every scheme inherits: a strength that reaches a wanted SNR, even where moves are not proportional."""

from typing import Annotated, ClassVar, Literal, Self

import numpy as np
import pytest
from pydantic import Field
from shapes import blob, box

from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh
from wm3d.metrics import Budget, snr
from wm3d.schemes import Scheme
from wm3d.schemes.vertex_ss import VertexSs
from wm3d.stats import RademacherSum


class Swelling(Scheme):
    """Marks a mesh by growing it, by a power of its strength."""

    name: Literal["swelling"] = "swelling"
    strength: ClassVar[str] = "growth"
    growth: float = 0.1
    power: float = 1.0

    @property
    def capacity(self) -> int:
        return 1

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:  # noqa: ARG002 (one signature)
        return mesh.with_vertices((1 + self.growth**self.power) * mesh.vertices), self

    def evidence(self, mesh: Mesh) -> RademacherSum:
        return RademacherSum(0.0, np.array([mesh.diagonal]))


@pytest.mark.parametrize("power", [0.6, 1.0, 1.4])
def test_strength_reaches_the_wanted_snr(power):
    scheme = Swelling(power=power).at_snr(box(), 0, 50.0)
    assert snr(box(), scheme.embed(box(), 0)[0]) == pytest.approx(50, abs=1e-6)
    assert scheme.growth**power == pytest.approx(10 ** (-50 / 20), rel=1e-6)


def test_strength_is_found_where_the_distortion_hardly_grows_with_it():
    scheme = Swelling(power=0.3).at_distortion(box(), 0, Budget(metric="snr", value=30.0), tolerance=0.2)
    assert snr(box(), scheme.embed(box(), 0)[0]) == pytest.approx(30, abs=0.2)
    with pytest.raises(Wm3dError, match="cannot be set to an SNR of 30 dB"):
        Swelling(power=0.001).at_snr(box(), 0, 30.0)


class Stepwise(Swelling):
    """Grows in steps of a tenth of a percent."""

    def embed(self, mesh: Mesh, seed: int) -> tuple[Mesh, Self]:  # noqa: ARG002 (one signature)
        return mesh.with_vertices((1 + round(self.growth, 3)) * mesh.vertices), self


def test_the_nearest_of_all_strengths_is_taken_where_the_distortion_jumps():
    wanted = -20 * np.log10(0.05) + 0.04  # between the steps of 49 and 50, and nearer to the latter
    scheme = Stepwise().at_snr(box(), 0, wanted)
    assert snr(box(), scheme.embed(box(), 0)[0]) == pytest.approx(-20 * np.log10(0.05))


def test_strength_is_bracketed_where_corrections_overshoot():
    scheme = Swelling(power=3.0).at_snr(box(), 0, 50.0)  # each would overshoot by twice the miss
    assert snr(box(), scheme.embed(box(), 0)[0]) == pytest.approx(50, abs=1e-3)


class Bounded(Swelling):
    """Cannot grow a mesh by half."""

    growth: Annotated[float, Field(gt=0, lt=0.5)] = 0.1


class Closed(Swelling):
    """Can grow a mesh by half at most."""

    growth: Annotated[float, Field(gt=0, le=0.5)] = 0.1


@pytest.mark.parametrize("scheme", [Bounded(), Closed()])
def test_strength_stays_within_its_bound(scheme: Swelling):
    assert scheme.at_snr(box(), 0, 6.5).growth == pytest.approx(10 ** (-6.5 / 20))
    with pytest.raises(
        Wm3dError, match=r"^box: swelling .* an SNR of 5\.9 dB; the nearest is 0\.121 dB too weak\.$"
    ):
        scheme.at_snr(box(), 0, 5.9)  # a growth of 0.507


def test_what_is_far_beyond_the_bound_of_a_strength_is_not_looked_for_up_to_the_bound():
    tried = []

    class Slow(Bounded):
        def embed(self, mesh, seed):
            tried.append(self.growth)
            return super().embed(mesh, seed)

    with pytest.raises(Wm3dError, match=r"dB too weak\.$"):
        Slow().at_snr(box(), 0, 1.0)  # a growth of 0.89
    assert len(tried) <= 3
    assert max(tried) < 0.4


def test_a_strength_that_names_no_parameter_is_told():
    class Strange(Swelling):
        strength = "force"

    with pytest.raises(Wm3dError, match=r"^Strange: `strength` is 'force', which is none of its parameters"):
        Strange().at_snr(box(), 0, 6.5)


class RefusingNearItsBound(Bounded):
    """Moves grow by the square of the growth; above 0.45 nothing can be marked."""

    name: Literal["refusing"] = "refusing"

    def embed(self, mesh, seed):
        if self.growth > 0.45:
            raise Wm3dError("box: has no room.")
        return Bounded(growth=self.growth**2).embed(mesh, seed)[0], self


def test_a_strength_is_found_below_a_bound_near_which_nothing_can_be_marked():
    found = RefusingNearItsBound().at_snr(box(), 0, -20 * np.log10(0.3**2))
    assert found.growth == pytest.approx(0.3, rel=1e-4)


def test_score_is_the_evidence_for_the_signs_of_the_seed():
    scores = {Swelling().score(box(), seed).z for seed in range(20)}
    assert scores == {-1.0, 1.0}


@pytest.mark.parametrize(
    ("metric", "value"), [("mrms", 0.5), ("snr", 50.0), ("msdm2", 0.02)], ids=["mrms", "snr", "msdm2"]
)
def test_strength_reaches_a_budget_of_any_metric(metric, value):
    mesh, budget = blob(subdivisions=4), Budget(metric=metric, value=value)
    scheme = VertexSs(alpha=1e-4).at_distortion(mesh, 3, budget, tolerance=0.01)
    reached = budget.measured(mesh, scheme.embed(mesh, 3)[0])
    assert reached == pytest.approx(value, rel=10 ** (0.01 / 20) - 1)


def test_headroom_counts_every_metric_in_decibels_of_strength():
    assert Budget(metric="snr", value=44).headroom(50.0) == 6.0
    assert Budget(metric="mrms", value=0.2).headroom(0.1) == pytest.approx(20 * np.log10(2))
    assert Budget(metric="msdm2", value=0.2).headroom(0.0) == np.inf
    with pytest.raises(ValueError, match="an MRMS of 0 % leaves no room for a mark"):
        Budget(metric="mrms", value=0.0)
