"""Differences of a run with correct rest positions: earlier positions, and times of events.

>>> differs_before_end(result, known, step=1e-3)
'before the end, a ball is up to 100 mm from its reference position, at t = 0.31 s'
"""

from __future__ import annotations

from collections import defaultdict
from typing import Final

import numpy as np

from ghostball.model import EventKind, Result, SampledTrajectory
from ghostball.validation.grading.event_logs import Event, events_in
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.truth.known_shot import KnownShot, farthest

SAMPLE_COUNT: Final = 401
"""Number of times at which an exact motion is compared."""

VISIBLE_DIFFERENCE: Final = 1e-6
"""Smallest reported difference beyond that of a time step: of positions [m], and of times [s]."""


def differs_before_end(result: Result, known: KnownShot, step: float = 0.0) -> str:
    """Return how a run differs from the reference before its end; "" if there is no difference.

    `result`: with its events and its motion; if it has frames, only these are compared.
    `step`: time step of the engine [s]: events may be late by a step, and balls displaced
        accordingly.
    """
    return "; and ".join(filter(None, (_motion(result, known, step), _events(result, known, step))))


def _motion(result: Result, known: KnownShot, step: float) -> str:
    times = np.linspace(0.0, result.rest_time, SAMPLE_COUNT)
    if isinstance(result.trajectory, SampledTrajectory):
        times = result.trajectory.times
    off = farthest(result, known.result, times)
    k = int(np.argmax(off))
    speeds = np.linalg.norm(known.result.sample(times).velocities, axis=2)
    if not off[k] > VISIBLE_DIFFERENCE + 2.0 * step * float(np.max(speeds)):
        return ""
    return (
        f"before the end, a ball is up to {1e3 * off[k]:.3g} mm from its reference position, "
        f"at t = {times[k]:.3g} s"
    )


def _events(result: Result, known: KnownShot, step: float) -> str:
    """Compare the kinds of events that both report: how often, and when, each event happens."""
    worst, words = VISIBLE_DIFFERENCE + 2.0 * step, ""
    for kind in EventKind:
        found, true = (_by_key(run, kind) for run in (result, known.result))
        if not found or not true:
            continue
        for key in sorted({*found, *true}):
            mine, right = found.get(key, []), true.get(key, [])
            what = (mine or right)[0].describe(result.scene)
            if len(mine) != len(right):
                # An engine may report only some of infinitely many bounces.
                if kind is EventKind.BALL_CLOTH:
                    continue
                return (
                    f"in its events, {what} {_times(len(mine))}; in the reference, "
                    f"{_times(len(right))}"
                )
            late = max((b.t - a.t for a, b in zip(right, mine, strict=True)), key=abs)
            if abs(late) > worst:
                side = "late" if late > 0.0 else "early"
                worst, words = abs(late), f"in its events, {what} {abs(late):.3g} s too {side}"
    return words


def _by_key(run: Result, kind: EventKind) -> dict[tuple[int, int], list[Event]]:
    by_key: dict[tuple[int, int], list[Event]] = defaultdict(list)
    for one in events_in(events_of(run), (kind,)):
        by_key[one.a, one.b].append(one)
    return by_key


def _times(count: int) -> str:
    return {0: "never", 1: "once", 2: "twice"}.get(count, f"{count} times")
