"""Describe the mistakes in a scene, one line each: location, field, rule, value, remedy.

The code works for any pydantic model that consists of models; only the sentences are about scenes.
"""

from __future__ import annotations

import json
import re
import reprlib
from collections.abc import Mapping
from difflib import get_close_matches
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from ghostball.model.errors import SceneError
from ghostball.model.scene.fields import LARGEST
from ghostball.model.scene.toml_lines import Location, line_of

_RULES = {
    "missing": "must be given",
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than_equal": "must be at most {le:g}",
    "less_than": "must be less than {lt:g}",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "float_parsing": "must be a number",
    "string_type": "must be text in quotes",
    "int_type": "must be a whole number",
    "bool_type": "must be true or false",
    "tuple_type": "must be a list",
    "too_short": "must have at least {min_length} item(s)",
    "too_long": "must have at most {max_length} items",
    "literal_error": "must be {expected}",
    "string_pattern_mismatch": (
        'must be lower case letters, digits, ".", "_" and "-", at most 64 of them'
    ),
    "string_too_short": "must not be empty",
    "string_too_long": "must have at most {max_length} characters",
    "string_unicode": "must be text without broken characters",
    "invalid_key": "must be named by text",
    "model_type": "must be a table of fields",
    "json_invalid": "must be valid JSON ({error})",
}
_HINTS = {
    "radius": "Give it in metres; a pool ball has 0.028575.",
    "mass": "Give it in kilograms; a pool ball has 0.170097.",
    "position": "Give the centre as [x, y] or [x, y, z] in metres.",
    "velocity": "Give it as [x, y] or [x, y, z] in metres per second.",
    "schema": "This version of ghostball reads schema 1.",
}


MAX_SHOWN = 20
"""Largest number of mistakes shown: a generated scene may repeat a mistake a thousand times."""


def describe(
    error: ValidationError, model: type[BaseModel], source: str = "", text: str = ""
) -> str:
    """Describe each problem of a failed validation in one line.

    A line names the location, the field, the rule, the value and a remedy.

    `model`: the model that was validated, `Scene` or a part of a scene.
    `source`, `text`: name and content of the file, or "" without a file.
    """
    problems: dict[Location, list[Mapping[str, Any]]] = {}
    for problem in error.errors():  # the branches of a union share a location
        problems.setdefault(_without_union_branch(problem, model), []).append(problem)
    if any(location[:1] == ("balls",) and len(location) > 1 for location in problems):
        problems.pop(("balls",), None)  # reported as too short only because a ball was rejected
    lines = []
    for location, branches in list(problems.items())[:MAX_SHOWN]:
        at = branches[0].get("ctx", {}).get("at", ())
        number = line_of(text, location + at) if text else None
        place = f"{source}:{number}: " if number else f"{source}: " if source else ""
        lines.append(one_line(place + _sentence(branches, location, model)))
    more = len(problems) - len(lines)
    if more > 0:
        lines.append(one_line(f"{source}: " if source else "") + f"{more} more mistakes, not shown")
    return "\n".join(lines)


def refusal(message: str) -> SceneError:
    """Return the `SceneError` of a message, kept to one line."""
    return SceneError(one_line(message))


def one_line(message: str) -> str:
    """Return a message with line breaks and other unprintable characters escaped."""
    # Keys, names and paths may contain line breaks and control characters; a message is one line of
    # a log.
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in message
    )


def _sentence(branches: list[Mapping[str, Any]], location: Location, model: type[BaseModel]) -> str:
    kind, message, value = branches[0]["type"], str(branches[0]["msg"]), branches[0]["input"]
    field = _field_name(location)
    if kind == "extra_forbidden":
        return f"`{field}` is not a known field{_suggestion(location, model)}"
    if (
        kind not in _RULES
    ):  # sentences of Ghostball's validators, which may name the field and the value
        return f"{message}." if "`" in message else f"`{field}` {message}."
    rule = ", or ".join(
        _RULES[branch["type"]].format(**branch.get("ctx", {}))
        for branch in branches
        if branch["type"] in _RULES
    )
    if kind == "float_type" and type(value) is int:
        rule = f"must be at most {LARGEST:g} in size"  # too large for a double
    got = "" if kind == "missing" else f", got {_shown(value)}"
    hint = _closest_choice(branches, value)
    hint = hint or next((_HINTS[part] for part in reversed(location) if part in _HINTS), "")
    return f"`{field}` {rule}{got}." + (f" {hint}" if hint else "")


def _closest_choice(branches: list[Mapping[str, Any]], value: Any) -> str:
    """Return a question suggesting the closest permitted text, or "" if none is close."""
    expected = [b["ctx"]["expected"] for b in branches if b["type"] == "literal_error"]
    known = re.findall(r"'([^']*)'", " ".join(expected))
    close = get_close_matches(value.lower(), known, n=1) if isinstance(value, str) else []
    return f'Did you mean "{close[0]}"?' if close else ""


def _suggestion(location: Location, model: type[BaseModel]) -> str:
    owner = _owner(location, model)
    known = [field.alias or name for name, field in owner.model_fields.items()]
    close = get_close_matches(str(location[-1]), known, n=1)
    return f". Did you mean `{close[0]}`?" if close else f". Known here: {', '.join(known)}."


class _Shortened(reprlib.Repr):
    """`repr` with a short result for any input, however deep, long or large."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 4
        self.maxlist = self.maxtuple = self.maxdict = self.maxset = 20
        self.maxstring = self.maxlong = self.maxother = 80

    def repr_int(self, x: int, level: int) -> str:
        # Python can't convert more than 4300 decimal digits to text, but has no limit for
        # hexadecimal.
        return super().repr_int(x, level) if x.bit_length() <= 256 else hex(x)


_shorten = _Shortened().repr


def _shown(value: Any) -> str:
    shown = json.dumps(value) if isinstance(value, str | bool) else _shorten(value)
    return shown if len(shown) <= 80 else shown[:77] + "..."


def _field_name(location: Location) -> str:
    name = ""
    for part in location:
        text = part if isinstance(part, int) or len(part) <= 80 else part[:77] + "..."
        name += f"[{part}]" if isinstance(part, int) else f".{text}" if name else str(text)
    return name if location else "scene"


def _owner(location: Location, model: type[BaseModel]) -> type[BaseModel]:
    """Return the model that the last part of `location` is a field of, or would be a field of."""
    for part in location[:-1]:
        field = _field(model, part)
        model = (_model_in(field.annotation) if field else None) or model
    return model


def _field(model: type[BaseModel], part: int | str) -> FieldInfo | None:
    return model.model_fields.get(part) if isinstance(part, str) else None


def _model_in(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(_model_in, get_args(annotation))), None)


def _is_union(annotation: Any) -> bool:
    branches = [branch for branch in get_args(annotation) if branch is not NoneType]
    return get_origin(annotation) in (Union, UnionType) and len(branches) > 1


def _without_union_branch(problem: Mapping[str, Any], model: type[BaseModel]) -> Location:
    # pydantic appends the branch of a union ("constrained-float") to the name of the field. Only a
    # known field has branches; in the location of an unknown key, the last part is the key.
    location: Location = problem["loc"]
    if problem["type"] == "extra_forbidden" or len(location) < 2:
        return location
    field = _field(_owner(location[:-1], model), location[-2])
    return location[:-1] if field is not None and _is_union(field.annotation) else location
