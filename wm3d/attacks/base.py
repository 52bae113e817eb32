"""What every attack is: a frozen value that turns a mesh and a random generator into a mesh."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from wm3d.component import Component
from wm3d.mesh import Mesh


@dataclass(frozen=True)
class Owner:
    """What the owner of a mark has and an attacker may get copies from.

    Attributes
    ----------
    original : Mesh
        The mesh before it was marked.
    mark : callable
        ``mark(mesh, seed)`` returns the mesh with the mark of another key, by the scheme under test.
    """

    original: Mesh
    mark: Callable[[Mesh, int], Mesh]


class Attack(Component, ABC):
    """A distortion of a mesh.

    Calling it draws all randomness from the generator that is passed in; the same generator state gives the
    same mesh. The input is never changed.

    Attributes
    ----------
    random : bool
        False where the result does not depend on the generator.
    turns : bool
        True where the attack rotates the whole model, so axes can be compared only after turning it back.
    marks : bool
        True where the attack needs marks of other keys, so it works only as `given` an owner.
    neutral : dict, optional
        Parameters that, with the defaults of the others, make it no attack; None where none do.
    """

    random: ClassVar[bool] = True
    turns: ClassVar[bool] = False
    marks: ClassVar[bool] = False
    neutral: ClassVar[dict[str, float] | None] = None

    @abstractmethod
    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the attacked mesh.

        Raises
        ------
        Wm3dError
            If the mesh cannot be attacked this way.
        """

    def given(self, owner: Owner) -> Callable[[Mesh, np.random.Generator], Mesh]:  # noqa: ARG002 (for `marks`)
        """Return the attack of one who gets marks from this owner; for most the attack itself."""
        return self


class Clean(Attack):
    """No attack: the mesh as it is."""

    name: Literal["clean"] = "clean"
    random: ClassVar[bool] = False
    neutral: ClassVar[dict[str, float]] = {}

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:  # noqa: ARG002 (one signature)
        """Return the mesh itself."""
        return mesh
