"""Sampled motions in the database of a results folder: events as rows, arrays as one archive."""

from __future__ import annotations

import io
import sqlite3
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ghostball.model import EVENT_DTYPE, POCKETS, EventKind, Events, Phase
from ghostball.validation.results.database import REMEDY, name_text, reading
from ghostball.validation.results.files import ResultsError
from ghostball.validation.results.records import Motion

_LABELS: Final = {int(kind): kind.label for kind in EventKind}
_KINDS: Final = {label: kind for kind, label in _LABELS.items()}
_SAMPLED: Final = [part.name for part in fields(Motion) if part.name != "events"]


def put_motion(database: sqlite3.Connection, motion: Motion, *, record_id: int) -> None:
    """Add the motion of a case; call it within a `transaction`."""
    parts = {name: getattr(motion, name) for name in _SAMPLED}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **{name: p for name, p in parts.items() if p is not None})
    motion_id = database.execute(
        "INSERT INTO motions (record_id, content) VALUES (?, ?)", [record_id, buffer.getvalue()]
    ).lastrowid
    database.executemany(
        "INSERT INTO events VALUES (?, ?, ?, ?, ?)",
        [(motion_id, t, _LABELS[kind], a, b) for t, kind, a, b in motion.events.tolist()],
    )


def motion_of_case(folder: Path, scene: str, label: str) -> Motion | None:
    """Read the motion of a case, or None if there is none.

    Raises `ResultsError` if it is damaged.
    """
    with reading(folder) as database:
        found = database.execute(
            "SELECT id, content FROM motions "
            "WHERE record_id = (SELECT id FROM records WHERE kind = 'case' AND name = ?)",
            [name_text((scene, label))],
        ).fetchone()
        if found is None:
            return None
        rows = database.execute(
            "SELECT t, kind, a, b FROM events WHERE motion_id = ? ORDER BY rowid", [found[0]]
        ).fetchall()
    # The exceptions of zipfile, zlib and numpy for a damaged archive aren't documented.
    try:
        events = np.array([(t, _KINDS[kind], a, b) for t, kind, a, b in rows], dtype=EVENT_DTYPE)
        with np.load(io.BytesIO(found[1]), allow_pickle=False) as stored:
            parts = dict(stored)
        _check(parts, events)
        return Motion(events, **parts)
    except Exception as error:
        said = " ".join(f"{type(error).__name__}: {error}".split())
        what = f'the motion of `{label}` in scene "{scene}"'
        raise ResultsError(f"{folder}: {what} is damaged: {said}. {REMEDY}") from error


def _check(parts: dict[str, NDArray[Any]], events: Events) -> None:
    """Check that arrays form one motion: their names, types, shapes and values."""
    names = set(_SAMPLED)
    if not names - {"phases"} <= set(parts) <= names:
        raise ValueError(f"it must hold {', '.join(_SAMPLED)}, got {', '.join(parts) or 'nothing'}")
    k, n = parts["phases" if "phases" in parts else "positions"].shape[:2]
    for name, array in parts.items():
        of_time = name == "times" or name.startswith("energy_")
        shape = (k,) if of_time else (k, n) if name == "phases" else (k, n, 3)
        kind = np.int8 if name == "phases" else np.float64
        if array.shape != shape or array.dtype != kind:
            raise ValueError(
                f"`{name}` must be {np.dtype(kind)} with shape {shape}, got {array.dtype} with "
                f"shape {array.shape}"
            )
    if "phases" in parts and not np.all(np.isin(parts["phases"], [int(one) for one in Phase])):
        raise ValueError("`phases` must be values of `Phase`")
    known = np.select(
        [events["kind"] == EventKind.BALL_BALL, events["kind"] == EventKind.POCKETED],
        [n, len(POCKETS)],
        np.iinfo(np.int32).max,
    )
    if not np.all((events["a"] >= 0) & (events["a"] < n) & (events["b"] < known)):
        raise ValueError(f"`events` must name the {n} balls, got a = {events['a'].tolist()}")
    if k == 0 or not np.all(np.diff(parts["times"]) >= 0.0):
        raise ValueError("`times` must be instants in order of time")
