"""Scenes as TOML: read with errors that name file, line, field, value and rule; write; schema."""

from __future__ import annotations

import json
import re
import reprlib
import sys
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin

import tomli_w
from pydantic import BaseModel, ValidationError

from engine._scene_checks import LARGEST
from engine._toml_lines import Location, line_of
from engine.errors import SceneError
from engine.scene import Ball, Physics, Scene, Table

_SECTIONS: dict[str, type[BaseModel]] = {"physics": Physics, "table": Table, "balls": Ball}

_RULES = {
    "missing": "must be given",
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than_equal": "must be at most {le:g}",
    "finite_number": "must be a finite number",
    "float_type": "must be a number",
    "float_parsing": "must be a number",
    "string_type": "must be text in quotes",
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
}
_HINTS = {
    "radius": "Give it in metres; a pool ball has 0.028575",
    "mass": "Give it in kilograms; a pool ball has 0.170097",
    "position": "Give the centre as [x, y] in metres",
    "velocity": "Give it as [x, y] in metres per second",
    "schema": "This version of ghostball reads schema 1",
}


def load(path: Path) -> Scene:
    """Read a scene file; see `Scene.load`."""
    try:
        text = path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise _refusal(
            f"{path}: not UTF-8 text (byte {error.start}). A scene is a TOML text file"
        ) from None
    except (OSError, ValueError) as error:  # ValueError: a path that no file can have
        raise _refusal(f"{path}: can't read the scene: {_reason(error)}. Check the path") from None
    return loads(text, str(path))


def loads(text: str, source: str) -> Scene:
    """Read a scene from TOML text; see `Scene.loads`."""
    data = _parsed(text, source)
    if "schema" not in data:
        raise _refusal(f"{source}: `schema` must be given. Add `schema = 1` as the first line")
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        raise SceneError(describe(error, Scene, source, text)) from None


def _parsed(text: str, source: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        line = int(found[1]) if found else text.count("\n") + 1
        detail = re.sub(r" \(at .*\)$", "", str(error))
        raise _refusal(
            f"{source}:{line}: not valid TOML: {detail}. Mend the syntax there"
        ) from None
    except RecursionError:
        raise _refusal(
            f"{source}: lists or tables are nested too deeply to read. A scene needs 3 levels"
        ) from None
    except ValueError as error:  # Python's own limit: integers of many digits are slow to read
        digits = sys.get_int_max_str_digits()
        found = re.search(rf"[0-9](?:_?[0-9]){{{digits},}}", text)
        if found is None:
            raise _refusal(f"{source}: not valid TOML: {error}") from None
        line = text.count("\n", 0, found.start()) + 1
        raise _refusal(
            f"{source}:{line}: a number must have at most {digits} digits. Shorten it"
        ) from None


def save(scene: Scene, path: Path) -> None:
    """Write a scene file; see `Scene.save`. Nothing is left behind where writing fails."""
    if not path.name:
        raise _refusal(f"{path}: can't write the scene: Is a directory")
    temporary = path.with_name(path.name + ".part")
    try:
        temporary.write_text(dumps(scene), encoding="utf-8")
        temporary.replace(path)
    except (OSError, ValueError) as error:  # ValueError: a path or text that no file can have
        with suppress(OSError, ValueError):  # the first error is the one to tell
            temporary.unlink(missing_ok=True)
        raise _refusal(f"{path}: can't write the scene: {_reason(error)}") from None


def dumps(scene: Scene) -> str:
    """Return the scene as TOML text: `preset` and what differs from it, defaults left out."""
    data: dict[str, Any] = {"schema": scene.schema_version, "name": scene.name}
    if scene.title:
        data["title"] = scene.title
    if scene.tags:
        data["tags"] = list(scene.tags)
    if scene.t_max is not None:
        data["t_max"] = scene.t_max
    preset = Physics(preset=scene.physics.preset)
    data["physics"] = {"preset": scene.physics.preset} | {
        name: value
        for name, value in scene.physics.model_dump().items()
        if value != getattr(preset, name)
    }
    if scene.table is not None:
        data["table"] = _differing(scene.table, keep=("length", "width"))
    data["balls"] = [_ball_fields(ball) for ball in scene.balls]
    return tomli_w.dumps(data, multiline_strings=False)


def json_schema() -> str:
    """Return the JSON schema of scene files, so that editors complete and check them."""
    schema = Scene.model_json_schema(by_alias=True)
    schema["required"] = ["schema", *schema["required"]]
    return json.dumps({"$schema": "http://json-schema.org/draft-07/schema#"} | schema, indent=2)


def describe(
    error: ValidationError, model: type[BaseModel], source: str = "", text: str = ""
) -> str:
    """Say each problem of a failed validation in one line: place, field, rule, value, advice.

    Parameters
    ----------
    error : pydantic.ValidationError
    model : type
        What was being validated: `Scene`, or a part of one.
    source, text : str
        The file's name and content, where there is a file.
    """
    problems: dict[Location, list[Mapping[str, Any]]] = {}
    for problem in error.errors():  # the branches of a union share a location
        problems.setdefault(_without_union_branch(problem), []).append(problem)
    if any(location[:1] == ("balls",) and len(location) > 1 for location in problems):
        problems.pop(("balls",), None)  # "too short" only because a ball of it was refused
    lines = []
    for location, branches in problems.items():
        number = line_of(text, location or _named_in(branches[0])) if text else None
        place = f"{source}:{number}: " if number else f"{source}: " if source else ""
        lines.append(_one_line(place + _sentence(branches, location, model)))
    return "\n".join(lines)


def _refusal(message: str) -> SceneError:
    return SceneError(_one_line(message))


def _one_line(message: str) -> str:
    # Keys, names and paths may hold line breaks and worse; a message is a line of a log.
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in message
    )


