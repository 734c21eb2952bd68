"""The file `predictability.jsonl` of a results folder: how far its shots can be predicted."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from pydantic import TypeAdapter

from validation.diagnose.predictability.prediction import OLDER, SCHEMA, Predictability
from validation.results.files import cannot_write, parse_line, read_whole_lines, write_whole_lines
from validation.results.records import definition_hash
from validation.results.store import ResultsFolder

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
    try:
        write_whole_lines(folder / PREDICTABILITY_FILE, map(_RECORD.dump_json, records))
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
    lines = read_whole_lines(path, _AGAIN) or []
    records = [
        parse_line(_RECORD, line, f"{path}:{number}", SCHEMA, _AGAIN, OLDER)
        for number, line in enumerate(lines, 1)
    ]
    return {record.scene: record for record in records}


def predictability_in(results: ResultsFolder) -> list[Predictability]:
    """Return what a results folder holds of its very scenes, in their order.

    One of another version of a scene, left by an earlier run, is none of them.

    Raises
    ------
    ResultsError
        As `load_predictability`.
    """
    known = load_predictability(results.path)
    hashes = {case.scene: definition_hash(case.definition) for case in results.cases}
    return [
        known[name]
        for name in results.scene_names
        if name in known and known[name].definition_hash == hashes[name]
    ]
