"""The file `predictability.jsonl` of a results folder: how far its shots can be predicted."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from pydantic import TypeAdapter, ValidationError

from validation.files import ResultsError, cannot_write
from validation.predictability.records import SCHEMA, Predictability

PREDICTABILITY_FILE: Final = "predictability.jsonl"

_RECORD: Final = TypeAdapter(Predictability)
_AGAIN: Final = "Run `ghostball validate` again"


def save_predictability(folder: Path, records: Iterable[Predictability]) -> None:
    """Write the file of a results folder, whole or not at all.

    Raises
    ------
    ResultsError
        Where the folder can't be written.
    """
    path = folder / PREDICTABILITY_FILE
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            file.writelines(_RECORD.dump_json(record) + b"\n" for record in records)
        part.replace(path)
    except OSError as error:
        raise cannot_write(folder, error) from error


def load_predictability(folder: Path) -> dict[str, Predictability]:
    """Read the file of a results folder, by scene; nothing where there is none.

    Raises
    ------
    ResultsError
        Where it is cut short, damaged, or of another schema version.
    """
    path = folder / PREDICTABILITY_FILE
    try:
        lines = path.read_bytes().decode("utf-8").split("\n")
    except (FileNotFoundError, NotADirectoryError):
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise ResultsError(f"{path}: can't read it: {error}. {_AGAIN}") from error
    if lines.pop():
        raise ResultsError(f"{path}:{len(lines) + 1}: the line is cut short. {_AGAIN}")
    records = [_parse(line, f"{path}:{number}") for number, line in enumerate(lines, 1)]
    return {record.scene: record for record in records}


def _parse(line: str, place: str) -> Predictability:
    try:
        data = json.loads(line)
    except json.JSONDecodeError as error:
        raise ResultsError(
            f"{place}: not valid JSON: {error.msg} (column {error.colno}). {_AGAIN}"
        ) from None
    schema = data.get("schema") if isinstance(data, dict) else None
    if schema != SCHEMA:
        raise ResultsError(
            f"{place}: `schema` must be {SCHEMA}, got {schema!r}: another version of ghostball "
            f"wrote it. {_AGAIN}"
        )
    try:
        return _RECORD.validate_python(data)
    except ValidationError as error:
        first = error.errors()[0]
        name = ".".join(map(str, first["loc"]))
        raise ResultsError(f"{place}: `{name}`: {first['msg']}. {_AGAIN}") from None