def _reason(error: OSError | ValueError) -> str:
    if isinstance(error, OSError):
        return error.strerror or type(error).__name__
    return str(error)


def _named_in(problem: Mapping[str, Any]) -> Location:
    """Ball that a rule about the whole scene names in its sentence."""
    named = re.search(r"`balls\[(\d+)\]", str(problem["msg"]))
    return ("balls", int(named[1])) if named else ()


def _sentence(branches: list[Mapping[str, Any]], location: Location, model: type[BaseModel]) -> str:
    kind, message, value = branches[0]["type"], str(branches[0]["msg"]), branches[0]["input"]
    field = _field_name(location)
    if kind == "extra_forbidden":
        return f"`{field}` is not a known field{_suggestion(location, model)}"
    if kind not in _RULES:  # our own sentences, which may name the field and the value themselves
        return f"{message}." if "`" in message else f"`{field}` {message}."
    rule = ", or ".join(
        _RULES[branch["type"]].format(**branch.get("ctx", {}))
        for branch in branches
        if branch["type"] in _RULES
    )
    if kind == "float_type" and type(value) is int:
        rule = f"must be at most {LARGEST:g} in size"  # no double comes near it
    got = "" if kind == "missing" else f", got {_shown(value)}"
    hint = next((_HINTS[part] for part in reversed(location) if part in _HINTS), "")
    return f"`{field}` {rule}{got}." + (f" {hint}." if hint else "")


def _suggestion(location: Location, model: type[BaseModel]) -> str:
    sections = [part for part in location[:-1] if isinstance(part, str)]
    owner = _SECTIONS[sections[-1]] if sections else model
    known = [field.alias or name for name, field in owner.model_fields.items()]
    close = get_close_matches(str(location[-1]), known, n=1)
    return f". Did you mean `{close[0]}`?" if close else f". Known here: {', '.join(known)}."


class _Shortened(reprlib.Repr):
    """`repr` that stays short for any input, however deep, long or large."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 4
        self.maxlist = self.maxtuple = self.maxdict = self.maxset = 20
        self.maxstring = self.maxlong = self.maxother = 80

    def repr_int(self, x: int, level: int) -> str:
        # Python refuses to write more than 4300 decimal digits, but not hexadecimal ones.
        return super().repr_int(x, level) if x.bit_length() <= 256 else hex(x)


_shorten = _Shortened().repr


def _shown(value: Any) -> str:
    shown = json.dumps(value) if isinstance(value, str | bool) else _shorten(value)
    return shown if len(shown) <= 80 else shown[:77] + "..."


def _is_union(annotation: Any) -> bool:
    branches = [branch for branch in get_args(annotation) if branch is not NoneType]
    return get_origin(annotation) in (Union, UnionType) and len(branches) > 1


_UNIONS = {
    name
    for name, field in (
        Scene.model_fields | Physics.model_fields | Table.model_fields | Ball.model_fields
    ).items()
    if _is_union(field.annotation)
}


def _without_union_branch(problem: Mapping[str, Any]) -> Location:
    # pydantic names the branch of a union it tried ("constrained-float") after the field's name.
    # Only a known field has branches; what follows a name as an unknown key is a key.
    location: Location = problem["loc"]
    if problem["type"] == "extra_forbidden" or len(location) < 2 or location[-2] not in _UNIONS:
        return location
    return location[:-1]


def _field_name(location: Location) -> str:
    name = ""
    for part in location:
        text = part if isinstance(part, int) or len(part) <= 80 else part[:77] + "..."
        name += f"[{part}]" if isinstance(part, int) else f".{text}" if name else str(text)
    return name if location else "scene"


def _differing(model: BaseModel, keep: tuple[str, ...]) -> dict[str, Any]:
    fields = type(model).model_fields
    values = model.model_dump(mode="json")
    return {
        name: value
        for name, value in values.items()
        if name in keep or getattr(model, name) != fields[name].default
    }


def _ball_fields(ball: Ball) -> dict[str, Any]:
    fields = _differing(ball, keep=("id", "position"))
    if ball.position[2] == ball.radius:
        fields["position"] = list(ball.position[:2])
    if "velocity" in fields and ball.velocity[2] == 0.0:
        fields["velocity"] = list(ball.velocity[:2])
    return fields
