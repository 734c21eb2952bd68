"""Cases and motions for the tests of what keeps them."""

from __future__ import annotations

import sqlite3
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ghostball.model import EVENT_DTYPE, Ball, Scene
from ghostball.validation.results.database import DATABASE
from ghostball.validation.results.store import (
    CaseRecord,
    Motion,
    ResultsWriter,
)

SCENE = Scene(name="roll", tags=("smoke",), balls=[Ball(id="cue", position=(0.1, 0.2))])


ENVIRONMENT = {"scenes": ["roll", "other"], "engines": ["pymunk", "ghostball"]}


def record(label: str = "pymunk", scene: str = "roll", **changes: Any) -> CaseRecord:
    blank = CaseRecord(
        scene=scene,
        title="One ball",
        tags=("smoke",),
        definition=SCENE.model_dump(mode="json", by_alias=True) | {"name": scene},
        label=label,
        engine=label.partition(":")[0],
        outcome="ran",
    )
    return replace(blank, **changes)


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


def in_database(folder: Path, query: str) -> Any:
    """Return what a query gives first, of the tables as anyone sees them."""
    database = sqlite3.connect(folder / DATABASE, isolation_level=None)
    try:
        return (database.execute(query).fetchone() or (None,))[0]
    finally:
        database.close()


def labels(cases: list[CaseRecord]) -> list[str]:
    return [case.label for case in cases]


def left(path: Path, code: str = "code") -> list[str]:
    """Return the labels of the cases that a next run may reuse."""
    return sorted(labels(list(ResultsWriter(path, code).known()[1].values())))


def taking_over(path: Path, code: str = "code") -> ResultsWriter:
    """Make a folder of three cases, and begin a run that reuses the second of them."""
    first = ResultsWriter(path, "code")
    first.begin(ENVIRONMENT)
    for label in ("pymunk", "ghostball", "pybullet"):
        first.write((record(label, status="rest"), motion()), f"inputs of {label}")
    first.finish("complete")
    writer = ResultsWriter(path, code)
    writer.begin(ENVIRONMENT, [("roll", "ghostball")])
    return writer
