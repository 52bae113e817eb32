"""Checks of what attacks and schemes have in common: a frozen value with a name and a label."""

import json
import re
from collections.abc import Mapping

from pydantic import ValidationError

from wm3d.component import Component
from wm3d.contract.check import Broken
from wm3d.errors import Wm3dError


def check_name(component: Component) -> None:
    """Refuse a name that configs and commands cannot hold, and one that can be changed."""
    field = type(component).model_fields.get("name")
    if field is None or not isinstance(field.default, str):
        raise Broken('it has no name; declare name: Literal["its-name"] = "its-name".')
    if not re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", field.default):
        raise Broken(f"its name {field.default!r} is not of lower-case letters, digits and single hyphens.")
    try:
        type(component).model_validate({**component.model_dump(mode="json"), "name": "another-name"})
    except ValidationError:
        return
    raise Broken(f'its name can be another; declare name: Literal["{field.default}"].')


def check_parameters(component: Component) -> None:
    """Refuse parameters that change on their way through JSON or after they were set."""
    written = component.model_dump_json()
    rebuilt = type(component).model_validate(json.loads(written))
    if rebuilt != component:
        raise Broken(f"{written} is read back as {rebuilt.model_dump_json()}.")
    if hash(rebuilt) != hash(component):
        raise Broken("equal values have unequal hashes; let the fields be hashable: tuples, not lists.")
    for field in type(component).model_fields:
        try:
            setattr(component, field, getattr(component, field))
        except ValidationError:
            continue
        raise Broken(f"its parameter {field} can be set anew; leave the model frozen.")


def check_engines(component: Component) -> None:
    """Refuse engines whose release cannot be told: a run is stored under it."""
    try:
        component.engine_versions()
    except Wm3dError as error:
        raise Broken(str(error)) from None


def check_label(component: Component, registry: Mapping[str, type[Component]]) -> None:
    """Refuse a label that another component has too: tables put together what has the same label."""
    label = component.label()
    if not label or "\n" in label:
        raise Broken(f"its label is {label!r}, not one line of text.")
    for name, cls in registry.items():
        if cls is not type(component) and _default_label(cls) == label:
            raise Broken(f"its label {label!r} is also that of {name}.")


def _default_label(cls: type[Component]) -> str | None:
    try:
        return cls().label()
    except ValidationError:  # it has parameters without a default
        return None
