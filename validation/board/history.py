"""What the board said before: a line of JSON for each run and row, and what moved since.

`history.jsonl` lies beside `board.json`, and is committed with it. A row is compared with the last
that is known of each of its cells, whichever run that was of.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ValidationError

from ghostball.model import GhostballError
from ghostball.model.text_files import read_text
from ghostball.validation.board.board import Board
from ghostball.validation.board.cell import Cell
from ghostball.validation.board.column import COLUMNS
from ghostball.validation.parallel.sources import PACKAGE_OF
from ghostball.validation.results.fields import Environment
from ghostball.validation.results.files import describe_validation_error, write_whole

HISTORY: Final = "history.jsonl"
"""The file, in the board's folder."""

SAME: Final = 0.01
"""Share by which a value may differ and has not moved."""

ROUNDING: Final = 1e-9
"""By how much a value may differ, in its unit, and has not moved: another processor's roundings."""


class Said(BaseModel, frozen=True, extra="forbid", allow_inf_nan=False):
    """What a cell said: its kind and its value, as `Cell` has them."""

    kind: str
    value: float | None = None


class Entry(BaseModel, frozen=True, extra="forbid"):
    """A row of one run: `version` is that of the engine, `revision` that of this code."""

    row: str
    version: str = ""
    revision: str = ""
    date: str = ""
    cells: Mapping[str, Said]

    @property
    def when(self) -> str:
        """Version, day and revision, as far as they are known."""
        known = (self.version, self.date[:10], self.revision[:7] and f"at {self.revision[:7]}")
        return ", ".join(filter(None, known)) or "then"


@dataclass(frozen=True)
class Move:
    """A cell that says something else than it did."""

    row: str
    column: str
    before: Said
    since: Entry
    now: Said


def entries_of(board: Board, cells: Iterable[Cell]) -> Iterator[Entry]:
    """Yield an entry for each row and environment of these cells of a board.

    What is measured in seconds is left out: another moment has other times.
    """
    found: dict[tuple[str, int | None], dict[str, Said]] = {}
    where = {}
    for cell in cells:
        column = COLUMNS.get(cell.column)
        if column is None or column.unit != "s":
            key = cell.row, cell.earlier
            found.setdefault(key, {})[cell.column] = Said(kind=cell.kind, value=cell.value)
            where[key] = Environment.model_validate(board.environment_of(cell))
    for (row, earlier), said in found.items():
        at = where[row, earlier]
        engine = row.partition(":")[0]
        yield Entry(
            row=row,
            version=at.versions.get(PACKAGE_OF.get(engine, engine)) or "",
            revision="" if at.git is None else at.git.revision,
            date=at.date,
            cells=said,
        )


def load_history(folder: Path) -> tuple[Entry, ...]:
    """Read what is known of earlier runs, the oldest first; nothing where there is no file."""
    path = folder / HISTORY
    try:
        lines = read_text(path).splitlines()
    except FileNotFoundError:
        return ()
    except (OSError, UnicodeDecodeError) as error:
        raise GhostballError(f"{path}: can't read the history of the board: {error}") from None
    entries = []
    for number, line in enumerate(lines, 1):
        try:
            entries.append(Entry.model_validate_json(line))
        except ValidationError as error:
            why = describe_validation_error(error)
            raise GhostballError(
                f"{path}, line {number}: {why}. Take the line out, or move the file away"
            ) from None
    return tuple(entries)


def moves_of(known: Iterable[Entry], entry: Entry) -> list[Move]:
    """Return which cells of a row differ from the last that is known of each."""
    last: dict[str, Entry] = {}
    for one in known:
        if one.row == entry.row:
            last |= dict.fromkeys(one.cells, one)
    return [
        Move(entry.row, column, last[column].cells[column], last[column], now)
        for column, now in entry.cells.items()
        if column in last and _differs(last[column].cells[column], now)
    ]


def remember(folder: Path, entries: Iterable[Entry]) -> list[Move]:
    """Write what a run came to behind what is known, and return what moved since.

    A row whose engine, cells and code are those of the last entry is known already.
    """
    known = load_history(folder)
    moves: list[Move] = []
    new: list[Entry] = []
    for entry in entries:
        moves += moves_of(known, entry)
        if not any(_is_same(one, entry) for one in known):
            new.append(entry)
    if new:
        text = "".join(f"{one.model_dump_json(exclude_defaults=True)}\n" for one in (*known, *new))
        try:
            write_whole(folder / HISTORY, text)
        except OSError as error:
            raise GhostballError(
                f"{folder / HISTORY}: can't be written: {error.strerror}"
            ) from None
    return moves


def _is_same(one: Entry, other: Entry) -> bool:
    return one.model_copy(update={"date": other.date}) == other


def _differs(before: Said, now: Said) -> bool:
    if before.kind != now.kind or (before.value is None) != (now.value is None):
        return True
    if before.value is None or now.value is None:
        return False
    return abs(before.value - now.value) > max(
        ROUNDING, SAME * max(abs(before.value), abs(now.value))
    )
