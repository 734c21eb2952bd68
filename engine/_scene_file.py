"""Scenes as TOML: read with errors that name file, line, field, value and rule; write; schema."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path
from typing import Any, get_args

import tomli_w
from pydantic import BaseModel, ValidationError

from engine.errors import SceneError
from engine.scene import Ball, Physics, Scene, Table

Location = tuple[int | str, ...]

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
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise SceneError(f"{path}: can't read the scene: {reason}. Check the path") from None
    except UnicodeDecodeError as error:
        raise SceneError(
            f"{path}: not UTF-8 text (byte {error.start}). A scene is a TOML text file"
        ) from None
    return loads(text, str(path))


def loads(text: str, source: str) -> Scene:
    """Read a scene from TOML text; see `Scene.loads`."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        place = f"{source}:{found[1]}" if found else f"{source}:{text.count(chr(10)) + 1}"
        detail = re.sub(r" \(at .*\)$", "", str(error))
        raise SceneError(f"{place}: not valid TOML: {detail}. Mend the syntax there") from None
    if "schema" not in data:
        raise SceneError(f"{source}: `schema` must be given. Add `schema = 1` as the first line")
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        raise SceneError(describe(error, source, text)) from None


def save(scene: Scene, path: Path) -> None:
    """Write a scene file; see `Scene.save`. Nothing is left behind where writing fails."""
    temporary = path.with_name(path.name + ".part")
    try:
        temporary.write_text(dumps(scene), encoding="utf-8")
        temporary.replace(path)
    except OSError as error:
        with suppress(OSError):  # the first error is the one to tell
            temporary.unlink(missing_ok=True)
        reason = error.strerror or type(error).__name__
        raise SceneError(f"{path}: can't write the scene: {reason}") from None


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


def describe(error: ValidationError, source: str = "", text: str = "") -> str:
    """Say each problem of a failed validation in one line: place, field, rule, value, advice."""
    problems: dict[Location, list[Mapping[str, Any]]] = {}
    for problem in error.errors():  # the branches of a union share a location
        problems.setdefault(_without_union_branches(problem["loc"]), []).append(problem)
    if any(location[:1] == ("balls",) and len(location) > 1 for location in problems):
        problems.pop(("balls",), None)  # "too short" only because a ball of it was refused
    lines = []
    for location, branches in problems.items():
        number = _line_of(text, location or _named_in(branches[0])) if text else None
        place = f"{source}:{number}: " if number else f"{source}: " if source else ""
        lines.append(place + _sentence(branches, location, error.title))
    return "\n".join(lines)


def _named_in(problem: Mapping[str, Any]) -> Location:
    """Ball that a rule about the whole scene names in its sentence."""
    named = re.search(r"`balls\[(\d+)\]", str(problem["msg"]))
    return ("balls", int(named[1])) if named else ()


def _sentence(branches: list[Mapping[str, Any]], location: Location, model: str) -> str:
    kind, message = branches[0]["type"], str(branches[0]["msg"])
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
    got = "" if kind == "missing" else f", got {_shown(branches[0]['input'])}"
    hint = next((_HINTS[part] for part in reversed(location) if part in _HINTS), "")
    return f"`{field}` {rule}{got}." + (f" {hint}." if hint else "")


def _suggestion(location: Location, model: str) -> str:
    owners: dict[str, type[BaseModel]] = {"physics": Physics, "table": Table, "balls": Ball}
    models = {owner.__name__: owner for owner in (Scene, Physics, Table, Ball)}
    owner = owners.get(str(location[0]), Scene) if len(location) > 1 else models[model]
    known = [field.alias or name for name, field in owner.model_fields.items()]
    close = get_close_matches(str(location[-1]), known, n=1)
    return f". Did you mean `{close[0]}`?" if close else f". Known here: {', '.join(known)}."


def _shown(value: Any) -> str:
    shown = json.dumps(value) if isinstance(value, str | bool) else repr(value)
    return shown if len(shown) <= 80 else shown[:77] + "..."


def _without_union_branches(location: Location) -> Location:
    # pydantic names the branch of a union it tried ("constrained-float", "literal['alciatore']").
    names = {f.alias or n for m in (Scene, Physics, Table, Ball) for n, f in m.model_fields.items()}
    return tuple(
        part
        for i, part in enumerate(location)
        if isinstance(part, int) or part in names or (i == len(location) - 1 and _is_key(part))
    )


def _is_key(part: str) -> bool:
    return part not in get_args(Physics.model_fields["cushion"].annotation) and not re.search(
        r"[\[\]()]|^(float|str|constrained-float)$", part
    )


def _field_name(location: Location) -> str:
    name = ""
    for part in location:
        name += f"[{part}]" if isinstance(part, int) else f".{part}" if name else str(part)
    return name or "scene"


def _line_of(text: str, location: Location) -> int | None:
    """Line of a field in TOML text written the ordinary way, with [table] and [[balls]] headers.

    The standard library's parser keeps no positions; where the file is written in another way
    (inline tables) the line of the nearest enclosing part is given, or none.
    """
    if not location:
        return None
    if location[0] == "balls" and len(location) > 1 and isinstance(location[1], int):
        table, index, keys = "balls", location[1], location[2:]
    elif location[0] in ("physics", "table"):
        table, index, keys = str(location[0]), 0, location[1:]
    else:
        table, index, keys = "", 0, location
    current, seen, best = "", 0, None
    for number, line in enumerate(text.splitlines(), start=1):
        header = re.match(r"\s*\[\[?\s*([\w.-]+)\s*\]\]?", line)
        if header:
            current = header[1]
            if current == table and table:
                seen += 1
                if seen == index + 1:
                    best = number
            continue
        if current == table and (not table or seen == index + 1):
            key = re.match(r"""\s*["']?([\w-]+)["']?\s*=""", line)
            if key and keys and key[1] == keys[0]:
                return number
    return best


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
