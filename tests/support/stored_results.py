"""Edits of what a results folder holds: the texts of its records, its motions, its documents."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ghostball.validation.results.database import (
    DATABASE,
    get_document,
    put_document,
    reading,
    transaction,
    writing,
)
from ghostball.validation.results.motions import motion_of_case, put_motion


def in_database(folder: Path, statement: str, *given: Any) -> Any:
    """Make one change, and return the first value that it returns, if any."""
    with writing(folder) as database, transaction(database):
        return (database.execute(statement, given).fetchone() or (None,))[0]


def edit_records(folder: Path, change: Callable[[str], str]) -> None:
    """Store other texts as the records of the cases."""
    with writing(folder) as database, transaction(database):
        for number, record in database.execute("SELECT id, record FROM cases").fetchall():
            database.execute("UPDATE records SET record = ? WHERE id = ?", [change(record), number])


def edit_document(folder: Path, name: Any, **changes: Any) -> None:
    """Store other values in a document."""
    with writing(folder) as database, transaction(database):
        values = json.loads(get_document(database, name) or "{}")
        put_document(database, name, json.dumps(values | changes))


def change_motion(folder: Path, scene: str, label: str, **changes: Callable[[Any], Any]) -> None:
    """Store other numbers as the motion of a case."""
    motion = motion_of_case(folder, scene, label)
    assert motion is not None
    changed = {name: change(getattr(motion, name)) for name, change in changes.items()}
    with writing(folder) as database, transaction(database):
        where = "SELECT id FROM cases WHERE scene = ? AND label = ?"
        (number,) = database.execute(where, [scene, label]).fetchone()
        database.execute("DELETE FROM motions WHERE record_id = ?", [number])
        put_motion(database, replace(motion, **changed), record_id=number)


def damage_motions(folder: Path) -> None:
    """Cut every motion short."""
    in_database(folder, "UPDATE motions SET content = substr(content, 1, 100)")


def cut_short(folder: Path) -> bytes:
    """Cut the database short, as a copy that was interrupted is; return what is left of it."""
    path = folder / DATABASE
    left = path.read_bytes()[:-5000]
    path.write_bytes(left)
    return left


def stored(folder: Path) -> list[tuple[Any, ...]]:
    """Return all that a run of the suite stored, to be compared."""
    with reading(folder) as database:
        tables = ("documents", "records", "motions", "events")
        return [row for name in tables for row in database.execute(f"SELECT * FROM {name}")]
