"""Chains: several attacks, one after the other."""

from collections.abc import Callable, Sequence
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import ConfigDict

from wm3d.attacks.base import Attack, Owner
from wm3d.attacks.links import LINKS
from wm3d.mesh import Mesh
from wm3d.registry import OneOf


class Chain(Attack):
    """Attacks one after the other, each on what the one before it left.

    Attributes
    ----------
    then : tuple of Attack
        Any attacks but chains; none is no attack.
    """

    # the registry is read when the first chain is made: entry points may import this package
    model_config = ConfigDict(defer_build=True)

    name: Literal["chain"] = "chain"
    neutral: ClassVar[dict[str, float]] = {}

    then: tuple[Annotated[Attack, OneOf(LINKS)], ...] = ()

    @property
    def random(self) -> bool:  # type: ignore[override]  # of every other attack a constant of its class
        """Whether a link is random."""
        return any(link.random for link in self.then)

    @property
    def turns(self) -> bool:  # type: ignore[override]
        """Whether a link turns the model."""
        return any(link.turns for link in self.then)

    @property
    def marks(self) -> bool:  # type: ignore[override]
        """Whether a link needs other marks."""
        return any(link.marks for link in self.then)

    @property
    def engines(self) -> tuple[str, ...]:
        """The packages behind the links."""
        return tuple(dict.fromkeys(engine for link in self.then for engine in link.engines))

    def label(self) -> str:
        """Return the labels of the links, with arrows between them; a lone link is not taken for itself."""
        links = [link.label() for link in self.then]
        return " → ".join(links) if len(links) > 1 else " ".join(["chain", *links])

    def __call__(self, mesh: Mesh, rng: np.random.Generator) -> Mesh:
        """Return the mesh after all links; see `Attack`."""
        return _run(self.then, mesh, rng)

    def given(self, owner: Owner) -> Callable[[Mesh, np.random.Generator], Mesh]:
        """Return the chain whose links are given this owner."""
        links = [link.given(owner) for link in self.then]
        return lambda mesh, rng: _run(links, mesh, rng)


def _run(
    links: Sequence[Callable[[Mesh, np.random.Generator], Mesh]], mesh: Mesh, rng: np.random.Generator
) -> Mesh:
    for link in links:
        mesh = link(mesh, rng)
    return mesh
