"""Attacks with other marks of the same scheme: collusion of several copies, and marking twice."""

from collections.abc import Callable
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from wm3d.attacks.base import Attack, Owner
from wm3d.errors import Wm3dError
from wm3d.mesh import Mesh

SEEDS = 2**63
"""Keys of the other marks are drawn below this number."""


class MarkingAttack(Attack):
    """An attack by one who gets marks of other keys from the owner."""

    marks: ClassVar[bool] = True

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (one signature)
        """Refuse: without an owner there are no other marks; see `given`."""
        raise Wm3dError(f"{mesh.name}: {self.label()} needs the scheme that marked it; use it in `wm3d run`.")


class Collusion(MarkingAttack):
    """The mean of several copies, each with the mark of another key, the attacked mesh being one of them.

    Attributes
    ----------
    copies : int
        Number of copies, the attacked one included; 1 is no attack.
    """

    name: Literal["collusion"] = "collusion"
    legend: ClassVar[tuple[str, ...]] = ("copies",)
    neutral: ClassVar[dict[str, float]] = {"copies": 1}

    copies: Annotated[int, Field(ge=1)] = 2

    def given(self, owner: Owner) -> Callable[[Mesh, np.random.Generator], Mesh]:
        """Return the attack with copies of this owner's original."""

        def collude(mesh: Mesh, rng: np.random.Generator) -> Mesh:
            total = mesh.vertices.copy()
            for _ in range(self.copies - 1):
                copy = owner.mark(owner.original, int(rng.integers(SEEDS)))
                if not np.array_equal(copy.faces, mesh.faces):
                    raise Wm3dError(f"{mesh.name}: {self.label()} needs copies of the same connectivity.")
                total += copy.vertices
            return mesh.with_vertices(total / self.copies)

        return collude


class Remark(MarkingAttack):
    """The mesh marked again, with other keys."""

    name: Literal["remark"] = "remark"
    legend: ClassVar[tuple[str, ...]] = ("times",)
    neutral: ClassVar[dict[str, float]] = {"times": 0}

    times: Annotated[int, Field(ge=0)] = 1

    def given(self, owner: Owner) -> Callable[[Mesh, np.random.Generator], Mesh]:
        """Return the attack with marks by this owner's scheme."""

        def mark_again(mesh: Mesh, rng: np.random.Generator) -> Mesh:
            for _ in range(self.times):
                mesh = owner.mark(mesh, int(rng.integers(SEEDS)))
            return mesh

        return mark_again
