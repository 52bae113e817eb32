"""Readings: parameters with named alternatives, and their meaning from the docstrings of the components."""

import inspect
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

from wm3d.component import Component


@dataclass(frozen=True)
class Reading:
    """One choice that a run made where the source leaves it open.

    Attributes
    ----------
    owner : str
        Name of the component.
    parameter : str
    meaning : str
        What the docstring of the component says of it.
    choices : tuple of str
        The named alternatives; a value that is a number is not among them.
    used : tuple of str
        What the run used, in the order of its config.
    """

    owner: str
    parameter: str
    meaning: str
    choices: tuple[str, ...]
    used: tuple[str, ...]


def readings(components: Iterable[Component]) -> list[Reading]:
    """Return the readings of components and of the components inside them, each parameter once."""
    found: dict[tuple[type[Component], str], dict[str, None]] = {}
    for component in components:
        for owner, parameter in _open_parameters(component):
            used = found.setdefault((type(owner), parameter), {})
            used[str(getattr(owner, parameter))] = None
    return [
        Reading(
            owner=cls.model_fields["name"].default,
            parameter=parameter,
            meaning=documented(cls, parameter),
            choices=_alternatives(cls.model_fields[parameter].annotation),
            used=tuple(used),
        )
        for (cls, parameter), used in found.items()
    ]


def _open_parameters(component: Component) -> Iterator[tuple[Component, str]]:
    for parameter, field in type(component).model_fields.items():
        value = getattr(component, parameter)
        inside = [value] if isinstance(value, Component) else value if isinstance(value, tuple) else []
        if parts := [part for part in inside if isinstance(part, Component)]:
            for part in parts:
                yield from _open_parameters(part)
        elif parameter != "name" and _alternatives(field.annotation):
            yield component, parameter


def _alternatives(annotation: Any) -> tuple[str, ...]:
    """Return the strings that a type allows by name."""
    if get_origin(annotation) is Literal:
        return tuple(map(str, get_args(annotation)))
    return tuple(name for part in get_args(annotation) for name in _alternatives(part))


def documented(cls: type[Component], parameter: str) -> str:
    """Return what the numpydoc section "Attributes" of a component or its bases says of a parameter.

    Returns
    -------
    str
        One paragraph; empty where nothing is said.
    """
    for base in cls.__mro__:
        _, _, section = inspect.cleandoc(base.__dict__.get("__doc__") or "").partition("Attributes\n---")
        for entry in re.split(r"\n(?=\S)", section):
            head, _, text = entry.partition("\n")
            if parameter in head.partition(" : ")[0].split(", "):
                return " ".join(text.split())
    return ""
