"""Registries: components by name, the built-in ones and those that installed packages add by entry points."""

import logging
from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from pydantic import GetCoreSchemaHandler, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from wm3d.component import Component
from wm3d.errors import Wm3dError, hint, shown

T = TypeVar("T", bound=Component)


class Registry(Mapping[str, type[T]], Generic[T]):
    """Component classes by the name that configs, keys and the command line use.

    Parameters
    ----------
    kind : str
        What the components are, in the singular, for messages: "attack".
    base : type
        The class that every component must derive from.
    builtin : type
        The components of wm3d itself.

    Notes
    -----
    A package adds its own by the entry point group ``wm3d.attacks``, ``wm3d.schemes`` or ``wm3d.imagemarks``
    (the kind and an s); entry points are read when the registry is first used. One that cannot be used is
    logged, and told to who asks for an unknown name; the others are there.
    """

    def __init__(self, kind: str, base: type[T], *builtin: type[T]) -> None:
        self.kind, self._base, self._builtin = kind, base, builtin
        self._faults: list[str] = []

    @cached_property
    def _classes(self) -> dict[str, type[T]]:
        classes = {component_name(cls): cls for cls in self._builtin}
        for point in sorted(entry_points(group=f"wm3d.{self.kind}s"), key=lambda point: point.name):
            try:
                cls = self._loaded(point)
                if classes.setdefault(component_name(cls), cls) is not cls:
                    name = component_name(cls)
                    raise Wm3dError(
                        f"the {self.kind} name {name!r} is taken; {point.value} must use another."
                    )
            except Wm3dError as fault:  # who does not ask for it can do without it
                logging.getLogger(__name__).warning("wm3d: %s", fault)
                self._faults.append(str(fault))
        return classes

    def _loaded(self, point: EntryPoint) -> type[T]:
        try:
            cls: type[T] = point.load()
        except (Exception, SystemExit) as error:  # whatever foreign code may do when it is imported
            raise Wm3dError(
                f"the {self.kind} {point.value} of the package {_package(point)} cannot be loaded "
                f"({error}); mend or uninstall that package."
            ) from error
        if not (isinstance(cls, type) and issubclass(cls, self._base)):
            raise Wm3dError(
                f"the entry point {point.value} is not a {self.kind}: it must derive from "
                f"{self._base.__module__}.{self._base.__name__}."
            )
        if not isinstance(getattr(cls.model_fields.get("name"), "default", None), str):
            raise Wm3dError(
                f'the {self.kind} {point.value} has no name; declare name: Literal["its-name"] = "its-name".'
            )
        if missing := getattr(cls, "__abstractmethods__", None):
            raise Wm3dError(
                f"the {self.kind} {point.value} is abstract, it lacks {', '.join(sorted(missing))}; "
                "name a class that has all, or leave out the entry point."
            )
        if heir_of := [base.__name__ for base in cls.__bases__ if _shares_name(cls, base)]:
            raise Wm3dError(
                f"the {self.kind} {point.value} has the name {component_name(cls)!r} of {heir_of[0]}, from "
                'which it derives; give it its own, name: Literal["its-name"] = "its-name".'
            )
        return cls

    def __getitem__(self, name: str) -> type[T]:
        if name not in self._classes:
            meant = hint(name, self._classes)
            raise Wm3dError(" ".join([f"unknown {self.kind} {shown(name)}; {meant}", *self._faults]))
        return self._classes[name]

    def __contains__(self, name: object) -> bool:
        return name in self._classes

    def __iter__(self) -> Iterator[str]:
        return iter(self._classes)

    def __len__(self) -> int:
        return len(self._classes)

    def build(self, name: str, parameters: Mapping[str, Any]) -> T:
        """Return a component from its name and parameters; a parameter that is one too may be a bare name.

        Raises
        ------
        Wm3dError
            If the name is unknown or a parameter wrong; all wrong parameters are named in one sentence.
        """
        cls = self[name]
        for field, value in parameters.items():
            if isinstance(value, bool) and _is_a_number(cls.model_fields.get(field)):
                raise Wm3dError(f"{self.kind} {name}: {field} = {value}: must be a number.")
        given = {field: _named(value, cls.model_fields.get(field)) for field, value in parameters.items()}
        try:
            return cls.model_validate({"name": name, **given})
        except ValidationError as error:
            faults = describe(error, cls)
            raise Wm3dError(f"{self.kind} {name}: {faults}" + "." * (not faults.endswith("?"))) from None


def _is_a_number(field: FieldInfo | None) -> bool:
    """Tell whether a field would take true and false for 1 and 0, which nobody means."""
    return field is not None and field.annotation in (int, float)


def _named(value: Any, field: FieldInfo | None) -> Any:
    """Return the component that a bare name means, as data, where a field holds one."""
    bare = isinstance(value, str) and field is not None and isinstance(field.default, Component)
    return {"name": value} if bare else value


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist else "that declares it"


class OneOf:
    """Pydantic annotation of a field: one registered component, told apart by its `name`.

    Parameters
    ----------
    registry : Registry
        Read when the model that has the field is built.
    """

    def __init__(self, registry: Registry[Any]) -> None:
        self.registry = registry

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        choices = {name: handler.generate_schema(cls) for name, cls in self.registry.items()}
        return core_schema.tagged_union_schema(choices, discriminator="name")


def component_name(cls: type[Component]) -> str:
    """Return the name under which a component class is known: the default of its field `name`."""
    return str(cls.model_fields["name"].default)


def _shares_name(cls: type[Component], base: type) -> bool:
    return (
        issubclass(base, Component)
        and "name" in base.model_fields
        and component_name(base) == component_name(cls)
    )


def describe(error: ValidationError, cls: type[Component]) -> str:
    """Put all faults of a validation into one clause: parameter, value, what is wanted, "did you mean"."""
    return "; ".join(dict.fromkeys(_describe_one(fault, cls) for fault in error.errors()))


def _describe_one(fault: Any, cls: type[Component]) -> str:
    path = ".".join(str(part) for part in fault["loc"])
    if fault["type"] == "extra_forbidden" and len(fault["loc"]) > 1:  # of a component inside this one
        return f"unknown parameter {shown(path)}"
    if fault["type"] == "extra_forbidden":
        known = list(cls.settable())
        return f"unknown parameter {shown(path)}, {hint(path, known).rstrip('.')}"
    if fault["type"] == "missing":
        return f"{path} is missing"
    if fault["type"] == "union_tag_invalid":
        tag, known = shown(fault["ctx"]["tag"]), fault["ctx"]["expected_tags"]
        return f"{path} has the unknown name {tag}, known: {known}"
    message = fault["msg"].removeprefix("Value error, ").replace("a valid tuple", "a list")
    message = message[:1].lower() + message[1:]
    return f"{path} = {shown(fault['input'])}: {message}" if path else message
