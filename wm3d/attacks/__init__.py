"""Attacks: attack(mesh, rng) -> mesh, one file a family."""

from wm3d.attacks.base import Attack, Clean
from wm3d.attacks.noise import GaussianNoise
from wm3d.attacks.similarity import Similarity
from wm3d.attacks.simplification import Simplify
from wm3d.registry import Registry

ATTACKS: Registry[Attack] = Registry("attack", Attack, Clean, GaussianNoise, Similarity, Simplify)  # type: ignore[type-abstract]

__all__ = ["ATTACKS", "Attack", "Clean", "GaussianNoise", "Similarity", "Simplify"]
