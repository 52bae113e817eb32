"""Pydantic's validation errors as sentences with line, path and "did you mean"."""

from collections.abc import Mapping
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from wm3d.bench.yamlfile import Document, Step
from wm3d.component import Component
from wm3d.errors import hint, shown


def describe_faults(
    error: ValidationError,
    document: Document,
    root: type[BaseModel],
    components: Mapping[str, type[Component]],
) -> list[tuple[int, str]]:
    """Return (line, sentence) for every fault that pydantic found in a document.

    Parameters
    ----------
    error : ValidationError
    document : Document
        What was validated.
    root : type of BaseModel
        The model it was validated against.
    components : mapping of str to type of Component
        All components by name, to suggest parameter names.
    """
    sentences: dict[tuple[Step, ...], list[str]] = {}
    for fault in error.errors():
        if fault["type"] == "too_short" and len(fault["input"]) >= fault["ctx"]["min_length"]:
            continue  # a list is empty only because its items have faults of their own
        path, model = _locate(fault["loc"], document.data, root, components)
        sentence = _sentence(fault, path, model)
        if sentence not in sentences.setdefault(path, []):
            sentences[path].append(sentence)
    return [
        (document.line(path), f"{document.where(path)}: {_joined(alternatives)}")
        for path, alternatives in sentences.items()
    ]


def _joined(alternatives: list[str]) -> str:
    """Make one sentence of what each member of a union of types has to say."""
    heads = {alternative.partition(" must be ")[0] for alternative in alternatives}
    if len(heads) == 1 and all(" must be " in alternative for alternative in alternatives):
        wanted = [alternative.partition(" must be ")[2] for alternative in alternatives]
        alternatives = [f"{heads.pop()} must be {' or '.join(wanted)}"]
    text = "; or ".join(alternatives)
    return text if text.endswith(("?", ".")) else f"{text}."


def _locate(
    location: tuple[Step, ...], data: Any, root: type[BaseModel], components: Mapping[str, type[Component]]
) -> tuple[tuple[Step, ...], type[BaseModel]]:
    """Split pydantic's location into a path in the data and the model that the last step belongs to.

    Pydantic inserts the chosen member of a union into the location; such a step is not in the data.
    """
    path: list[Step] = []
    model: type[BaseModel] = root
    inner = data
    for position, step in enumerate(location):
        last = position == len(location) - 1
        if isinstance(inner, list) and isinstance(step, int):
            path.append(step)
            inner = inner[step] if step < len(inner) else None
        elif isinstance(inner, dict):
            if step not in inner and (not last or inner.get("name") == step):
                model = components.get(str(step), model)
                continue
            path.append(step)
            if not last:
                model = _model_of_field(model, str(step))
            inner = inner.get(step)
        # else: a member of a union of plain types
    return tuple(path), model


def _model_of_field(model: type[BaseModel], field: str) -> type[BaseModel]:
    """Return the model that a field holds, also inside a tuple; the model itself if it holds none."""
    if field not in model.model_fields:
        return model
    pending = [model.model_fields[field].annotation]
    while pending:
        annotation = pending.pop()
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            return annotation
        pending.extend(get_args(annotation))
    return model


def _sentence(fault: Any, path: tuple[Step, ...], model: type[BaseModel]) -> str:
    kind, context = fault["type"], fault.get("ctx", {})
    if kind == "extra_forbidden":
        return "unknown key" + _suggest(str(path[-1]), list(model.model_fields))
    if kind == "missing":
        return "is missing"
    if kind == "union_tag_invalid":
        known = [tag.strip().strip("'") for tag in context["expected_tags"].split(",")]
        return f"unknown name {shown(context['tag'])}" + _suggest(context["tag"], known)
    if kind == "union_tag_not_found":
        return "needs a 'name'"
    if kind == "string_pattern_mismatch":
        return f"{shown(fault['input'])} must consist of lower-case letters, digits and hyphens"
    if kind in ("too_short", "too_long"):
        bound = context.get("min_length", context.get("max_length"))
        more = "or more " if kind == "too_short" else ""
        return f"must have {bound} {more}items, not {context['actual_length']}"
    if kind == "value_error":
        return str(fault["msg"]).removeprefix("Value error, ")
    return f"{_shown(fault['input'])} {_wanted(kind, context, fault['msg'])}"


def _wanted(kind: str, context: Mapping[str, Any], message: str) -> str:
    kind = kind.removesuffix("_type").removesuffix("_parsing")
    if kind in _KINDS:
        return f"must be {_KINDS[kind]}"
    if kind in _BOUNDS:
        phrase, bound = _BOUNDS[kind]
        return f"must be {phrase} {context[bound]:g}"
    if kind == "literal_error":
        return f"must be {context['expected']}"
    return message[:1].lower() + message[1:]


_KINDS = {
    "int": "a whole number",
    "int_from_float": "a whole number",
    "float": "a number",
    "finite_number": "finite",
    "bool": "true or false",
    "string": "text (quotes make text of a number)",
    "tuple": "a list",
    "list": "a list",
    "model": "a mapping",
    "dict": "a mapping",
    "model_attributes": "a mapping",
}
"""What pydantic's kinds of type errors ask for."""

_BOUNDS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
    "multiple_of": ("a multiple of", "multiple_of"),
}
"""How bounds are said, and where pydantic's context keeps them."""


def _shown(value: Any) -> str:
    """Write a value as YAML has it."""
    if value is None:
        return "an empty value"
    if isinstance(value, dict | list):
        return "a mapping" if isinstance(value, dict) else "a list"
    return str(value).lower() if isinstance(value, bool) else shown(value)


def _suggest(word: str, known: list[str]) -> str:
    return f"; {hint(word, known).rstrip('.')}"
