"""`attributions.jsonl` of a results folder: written whole, read back, refused with its place."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from pydantic import TypeAdapter

from validation.attribution.records import SCHEMA, Attribution
from validation.files import cannot_write, parse_line, read_whole_lines, write_whole_lines
from validation.records import CaseRecord, definition_hash

ATTRIBUTIONS_FILE: Final = "attributions.jsonl"

_RECORD: Final = TypeAdapter(Attribution)
_AGAIN: Final = "Run `ghostball validate --attribute` again"


def write_attributions(folder: str | Path, attributions: Iterable[Attribution]) -> Path:
    """Write attributions into a results folder, in place of those that are there.

    Whole or not at all.

    Raises
    ------
    ResultsError
        Where it can't be written.
    """
    path = Path(folder) / ATTRIBUTIONS_FILE
    try:
        write_whole_lines(path, map(_RECORD.dump_json, attributions))
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
    lines = read_whole_lines(path, _AGAIN) or []
    return [
        parse_line(_RECORD, line, f"{path}:{number}", SCHEMA, _AGAIN)
        for number, line in enumerate(lines, 1)
    ]


def belongs_to(attribution: Attribution, case: CaseRecord) -> bool:
    """Whether an attribution is of the very case: scene, engine with settings, and code."""
    return (
        (attribution.scene, attribution.label) == (case.scene, case.label)
        and attribution.definition_hash == definition_hash(case.definition)
        and attribution.code_hash == case.code_hash
    )
