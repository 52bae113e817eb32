"""Components: frozen, named bags of parameters that can be called (attacks, schemes, poses, detectors)."""

from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, model_validator
from pydantic.fields import FieldInfo

from wm3d.errors import Wm3dError


class Component(BaseModel):
    """A frozen value whose fields are its parameters.

    Every concrete component declares ``name: Literal["its-name"] = "its-name"``. The fields, with the name,
    are its identity: the same words appear in the config, in the digest of a cell, in the row and in the
    legend of a figure.

    Attributes
    ----------
    version : int
        Raised by hand when the same parameters start to give other numbers.
    legend : tuple of str
        Parameters that a legend always shows, by their bare values.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    version: ClassVar[int] = 1
    legend: ClassVar[tuple[str, ...]] = ()

    @model_validator(mode="after")
    def _hashable(self) -> Self:
        try:
            hash(self)
        except TypeError as error:
            raise ValueError(f"cannot be hashed ({error}); let its parameters be tuples, not lists") from None
        return self

    @classmethod
    def settable(cls) -> dict[str, FieldInfo]:
        """Return the parameters but those that `embed` finds out, which a label does not tell either."""
        return {name: field for name, field in cls.model_fields.items() if name != "name" and field.repr}

    @property
    def engines(self) -> tuple[str, ...]:
        """Distributions, named as on PyPI, whose release may change the numbers of this component."""
        return ()

    def engine_versions(self) -> dict[str, str]:
        """Return the installed version of each engine.

        Raises
        ------
        Wm3dError
            If one is not installed.
        """
        return {engine: self._version(engine) for engine in self.engines}

    def _version(self, engine: str) -> str:
        try:
            return version(engine)
        except (PackageNotFoundError, ValueError):  # ValueError: an empty name
            raise Wm3dError(
                f"{self.label()}: its engine {engine!r} is not installed; install that distribution."
            ) from None

    def parameters(self) -> dict[str, Any]:
        """Return the parameters without the name, as plain JSON values."""
        dump = self.model_dump(mode="json")
        dump.pop("name", None)
        return dump

    def components(self) -> Iterator["Component"]:
        """Yield this component and, at any depth, those among its parameters."""
        yield self
        for _, value in self:
            if _is_made_of_components(value):
                for part in value if isinstance(value, tuple) else (value,):
                    yield from part.components()

    def identity(self) -> dict[str, Any]:
        """Return what the numbers of this component depend on, as plain JSON values.

        That is its parameters and its version, and those of the components among its parameters.
        """
        parts = {name: _identity(value) for name, value in self if _is_made_of_components(value)}
        return {**self.model_dump(mode="json"), **parts, "version": self.version}

    def label(self) -> str:
        """Return the legend text: the name, the values of `legend`, and what differs from its default."""
        fields = type(self).model_fields
        words = [str(fields["name"].default) if "name" in fields else type(self).__name__]
        for key in self.parameters():
            value = getattr(self, key)
            if key in self.legend:
                words.append(_short(value))
            elif value != fields[key].default:
                words.append(f"{key}={_short(value)}")
        return " ".join(words)


def _is_made_of_components(value: Any) -> bool:
    parts = value if isinstance(value, tuple) else (value,)
    return bool(parts) and all(isinstance(part, Component) for part in parts)


def _identity(value: Any) -> Any:
    return [part.identity() for part in value] if isinstance(value, tuple) else value.identity()


def _short(value: Any) -> str:
    """Write a value so that unlike values read unlike: tables put together what has the same label."""
    if isinstance(value, float):
        short = f"{value:g}"
        return short if float(short) == value else repr(value)
    if isinstance(value, Component):
        label = value.label()
        return f"({label})" if " " in label else label
    if isinstance(value, tuple | list):
        return ("×" if len(value) == 2 else ",").join(_short(item) for item in value)
    return str(value)
