"""`attributions.jsonl` of a results folder: written whole, read back, refused with its place."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from pydantic import TypeAdapter, ValidationError

from engine import Scene
from validation.attribution.records import SCHEMA, Attribution
from validation.files import ResultsError, cannot_write
from validation.records import CaseRecord

ATTRIBUTIONS_FILE: Final = "attributions.jsonl"

_RECORD = TypeAdapter(Attribution)


def write_attributions(folder: str | Path, attributions: Iterable[Attribution]) -> Path:
    """Write attributions into a results folder, in place of those that are there.

    Whole or not at all.

    Raises
    ------
    ResultsError
        Where it can't be written.
    """
    path = Path(folder) / ATTRIBUTIONS_FILE
    part = path.with_name(path.name + ".part")
    try:
        with part.open("w", encoding="utf-8", newline="\n") as file:
            file.writelines(_RECORD.dump_json(one).decode() + "\n" for one in attributions)
        part.replace(path)
    except OSError as error:
        raise cannot_write(Path(folder), error) from error
    return path


def read_attributions(folder: str | Path) -> list[Attribution]:
    """Read the attributions of a results folder; none where it has no such file.

    Raises
    ------
    ResultsError
        Where the file is of another schema version, or damaged.
    """
    path = Path(folder) / ATTRIBUTIONS_FILE
    try:
        lines = path.read_text(encoding="utf-8").split("\n")
    except FileNotFoundError:
        return []
    except (OSError, UnicodeDecodeError) as error:
        raise ResultsError(f"{path}: can't read the attributions: {error}") from error
    return [_read(line, f"{path}:{number}") for number, line in enumerate(lines[:-1], start=1)] + (
        [_read(lines[-1], f"{path}:{len(lines)}")] if lines[-1] else []
    )


def _read(line: str, place: str) -> Attribution:
    again = "Run `ghostball validate --attribute` again"
    try:
        data = json.loads(line)
        schema = data.get("schema") if isinstance(data, dict) else None
        if schema != SCHEMA:
            raise ResultsError(f"{place}: `schema` must be {SCHEMA}, got {schema!r}. {again}")
        return _RECORD.validate_python(data)
    except json.JSONDecodeError as error:
        raise ResultsError(f"{place}: not valid JSON: {error.msg}. {again}") from None
    except ValidationError as error:
        first = error.errors()[0]
        name = ".".join(map(str, first["loc"]))
        raise ResultsError(f"{place}: `{name}`: {first['msg']}. {again}") from None


def definition_hash(definition: object) -> str:
    """Return the hash of a scene's definition as plain values, as a `CaseRecord` has it."""
    text = json.dumps(definition, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def scene_hash(scene: Scene) -> str:
    """Return the hash of a scene."""
    return definition_hash(scene.model_dump(mode="json", by_alias=True))


def belongs_to(attribution: Attribution, case: CaseRecord) -> bool:
    """Whether an attribution is of the very case: scene, engine with settings, and code."""
    return (
        (attribution.scene, attribution.label) == (case.scene, case.label)
        and attribution.definition_hash == definition_hash(case.definition)
        and attribution.code_hash == case.code_hash
    )
