"""Read and write scenes as TOML; errors name file, line, field, value and rule."""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomli_w

from ghostball.model.scene.ball import Ball
from ghostball.model.scene.contents import SceneContents, usual_ball
from ghostball.model.scene.messages import refusal
from ghostball.model.scene.part import ScenePart
from ghostball.model.scene.table import Table
from ghostball.model.text_files import read_bytes, write_whole

LARGEST_FILE = 2**26
"""Largest size of a scene file [bytes], enough for half a million balls. Devices have no end."""


def read(path: Path) -> str:
    """Return the text of a scene file.

    Raises `SceneError` if the file can't be read, or can't be a scene.
    """
    try:
        content = read_bytes(path, LARGEST_FILE + 1)
        text = content.decode("utf-8-sig").replace("\r\n", "\n")  # TOML has these two line endings
    except UnicodeDecodeError as error:
        raise refusal(
            f"{path}: not UTF-8 text (byte {error.start}). A scene is a TOML text file"
        ) from None
    except (OSError, ValueError) as error:  # ValueError: an impossible path
        raise refusal(f"{path}: can't read the scene: {_reason(error)}. Check the path") from None
    if len(content) > LARGEST_FILE:
        raise refusal(
            f"{path}: a scene must have at most {LARGEST_FILE} bytes, and this has more. Check the "
            "path"
        )
    return text


def parse(text: str, source: str) -> dict[str, Any]:
    """Return the plain values of a scene's TOML text; errors call the text `source`.

    Raises `SceneError` if the text isn't TOML or has no schema.
    """
    if not isinstance(text, str):
        raise refusal(f"{source}: must be text, got {type(text).__name__}. Decode it, as UTF-8")
    data = _parsed(text, source)
    if "schema" not in data:
        raise refusal(f"{source}: `schema` must be given. Add `schema = 1` as the first line")
    return data


def _parsed(text: str, source: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        line = int(found[1]) if found else text.count("\n") + 1
        detail = re.sub(r" \(at .*\)$", "", str(error))
        raise refusal(f"{source}:{line}: not valid TOML: {detail}. Fix the syntax there") from None
    except RecursionError:
        raise refusal(
            f"{source}: lists or tables are nested too deeply. A scene needs 3 levels"
        ) from None
    except ValueError as error:  # Python limits the number of digits of an integer
        digits = sys.get_int_max_str_digits()
        found = re.search(rf"[0-9](?:_?[0-9]){{{digits},}}", text)
        if found is None:
            raise refusal(f"{source}: not valid TOML: {error}") from None
        line = text.count("\n", 0, found.start()) + 1
        raise refusal(
            f"{source}:{line}: a number must have at most {digits} digits. Shorten it"
        ) from None


def write(text: str, path: Path) -> None:
    """Write the text of a scene file, whole.

    Raises `SceneError` if the file can't be written.
    """
    if not path.name:
        raise refusal(f"{path}: can't write the scene: Is a directory")
    try:
        write_whole(path, text)
    except (OSError, ValueError) as error:
        raise refusal(f"{path}: can't write the scene: {_reason(error)}") from None


def dumps(scene: SceneContents) -> str:
    """Return the scene as TOML text: `preset` and the fields that differ from it."""
    data: dict[str, Any] = {"schema": scene.schema_version, "name": scene.name}
    if scene.title:
        data["title"] = scene.title
    if scene.tags:
        data["tags"] = list(scene.tags)
    if scene.t_max is not None:
        data["t_max"] = scene.t_max
    preset = type(scene.physics)(preset=scene.physics.preset)
    data["physics"] = {"preset": scene.physics.preset} | {
        name: value
        for name, value in scene.physics.model_dump().items()
        if value != getattr(preset, name)
    }
    if scene.table is not None:
        data["table"] = _table_fields(scene.table)
    table = scene.table.preset if scene.table is not None else None
    usual = usual_ball(table, scene.physics.preset) or {}
    data["balls"] = [_ball_fields(ball, usual) for ball in scene.balls]
    return tomli_w.dumps(data, multiline_strings=False)


def _reason(error: OSError | ValueError) -> str:
    if isinstance(error, OSError):
        return error.strerror or type(error).__name__
    return str(error)


def _differing(part: ScenePart, keep: tuple[str, ...]) -> dict[str, Any]:
    fields = type(part).model_fields
    values = part.model_dump(mode="json", exclude_none=True)
    return {
        name: value
        for name, value in values.items()
        if name in keep or getattr(part, name) != fields[name].default
    }


def _table_fields(table: Table) -> dict[str, Any]:
    """Return a table's fields: the name of its preset, and the fields that differ from it."""
    if table.preset is None:
        keep = () if table.vertices else ("length", "width")
        skip = {"length", "width"} if table.vertices else set()
        fields = _differing(table, keep=keep)
        return {name: value for name, value in fields.items() if name not in skip}
    preset = Table.model_validate(table.preset)
    return {"preset": table.preset} | {
        name: value
        for name, value in table.model_dump(mode="json", exclude_none=True).items()
        if getattr(table, name) != getattr(preset, name)
    }


def _ball_fields(ball: Ball, usual: Mapping[str, float]) -> dict[str, Any]:
    """Return a ball's fields, without values equal to the `usual` values in its scene."""
    fields = _differing(ball, keep=("id", "position", "radius", "mass"))
    for name, value in usual.items():
        if fields[name] == value:
            del fields[name]
    if ball.position[2] == ball.radius:
        fields["position"] = list(ball.position[:2])
    if ball.strike is not None:
        fields["strike"] = _differing(ball.strike, keep=("speed", "direction"))
    if "velocity" in fields and ball.velocity[2] == 0.0:
        fields["velocity"] = list(ball.velocity[:2])
    return fields
