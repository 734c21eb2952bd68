"""Records of cases written by hand, folders with such records, and edits of stored data."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ghostball.model import EVENT_DTYPE, Ball, Scene
from ghostball.validation.results.database import (
    DATABASE,
    get_document,
    put_document,
    reading,
    transaction,
    writing,
)
from ghostball.validation.results.motions import motion_of_case, put_motion
from ghostball.validation.results.store import CaseRecord, Motion, ResultsWriter

SCENE = Scene(
    name="roll", title="One ball", tags=("smoke",), balls=[Ball(id="cue", position=(0.1, 0.2))]
)


ENVIRONMENT = {"scenes": ["roll", "other"], "engines": ["pymunk", "ghostball"]}


def record(label: str = "pymunk", scene: str | Scene = SCENE, /, **changes: Any) -> CaseRecord:
    """Return the record of a case that ran, with defaults for all fields that aren't given.

    `scene`: a scene, or a name for a copy of `SCENE`.
    """
    if isinstance(scene, str):
        scene = SCENE.model_copy(update={"name": scene})
    fields = {
        "scene": scene.name,
        "title": scene.title,
        "tags": scene.tags,
        "definition": scene.model_dump(mode="json", by_alias=True),
        "label": label,
        "engine": label.partition(":")[0],
        "outcome": "ran",
    }
    return CaseRecord(**(fields | changes))


def motion(seed: int = 0) -> Motion:
    rng = np.random.default_rng(seed)
    events = np.array([(0.1 + 0.2, 0, 0, 1), (1.0, 3, 1, -1)], dtype=EVENT_DTYPE)
    states = [rng.normal(size=(4, 2, 3)) for _ in range(3)]
    energies = [rng.normal(size=4) for _ in range(3)]
    phases = rng.integers(0, 3, size=(4, 2), dtype=np.int8)
    return Motion(events, np.linspace(0, 1, 4), *states, *energies, phases)


def written(path: Path, *records: CaseRecord, finish: bool = True) -> ResultsWriter:
    writer = ResultsWriter(path)
    writer.begin(ENVIRONMENT)
    for item in records:
        writer.write((item, motion()))
    if finish:
        writer.finish("complete")
    return writer


def labels(cases: list[CaseRecord]) -> list[str]:
    return [case.label for case in cases]


def left(path: Path, code: str = "code") -> list[str]:
    """Return the labels of the cases that the next run may reuse."""
    return sorted(labels(list(ResultsWriter(path, code).known()[1].values())))


def taking_over(path: Path, code: str = "code") -> ResultsWriter:
    """Make a folder with three cases, and start a run that reuses the second case."""
    first = ResultsWriter(path, "code")
    first.begin(ENVIRONMENT)
    for label in ("pymunk", "ghostball", "pybullet"):
        first.write((record(label, status="rest"), motion()), f"inputs of {label}")
    first.finish("complete")
    writer = ResultsWriter(path, code)
    writer.begin(ENVIRONMENT, [("roll", "ghostball")])
    return writer


def in_database(folder: Path, statement: str, *given: Any) -> Any:
    """Execute a statement in the database, and return its first value, if any."""
    with writing(folder) as database, transaction(database):
        return (database.execute(statement, given).fetchone() or (None,))[0]


def edit_records(folder: Path, change: Callable[[str], str]) -> None:
    """Change the stored texts of all records."""
    with writing(folder) as database, transaction(database):
        for number, record in database.execute("SELECT id, record FROM cases").fetchall():
            database.execute("UPDATE records SET record = ? WHERE id = ?", [change(record), number])


def edit_document(folder: Path, name: Any, **changes: Any) -> None:
    """Change values in a stored document."""
    with writing(folder) as database, transaction(database):
        values = json.loads(get_document(database, name) or "{}")
        put_document(database, name, json.dumps(values | changes))


def change_motion(folder: Path, scene: str, label: str, **changes: Callable[[Any], Any]) -> None:
    """Change the stored motion of a case."""
    motion = motion_of_case(folder, scene, label)
    assert motion is not None
    changed = {name: change(getattr(motion, name)) for name, change in changes.items()}
    with writing(folder) as database, transaction(database):
        where = "SELECT id FROM cases WHERE scene = ? AND label = ?"
        (number,) = database.execute(where, [scene, label]).fetchone()
        database.execute("DELETE FROM motions WHERE record_id = ?", [number])
        put_motion(database, replace(motion, **changed), record_id=number)


def damage_motions(folder: Path) -> None:
    """Truncate every stored motion."""
    in_database(folder, "UPDATE motions SET content = substr(content, 1, 100)")


def cut_short(folder: Path) -> bytes:
    """Truncate the database, like an interrupted copy; return the remaining bytes."""
    path = folder / DATABASE
    left = path.read_bytes()[:-5000]
    path.write_bytes(left)
    return left


def stored(folder: Path) -> list[tuple[Any, ...]]:
    """Return everything that a run of the suite stored, for comparisons."""
    with reading(folder) as database:
        tables = ("documents", "records", "motions", "events")
        return [row for name in tables for row in database.execute(f"SELECT * FROM {name}")]
