"""Scenes as TOML: read with errors that name file, line, field, value and rule; write."""

from __future__ import annotations

import re
import sys
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import tomli_w
from pydantic import BaseModel, ValidationError

from ghostball.engine.errors import SceneError
from ghostball.engine.scene.messages import describe, refusal

if TYPE_CHECKING:
    from ghostball.engine.scene.model import Scene
    from ghostball.engine.scene.parts import Ball


LARGEST_FILE = 2**26
"""Most bytes of a scene file: those of half a million balls. A device may go on for ever."""


def load(path: Path, model: type[Scene]) -> Scene:
    """Read a scene file into a `model`; see `Scene.load`."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
        text = content.decode("utf-8").replace("\r\n", "\n")  # as text files have it
    except UnicodeDecodeError as error:
        raise refusal(
            f"{path}: not UTF-8 text (byte {error.start}). A scene is a TOML text file"
        ) from None
    except (OSError, ValueError) as error:  # ValueError: a path that no file can have
        raise refusal(f"{path}: can't read the scene: {_reason(error)}. Check the path") from None
    if len(content) > LARGEST_FILE:
        raise refusal(
            f"{path}: a scene must have at most {LARGEST_FILE} bytes, and this has more. Check the "
            "path"
        )
    return loads(text, str(path), model)


def loads(text: str, source: str, model: type[Scene]) -> Scene:
    """Read a scene from TOML text into a `model`; see `Scene.loads`."""
    if not isinstance(text, str):
        raise refusal(f"{source}: must be text, got {type(text).__name__}. Decode it, as UTF-8")
    data = _parsed(text, source)
    if "schema" not in data:
        raise refusal(f"{source}: `schema` must be given. Add `schema = 1` as the first line")
    try:
        scene: Scene = model.__pydantic_validator__.validate_python(data)
        return scene
    except ValidationError as error:
        raise SceneError(describe(error, model, source, text)) from None


def _parsed(text: str, source: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        found = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        line = int(found[1]) if found else text.count("\n") + 1
        detail = re.sub(r" \(at .*\)$", "", str(error))
        raise refusal(f"{source}:{line}: not valid TOML: {detail}. Mend the syntax there") from None
    except RecursionError:
        raise refusal(
            f"{source}: lists or tables are nested too deeply to read. A scene needs 3 levels"
        ) from None
    except ValueError as error:  # Python's own limit: integers of many digits are slow to read
        digits = sys.get_int_max_str_digits()
        found = re.search(rf"[0-9](?:_?[0-9]){{{digits},}}", text)
        if found is None:
            raise refusal(f"{source}: not valid TOML: {error}") from None
        line = text.count("\n", 0, found.start()) + 1
        raise refusal(
            f"{source}:{line}: a number must have at most {digits} digits. Shorten it"
        ) from None


def save(scene: Scene, path: Path) -> None:
    """Write a scene file; see `Scene.save`. Nothing is left behind where writing fails.

    Each call writes a file of its own beside the scene file and then replaces that by it, so that
    of several processes that save one scene at a time each replaces it by a whole file.
    """
    if not path.name:
        raise refusal(f"{path}: can't write the scene: Is a directory")
    temporary = path.with_name(f".{uuid4().hex}.part")
    try:
        temporary.write_text(dumps(scene), encoding="utf-8")
        temporary.replace(path)
    except (OSError, ValueError) as error:  # ValueError: a path or text that no file can have
        with suppress(OSError, ValueError):  # the first error is the one to tell
            temporary.unlink(missing_ok=True)
        raise refusal(f"{path}: can't write the scene: {_reason(error)}") from None


def dumps(scene: Scene) -> str:
    """Return the scene as TOML text: `preset` and what differs from it, defaults left out."""
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
        data["table"] = _differing(scene.table, keep=("length", "width"))
    data["balls"] = [_ball_fields(ball) for ball in scene.balls]
    return tomli_w.dumps(data, multiline_strings=False)


def _reason(error: OSError | ValueError) -> str:
    if isinstance(error, OSError):
        return error.strerror or type(error).__name__
    return str(error)


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
