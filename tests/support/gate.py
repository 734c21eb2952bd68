"""Data for tests of comparisons: runs of small shots, and event logs written by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from stored_records import record

from ghostball.engine import simulate
from ghostball.model import EVENT_DTYPE, Ball, EventKind, Events, Result, Scene, Table
from ghostball.model.hashes import bits_hash, sequence_hash
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.baselines.baseline import KEPT_EVENTS, Accepted
from ghostball.validation.baselines.compare import compare
from ghostball.validation.baselines.compared_run import ComparedRun, EventLog
from ghostball.validation.baselines.regression import Regression, SceneChange
from ghostball.validation.baselines.rounding import Allowance, allowance_of
from ghostball.validation.results.records import Accuracy, CaseRecord, status_name
from ghostball.validation.runs.sampling import events_of

ACCEPTED = Accepted(
    date="2026-01-02", revision="0123456789ab", platform="a machine", reason="It is right."
)


def cut_shot(speed: float = 1.0, name: str = "cut") -> Scene:
    """Return a cut shot in which both balls meet cushions."""
    return Scene(
        name=name,
        title=f"Two balls, {name}",
        balls=[
            Ball(id="cue", position=(0.5, 0.6), velocity=(speed, 0.0)),
            Ball(id="object", position=(1.0, 0.628)),
        ],
        table=Table(length=2.54, width=1.27),
    )


def roll_shot(speed: float = 1.0, name: str = "roll") -> Scene:
    """Return one ball that rolls to rest."""
    cue = Ball(id="cue", position=(0.5, 0.25), velocity=(speed, 0.5))
    return Scene(name=name, title=f"One ball, {name}", balls=[cue])


def record_of(result: Result, scene: Scene, **changes: Any) -> CaseRecord:
    """Return the record of a run as a case of a scene, with errors of 1e-12 m."""
    fields = {
        "tags": (),
        "status": status_name(result.status),
        "accuracy": Accuracy("nanometres", error=1e-12),
        "truth": "certified",
        "rest_positions": result.rest_positions,
        "rest_time": float(result.rest_time),
        "bits": bits_hash(events_of(result), result.rest_positions),
        "work": {name: int(count) for name, count in result.work.items()},
        "metrics": {"rest_error_max": 1e-12, "matching_events": 2},
    }
    return record(OURS, scene, **(fields | changes))


def played(scene: Scene, *, like: Scene | None = None, **changes: Any) -> ComparedRun:
    """Simulate a scene with Ghostball's engine; return the run, as a case of `like` if given."""
    result = simulate(scene, record="events")
    log = EventLog.of(events_of(result))
    return ComparedRun(record_of(result, like or scene, **changes), lambda: log)


def having(run: ComparedRun, **changes: Any) -> ComparedRun:
    """Return a run with changed values in its record."""
    return ComparedRun(replace(run.record, **changes), run.log)


def off(run: ComparedRun, error: float, kind: Any = "millimetres") -> ComparedRun:
    """Return a run with an error [m] and an accuracy class."""
    return having(run, accuracy=Accuracy(kind, error=error))


def compared(base: ComparedRun, head: ComparedRun, scene: Scene) -> SceneChange:
    """Compare two runs of a scene, with the allowance for rounding."""
    return compare(base, head, lambda: allowance_of(scene))


def log(*rows: tuple[float, EventKind, int, int]) -> Events:
    """Return an event log of rows: time, kind, a, b."""
    return np.array([(t, int(kind), a, b) for t, kind, a, b in rows], dtype=EVENT_DTYPE)


def long_log(count: int) -> Events:
    """Return `count` collisions of balls 0 and 1, one per second."""
    return log(*((k + 1.0, EventKind.BALL_BALL, 0, 1) for k in range(count)))


def with_events(run: ComparedRun, events: Events) -> ComparedRun:
    """Return a run with the given events and their hashes."""
    assert run.record.rest_positions is not None
    bits = bits_hash(events, run.record.rest_positions)
    return ComparedRun(replace(run.record, bits=bits), lambda: EventLog.of(events))


def as_accepted(run: ComparedRun) -> ComparedRun:
    """Return a run as a baseline stores it, with only the first events."""
    events = run.log().events
    kept = EventLog(events[:KEPT_EVENTS], len(events), sequence_hash(events))
    return ComparedRun(run.record, lambda: kept)


def at_rest(run: ComparedRun, positions: Sequence[Sequence[float]]) -> ComparedRun:
    """Return a run with the given rest positions [m]."""
    places = np.array(positions, dtype=np.float64)
    return having(run, rest_positions=places, bits=bits_hash(run.log().events, places))


def allowance(
    count: int,
    *,
    horizon: float = math.inf,
    time: float = 1e-12,
    rest: float | None = 1e-12,
    balls: int = 2,
) -> Allowance:
    """Return an allowance of `time` [s] for each of `count` events, and `rest` [m] at the end."""
    return Allowance(
        horizon,
        math.inf,
        np.full(count, time),
        None if rest is None else np.full(balls, rest),
    )


def changes(regression: Regression) -> dict[str, str]:
    """Return the class of change of each scene of a comparison."""
    return {one.scene: one.change for one in regression.scenes}
