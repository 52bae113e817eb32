"""Registries: built-in components, those of installed packages, and what they say to a wrong name."""

import re
from abc import ABC, abstractmethod
from importlib.metadata import EntryPoint
from typing import Annotated, Literal

import pytest
from pydantic import Field

from wm3d.component import Component
from wm3d.errors import Wm3dError, hint
from wm3d.registry import Registry


class Paint(Component):
    """Base of the paints."""


class Red(Paint):
    name: Literal["red"] = "red"
    shade: Annotated[float, Field(ge=0, le=1)] = 0.5
    coats: int = 1


class Blue(Paint):
    name: Literal["blue"] = "blue"


class Crimson(Paint):
    name: Literal["red"] = "red"


class Scarlet(Red):
    pass


class Nameless(Paint):
    shade: float = 1.0


class Unset(Paint):
    name: Literal["unset"]


class Coated(Paint, ABC):
    name: Literal["coated"] = "coated"

    @abstractmethod
    def coat(self) -> None: ...


@pytest.fixture
def plugins(monkeypatch):
    """List of (entry point name, object reference) that stand for installed packages."""
    listed: list[tuple[str, str]] = []

    def entry_points(group: str) -> list[EntryPoint]:
        return [EntryPoint(name, value, group) for name, value in listed] if group == "wm3d.paints" else []

    monkeypatch.setattr("wm3d.registry.entry_points", entry_points)
    return listed


def paints() -> Registry[Paint]:
    return Registry("paint", Paint, Red)


def test_builtin_components_are_built_by_name():
    registry = paints()
    assert list(registry) == ["red"]
    assert len(registry) == 1
    assert "red" in registry
    assert registry["red"] is Red
    assert registry.build("red", {"shade": 0.25}) == Red(shade=0.25)


class Wall(Component):
    name: Literal["wall"] = "wall"
    paint: Red = Red()


def test_a_component_as_a_parameter_may_be_a_bare_name():
    walls = Registry("wall", Component, Wall)
    assert walls.build("wall", {"paint": "red"}) == Wall()
    with pytest.raises(Wm3dError, match=r"^wall wall: paint"):
        walls.build("wall", {"paint": "green"})


def test_installed_packages_add_theirs(plugins):
    plugins.append(("anything", f"{__name__}:Blue"))
    assert paints().build("blue", {}) == Blue()


def test_unknown_name_is_answered_with_the_nearest_or_all():
    with pytest.raises(Wm3dError, match=r"^unknown paint 'rde'; did you mean 'red'\?$"):
        paints()["rde"]
    with pytest.raises(Wm3dError, match=r"^unknown paint 'green'; known: red\.$"):
        paints()["green"]


def test_a_part_of_names_is_answered_with_these_names():
    known = ["clean", "gaussian-noise", "uniform-noise", "crop"]
    assert hint("noise", known) == "did you mean 'gaussian-noise' or 'uniform-noise'?"
    assert hint("", known) == "known: clean, gaussian-noise, uniform-noise, crop."


def test_all_wrong_parameters_stand_in_one_sentence():
    with pytest.raises(Wm3dError) as refusal:
        paints().build("red", {"shade": 7, "coats": "many", "shaed": 1})
    sentence = str(refusal.value)
    assert sentence.startswith("paint red: ")
    assert "shade = 7: input should be less than or equal to 1" in sentence
    assert "coats = 'many': " in sentence
    assert "unknown parameter 'shaed', did you mean 'shade'?" in sentence
    assert "\n" not in sentence


@pytest.mark.parametrize("field", ["shade", "coats"])
def test_true_is_no_number(field):
    with pytest.raises(Wm3dError, match=rf"^paint red: {field} = True: must be a number\.$"):
        paints().build("red", {field: True})


def test_of_a_long_value_the_ends_are_told_and_of_a_missing_one_no_value():
    class Deep(Paint):
        name: Literal["deep"] = "deep"
        layers: tuple[Red, int]

    with pytest.raises(Wm3dError) as refusal:
        Registry("paint", Paint, Deep).build("deep", {"layers": [{"coats": "many " * 9999}]})
    sentence = str(refusal.value)
    assert "layers.0.coats = 'many many" in sentence
    assert sentence.endswith("; layers.1 is missing.")
    assert len(sentence) < 250
    with pytest.raises(Wm3dError, match=r"layers = 'many': input should be a list\.$"):
        Registry("paint", Paint, Deep).build("deep", {"layers": "many"})


def test_a_list_as_a_parameter_is_refused_before_anything_runs():
    class Mixed(Paint):
        name: Literal["mixed"] = "mixed"
        shares: list[float]

    with pytest.raises(Wm3dError, match=r"^paint mixed: cannot be hashed .*; let its parameters be tuples"):
        Registry("paint", Paint, Mixed).build("mixed", {"shares": [1.0]})


def test_the_name_is_no_parameter_that_can_be_another():
    with pytest.raises(Wm3dError, match=r"^paint red: name = 'blue': input should be 'red'\.$"):
        paints().build("red", {"name": "blue"})


@pytest.mark.parametrize(
    ("target", "sentence"),
    [
        ("Crimson", "the paint name 'red' is taken; .*:Crimson must use another"),
        ("Registry", "the entry point .*:Registry is not a paint: it must derive from .*Paint"),
        ("Scarlet", "the paint .*:Scarlet has the name 'red' of Red, from which it derives; give it its own"),
        ("Nameless", "the paint .*:Nameless has no name; declare name"),
        ("Unset", "the paint .*:Unset has no name; declare name"),
        ("Coated", "the paint .*:Coated is abstract, it lacks coat; name a class that has all"),
        ("plugins", "the entry point .*:plugins is not a paint"),
        (
            "Nothing",
            "the paint .*:Nothing of the package that declares it cannot be loaded .*; mend or uninstall",
        ),
    ],
)
def test_a_plugin_that_does_not_fit_is_named(plugins, caplog, target, sentence):
    plugins.append(("plugin", f"{__name__}:{target}"))
    with pytest.raises(Wm3dError, match=rf"^unknown paint 'wanted'; .* {sentence}"):
        paints()["wanted"]
    assert re.search(sentence, caplog.text)


def test_a_plugin_that_cannot_be_imported_takes_no_other_along(plugins, caplog):
    plugins.extend([("broken", "no_such_package.module:Paint"), ("sound", f"{__name__}:Blue")])
    registry = paints()
    assert list(registry) == ["red", "blue"]
    assert re.search(r"the paint no_such_package\.module:Paint of .* cannot be loaded", caplog.text)
