"""YAML 1.2 files as plain data that remembers the line of every value."""

import io
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.constructor import ConstructorError
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from wm3d.errors import LONGEST, Wm3dError, shortened, shown

Step = str | int
Path_ = tuple[Step, ...]

DEEPEST = 100
"""Lists and mappings inside each other at most; the reader of JSON behind a config takes 200."""


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
        assignment = shortened(assignment)
        if not separator or not target:
            raise Wm3dError(f"--set {assignment}: must have the form path.to.field=value.")
        path = tuple(
            int(step) if step.isdecimal() and len(step) < LONGEST else step for step in target.split(".")
        )
        inner = self.data
        for depth in range(len(path) - 1):
            inner = _step_into(inner, path, depth, assignment)
        if isinstance(inner, list):
            _step_into(inner, path, len(path) - 1, assignment)
        elif not isinstance(inner, dict):
            raise Wm3dError(f"--set {assignment}: {dotted(path[:-1])} holds a single value.")
        inner[path[-1]] = parse_value(text, f"--set {assignment}")
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
    builder = _Builder()
    data = builder.read(text, str(path))
    if not isinstance(data, dict):
        raise Wm3dError(f"{path}: must hold a mapping of keys to values, such as 'trials: 100'.")
    return Document(str(path), data, builder.lines, builder.faults)


def parse_value(text: str, where: str) -> Any:
    """Return the plain data of one value, as on a command line.

    Raises
    ------
    Wm3dError
        If the text is not YAML, or a file would be refused for it; it begins with `where`.
    """
    builder = _Builder()
    data = builder.read(text, where)
    for _, sentence in builder.faults:
        raise Wm3dError(f"{where}: {sentence}")
    return data


def write_yaml(data: Any) -> str:
    """Return plain data as YAML, short lists on one line."""
    writer, stream = YAML(typ="safe", pure=True), io.StringIO()
    writer.default_flow_style = None
    writer.sort_base_mapping_type_on_output = False  # type: ignore[assignment]  # keeps the order of keys
    writer.dump(data, stream)
    return stream.getvalue()


class _Builder:
    """Makes plain data of YAML nodes; notes lines, and faults that leave the rest readable."""

    def __init__(self) -> None:
        self.reader = YAML(typ="safe", pure=True)
        self.lines: dict[Path_, int] = {}
        self.faults: list[tuple[int, str]] = []
        self._around: list[Node] = []

    def read(self, text: str, where: str) -> Any:
        """Return the data of a text; raise a `Wm3dError` that begins with `where` if it is not YAML."""
        try:
            root = self.reader.compose(text)
            return None if root is None else self.build(root, ())
        except YAMLError as error:
            raise Wm3dError(f"{where}: {_yaml_fault(error)}") from None
        except (KeyError, AssertionError):  # what ruamel says to versions that it does not know
            raise Wm3dError(f"{where}: is not valid YAML: it asks for a version that there is not.") from None
        except RecursionError:
            raise Wm3dError(f"{where}: is nested too deeply.") from None

    def build(self, node: Node, path: Path_) -> Any:
        line = node.start_mark.line + 1
        self.lines[path] = line
        if len(path) > DEEPEST:
            raise RecursionError
        if node in self._around:
            self._fault(line, path, "stands for itself, by an alias inside its anchor")
            return None
        self._around.append(node)
        try:
            if isinstance(node, SequenceNode):
                return [self.build(item, (*path, i)) for i, item in enumerate(node.value)]
            if isinstance(node, MappingNode):
                return self._mapping(node, path)
            return self._scalar(node)
        finally:
            self._around.pop()

    def _mapping(self, node: MappingNode, path: Path_) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        for key_node, value_node in node.value:
            line = key_node.start_mark.line + 1
            key = key_node.value
            if not isinstance(key_node, ScalarNode) or not isinstance(self._scalar(key_node), str):
                shown = f" {key}" if isinstance(key, str) else ""
                self._fault(line, path, f"the key{shown} must be a word")
            elif key in mapping:
                self._fault(line, (*path, key), f"stands twice (first on line {self.lines[(*path, key)]})")
            else:
                mapping[key] = self.build(value_node, (*path, key))
                self.lines[(*path, key)] = line
        return mapping

    def _scalar(self, node: Node) -> Any:
        try:
            value = self.reader.constructor.construct_object(node, deep=True)
            str(value)  # Python writes no integer of thousands of digits, nor reads one
        except YAMLError:
            raise
        except Exception:  # forms that stand for nothing, as the 45th of a month, fail in every way there is
            kind = str(node.tag).rpartition(":")[2]
            problem = f"{shown(node.value)} is no {kind}, quote it if it is text"
            raise ConstructorError(problem=problem, problem_mark=node.start_mark) from None
        return value

    def _fault(self, line: int, path: Path_, sentence: str) -> None:
        self.faults.append((line, f"line {line}{', ' if path else ''}{dotted(path)}: {sentence}."))


def _yaml_fault(error: YAMLError) -> str:
    problem, mark = "cannot be parsed", None
    if isinstance(error, MarkedYAMLError):
        problem, mark = error.problem or problem, error.problem_mark or error.context_mark
        if problem.startswith("but "):
            problem = f"{error.context}, {problem}"
    return (f"line {mark.line + 1}: " if mark else "") + f"is not valid YAML: {problem}."


def _step_into(inner: Any, path: Path_, depth: int, assignment: str) -> Any:
    """Return what step `depth` of a path leads to."""
    step = path[depth]
    if isinstance(inner, dict) and step in inner:
        return inner[step]
    if isinstance(inner, list) and isinstance(step, int) and step < len(inner):
        return inner[step]
    where = dotted(path[:depth]) or "this config"
    size = f", a list of {len(inner)}; indices count from 0" if isinstance(inner, list) else ""
    raise Wm3dError(f"--set {assignment}: there is no {shown(step)} in {where}{size}.")
