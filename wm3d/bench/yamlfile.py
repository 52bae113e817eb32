"""YAML 1.2 files as plain data that remembers the line of every value."""

import io
from collections.abc import Hashable
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, SequenceNode

from wm3d.errors import Wm3dError

Step = str | int
Path_ = tuple[Step, ...]


class Document:
    """The content of a YAML file.

    Attributes
    ----------
    path : str
        As the user named it.
    data : object
        Mappings, lists and scalars.
    faults : list of (int, str)
        What is wrong already in the YAML itself: line and sentence. Duplicate keys, for one.
    """

    def __init__(self, path: str, data: Any, lines: dict[Path_, int], faults: list[tuple[int, str]]) -> None:
        self.path, self.data, self.faults = path, data, faults
        self._lines, self._overridden = lines, dict[Path_, str]()

    def line(self, path: Path_) -> int:
        """Return the line, from 1, of the value at `path` or of the nearest value around it."""
        while path and path not in self._lines:
            path = path[:-1]
        return self._lines.get(path, 1)

    def where(self, path: Path_) -> str:
        """Return "line 12, attacks[1].percent" or, for an overridden value, the override."""
        for length in range(len(path), 0, -1):
            if path[:length] in self._overridden:
                return f"--set {self._overridden[path[:length]]}"
        return f"line {self.line(path)}" + (f", {dotted(path)}" if path else "")

    def override(self, assignment: str) -> None:
        """Set one value from ``path.to.field=value``; the value is YAML.

        Raises
        ------
        Wm3dError
            If the path leads through something that is neither a mapping nor a list.
        """
        target, separator, text = assignment.partition("=")
        if not separator or not target:
            raise Wm3dError(f"--set {assignment}: must have the form path.to.field=value.")
        path = tuple(int(step) if step.isdecimal() else step for step in target.split("."))
        inner = self.data
        for step in path[:-1]:
            inner = _step_into(inner, step, assignment)
        last = path[-1]
        if isinstance(inner, list):
            _step_into(inner, last, assignment)
            inner[last] = _parse(text, f"--set {assignment}")  # type: ignore[index]  # _step_into checked it
        elif isinstance(inner, dict):
            inner[last] = _parse(text, f"--set {assignment}")
        else:
            raise Wm3dError(f"--set {assignment}: {dotted(path[:-1])} holds a single value.")
        self._overridden[path] = assignment


def dotted(path: Path_) -> str:
    """Return a path as users write it: cases[0].schemes[1].alpha."""
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else str(step)
    return text


def read_yaml(path: str | Path) -> Document:
    """Read a YAML file.

    Raises
    ------
    Wm3dError
        If the file cannot be read, is not YAML, or does not hold a mapping.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise Wm3dError(f"{path}: cannot be read ({error.strerror}).") from None
    except UnicodeDecodeError:
        raise Wm3dError(f"{path}: is not a YAML file: it is not UTF-8 text.") from None
    reader = YAML(typ="safe", pure=True)
    try:
        root = reader.compose(text)
    except YAMLError as error:
        raise Wm3dError(f"{path}: {_yaml_fault(error)}") from None
    if not isinstance(root, MappingNode):
        raise Wm3dError(f"{path}: must hold a mapping of keys to values, such as 'trials: 100'.")
    lines: dict[Path_, int] = {}
    faults: list[tuple[int, str]] = []
    data = _build(root, (), reader, lines, faults)
    return Document(str(path), data, lines, faults)


def write_yaml(data: Any) -> str:
    """Return plain data as YAML, short lists on one line."""
    writer, stream = YAML(typ="safe", pure=True), io.StringIO()
    writer.default_flow_style = None
    writer.sort_base_mapping_type_on_output = False  # type: ignore[assignment]  # keeps the order of keys
    writer.dump(data, stream)
    return stream.getvalue()


def _build(
    node: Node, path: Path_, reader: YAML, lines: dict[Path_, int], faults: list[tuple[int, str]]
) -> Any:
    lines[path] = node.start_mark.line + 1
    if isinstance(node, SequenceNode):
        return [_build(item, (*path, i), reader, lines, faults) for i, item in enumerate(node.value)]
    if not isinstance(node, MappingNode):
        return reader.constructor.construct_object(node, deep=True)
    mapping: dict[Any, Any] = {}
    for key_node, value_node in node.value:
        key, line = reader.constructor.construct_object(key_node, deep=True), key_node.start_mark.line + 1
        if not isinstance(key, Hashable):
            faults.append((line, f"line {line}: a key must be a word, not a list or a mapping."))
            continue
        inner = (*path, key if isinstance(key, int) else str(key))
        if key in mapping:
            faults.append(
                (line, f"line {line}, {dotted(inner)}: stands twice (first on line {lines[inner]}).")
            )
            continue
        mapping[key] = _build(value_node, inner, reader, lines, faults)
        lines[inner] = line
    return mapping


def _parse(text: str, where: str) -> Any:
    try:
        return YAML(typ="safe", pure=True).load(text)
    except YAMLError as error:
        raise Wm3dError(f"{where}: {_yaml_fault(error)}") from None


def _yaml_fault(error: YAMLError) -> str:
    problem, mark = "cannot be parsed", None
    if isinstance(error, MarkedYAMLError):
        problem, mark = error.problem or problem, error.problem_mark or error.context_mark
    return (f"line {mark.line + 1}: " if mark else "") + f"is not valid YAML: {problem}."


def _step_into(inner: Any, step: Step, assignment: str) -> Any:
    if isinstance(inner, dict) and step in inner:
        return inner[step]
    if isinstance(inner, list) and isinstance(step, int) and step < len(inner):
        return inner[step]
    size = f"a list of {len(inner)}" if isinstance(inner, list) else "this config"
    raise Wm3dError(f"--set {assignment}: there is no {step!r} in {size}; indices count from 0.")
