"""Suites: published and usual lists of attacks, a YAML file each, that a config names under `suites`.

The files lie in the package and not in ``configs/``, so that an installed wheel has them.
"""

from functools import cache
from pathlib import Path

from wm3d.attacks import ATTACKS, Attack
from wm3d.bench.yamlfile import read_yaml
from wm3d.errors import Wm3dError, hint, shown

FOLDER = Path(__file__).parent


def suite_names() -> list[str]:
    """Return the names of all suites."""
    return sorted(file.stem for file in FOLDER.glob("*.yaml"))


@cache
def load_suite(name: str) -> tuple[Attack, ...]:
    """Return the attacks of a suite.

    Raises
    ------
    Wm3dError
        If there is no such suite, or its file is damaged.
    """
    if name not in suite_names():
        raise Wm3dError(f"there is no suite {shown(name)}; {hint(name, suite_names())}")
    document = read_yaml(FOLDER / f"{name}.yaml")
    if document.faults:
        raise Wm3dError(f"{document.path}: {document.faults[0][1]}")
    return tuple(ATTACKS.build(attack["name"], attack) for attack in document.data["attacks"])
