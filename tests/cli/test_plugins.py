"""`wm3d check-plugin`: a line a promise, and an exit status that scripts can use."""

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import pytest

from wm3d.attacks import Attack
from wm3d.contract import ATTACK_CHECKS, SCHEME_CHECKS
from wm3d.mesh import Mesh
from wm3d.registry import Registry

Run = Callable[..., Any]


class Forger(Attack):
    """Draws nothing, though it says that it is random."""

    name: Literal["forger"] = "forger"

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (that is the fault)
        return mesh.with_vertices(2 * mesh.vertices)


@pytest.mark.parametrize(
    ("words", "checks"),
    [
        (("song2002", "grid=[40,40]", "region=[0,0,40,40]", "alpha=3.0"), SCHEME_CHECKS),
        (("gaussian-noise", "percent=2"), ATTACK_CHECKS),
    ],
)
def test_good_component_gets_a_line_for_each_promise_and_status_0(words, checks, wm3d: Run) -> None:
    outcome = wm3d("check-plugin", *words)
    *lines, last = outcome.stdout.splitlines()
    assert outcome.status == 0
    assert [line.split(":")[0] for line in lines] == [
        "ok   " + check.__name__.replace("_", "-") for check in checks
    ]
    assert last == f"{words[0]}: {len(checks)} of {len(checks)} checks passed"


def test_broken_promise_is_told_in_plain_words_with_status_1(
    wm3d: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wm3d.attacks.ATTACKS", Registry("attack", Attack, Forger))
    outcome = wm3d("check-plugin", "forger")
    failing = [line for line in outcome.stdout.splitlines() if line.startswith("FAIL ")]
    assert outcome.status == 1
    assert failing == [
        "FAIL random-says-whether-the-generator-matters: Another generator state gives another mesh where "
        "`random` is true, and the same where it is false. But two generator states gave one mesh; declare "
        "random: ClassVar[bool] = False."
    ]
    assert outcome.stdout.endswith(
        f"forger: {len(ATTACK_CHECKS) - 1} of {len(ATTACK_CHECKS)} checks passed\n"
    )


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("song2003",), "wm3d: unknown scheme or attack 'song2003'; did you mean 'song2002'?\n"),
        (
            ("xyz",),
            "wm3d: unknown scheme or attack 'xyz'; see `wm3d list schemes` and `wm3d list attacks`.\n",
        ),
        (
            ("simplify", "ratio=2"),
            "wm3d: attack simplify: ratio = 2: input should be less than or equal to 1.\n",
        ),
    ],
)
def test_bad_input_has_status_2(words, sentence, wm3d: Run) -> None:
    outcome = wm3d("check-plugin", *words)
    assert (outcome.status, outcome.stdout, outcome.stderr) == (2, "", sentence)
