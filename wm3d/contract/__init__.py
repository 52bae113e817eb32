"""The contract of attacks and schemes, as checks that a plug-in author runs: `wm3d check-plugin`."""

from wm3d.contract.attacks import ATTACK_CHECKS
from wm3d.contract.check import Broken, Outcome, examine
from wm3d.contract.schemes import SCHEME_CHECKS

__all__ = ["ATTACK_CHECKS", "SCHEME_CHECKS", "Broken", "Outcome", "examine"]
