"""The data of one scene's replay, as compact plain values for JSON.

The data contain the table and the balls, the style and outcome of each engine, and, in one
compressed string, the event logs and the motions (`reports.page.replay_tracks`). The scripts that
draw the replay are in `assets/` and joined by `reports.page.rendering`.
"""

from __future__ import annotations

import base64
import math
import zlib
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from ghostball.model import CUSHIONS, POCKETS, EventKind, Events, Scene, Table
from ghostball.model.arrays import FloatArray
from ghostball.reports.accuracy import accuracy_text
from ghostball.reports.figures._table import view_of
from ghostball.reports.figures.heights import FLIES_FROM
from ghostball.reports.page.replay_tracks import (
    FARTHEST,
    QUANTUM,
    SPIN_QUANTUM,
    TOLERANCE,
    packed_motion,
)
from ghostball.reports.shots import Run, Shot
from ghostball.reports.words import metric_of

SCHEMA: Final = 2
"""Version of the data format; the script rejects every other version."""

MAX_EVENTS = 1500
"""Largest number of events kept from an engine's log: a time line can't show more events."""

FAR_OFF = 2.0
"""A ball that ends farther away than this multiple of the view's size is left out of the view."""

_LINES: Final = {"-": [], "--": [5.0, 2.5], ":": [1.2, 1.6], "-.": [6.0, 2.0, 1.2, 2.0]}
"""Lengths of dashes and gaps [pt] of matplotlib's line styles; empty for a solid line."""


def scene_data(shot: Shot, *, horizon: float | None = None) -> dict[str, Any]:
    """Return the data of a scene's replay as plain values, without nan and inf.

    `horizon` [s]: the predictability horizon in double precision (`CaseRecord.shot_horizon`).
    """
    scene, runs, truth = shot.scene, shot.runs, shot.truth_positions
    parts: list[bytes] = []
    engines = [_engine(run, scene.radii, parts) for run in runs]
    table = scene.table
    return {
        "schema": SCHEMA,
        "scene": scene.name,
        "title": scene.title,
        "table": None
        if table is None
        else {
            "length": table.length,
            "width": table.width,
            "cushions": list(table.cushions),
            **_shape_of(table),
        },
        "cushions": list(CUSHIONS),
        "pockets": list(POCKETS),
        "kinds": [kind.label for kind in EventKind],
        "balls": [{"id": ball.id, "radius": ball.radius} for ball in scene.balls],
        "view": [round(edge, 6) for edge in _view(scene, runs)],
        "tolerance": TOLERANCE,
        "quantum": QUANTUM,
        "spin": SPIN_QUANTUM,
        "highest": _highest(scene, runs),
        "nose": scene.physics.cushion_height if scene.physics.airborne else None,
        # A horizon of 0 means that the growth of errors is unknown, for example in flight.
        "horizon": _finite(horizon or None),
        "truth": None if truth is None else {"kind": shot.truth, "rest": _points(truth)},
        "engines": engines,
        "packed": _compressed(b"".join(parts)),
    }


def _shape_of(table: Table) -> dict[str, Any]:
    """Return outline, holes and posts of a table; empty for a rectangle without posts."""
    shape: dict[str, Any] = {}
    if not table.is_rectangle:
        shape["outline"] = [[round(c, 6) for c in point] for point in table.drawn_outline]
        shape["holes"] = [[*hole.centre, hole.radius] for hole in table.holes]
    if table.posts:
        shape["posts"] = [[*post.centre, post.radius] for post in table.posts]
    return shape


def _highest(scene: Scene, runs: Sequence[Run]) -> float:
    """Return the largest height of a ball's lowest point above the cloth [m]; 0 without flight."""
    rise = 0.0
    for run in runs:
        if run.motion is not None:
            rises = run.motion.positions[:, :, 2] - scene.radii
            rise = max(rise, float(np.max(rises, initial=0.0, where=np.abs(rises) <= FARTHEST)))
    return rise if rise >= FLIES_FROM else 0.0


def _engine(run: Run, radii: FloatArray, parts: list[bytes]) -> dict[str, Any]:
    case, look = run.case, run.style
    line = look.line
    said: dict[str, Any] = {
        "label": run.label,
        "name": look.name,
        "colour": look.colour,
        "dash": _LINES[line] if isinstance(line, str) else list(line[1]),
        "marker": look.marker,
        "ours": look.ours,
        "outcome": "ran" if case is None else case.outcome,
        "status": None if case is None else case.status,
        "reason": "not requested" if case is None and run.motion is None else "",
        "verdict": "; ".join(filter(None, (accuracy_text(case), run.verdict.words)))
        if case
        else "",
        "horizon": None if case is None else _finite(case.horizon),
        "divergence": metric_of(run.case, "first_divergence_time"),
        # Whether the distance from the reference is an error: after the horizon it isn't.
        "standing": run.standing.name.lower(),
        "exact": case is not None and case.is_exact,
        "rest": None,
        "motion": None,
    }
    if case is not None:
        said["reason"] = case.reason
        if case.rest_positions is not None:
            said["rest"] = _points(case.rest_positions)
    if run.motion is not None and len(run.motion.times):
        kept = _kept(run.motion.events)
        content, tick, lost = packed_motion(run.motion, kept, radii)
        parts.append(content)
        said["motion"] = {
            "end": float(run.motion.times[-1]),
            "tick": tick,
            "phases": run.motion.phases is not None,
            "events": len(kept),
            "of": len(run.motion.events),
            "lost": [[ball, t] for ball, t in lost.items()],
        }
    return said


def _kept(events: Events) -> Events:
    """Return at most `MAX_EVENTS` events with a finite time, evenly sampled from the log."""
    events = events[np.isfinite(events["t"])]
    if len(events) <= MAX_EVENTS:
        return events
    chosen: Events = events[np.linspace(0, len(events) - 1, MAX_EVENTS).astype(np.intp)]
    return chosen


def _view(scene: Scene, runs: Sequence[Run]) -> tuple[float, float, float, float]:
    moved = [run for run in runs if run.motion is not None]
    if not moved:
        return view_of(scene)
    # The view contains the whole motion of Ghostball's engine, but not balls that another engine
    # moved far away.
    ours = next((run.motion for run in moved if run.style.ours), None)
    needed = [scene.positions] if ours is None else [scene.positions, _near(ours.positions)]
    whole = np.concatenate(needed)
    low, high = whole.min(axis=0), whole.max(axis=0)
    reach = FAR_OFF * max(float((high - low).max()), float(scene.radii.max()))
    ends = (run.motion.positions[-1] for run in moved if run.motion is not None)
    shown = [end[((low - reach <= end) & (end <= high + reach)).all(axis=1)] for end in ends]
    return view_of(scene, *shown, needed=whole)


def _near(positions: FloatArray) -> FloatArray:
    """Return the centres (m, 3) [m] whose coordinates are at most `FARTHEST`."""
    centres = positions.reshape(-1, positions.shape[-1])
    return centres[(np.abs(centres) <= FARTHEST).all(axis=1)]


def _points(positions: FloatArray) -> list[list[float] | None]:
    """Return x and y of each centre [m], or None if x or y isn't finite."""
    return [
        [float(x), float(y)] if math.isfinite(x) and math.isfinite(y) else None
        for x, y in positions[:, :2]
    ]


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)


def _compressed(content: bytes) -> str:
    """Return bytes compressed as raw deflate (RFC 1951, readable by browsers), in base64."""
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15, 9)
    return base64.b64encode(deflate.compress(content) + deflate.flush()).decode("ascii")
