"""The recorder of a time-stepping engine, which creates its `Result`."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from ghostball.model import (
    COLLISION_KINDS,
    EVENT_DTYPE,
    EventKind,
    Record,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    Status,
    rolling_angular_velocity,
)
from ghostball.model.arrays import FloatArray

FRAME_INTERVAL = 0.002
"""Shortest time between two recorded frames [s], except at events.

60 s of 16 balls then fit in 35 MB.
"""


class Recorder:
    """Records events and frames of one run, as far as `record` requires.

    Call `start` when the world has been built, `event` and `frame` during the run, `result` at the
    end.
    """

    def __init__(self, scene: Scene, record: Record) -> None:
        self.scene = scene
        self.record = record
        self._events: list[tuple[float, int, int, int]] = []
        self._counts = dict.fromkeys((kind.label for kind in COLLISION_KINDS), 0)
        self._frames: list[tuple[float, FloatArray, FloatArray, FloatArray]] = []
        self._last = -math.inf  # time of the last frame [s]
        self._event_since_frame = False
        self._started = time.perf_counter()

    def start(self) -> None:
        """Start the clock of `wall_time`."""
        self._started = time.perf_counter()

    def event(self, t: float, kind: EventKind, a: int, b: int = -1) -> None:
        """Record an event; `b` is the second ball, the index of the obstacle, or -1."""
        if kind.label in self._counts:
            self._counts[kind.label] += 1
        self._event_since_frame = True
        if self.record != "rest":
            if kind is EventKind.BALL_BALL and b < a:
                a, b = b, a
            self._events.append((t, int(kind), a, b))

    def wants_frame(self, t: float) -> bool:
        """Return whether a frame at `t` would be kept; ask before an expensive computation."""
        return self.record == "trajectory" and (
            self._event_since_frame or t - self._last >= FRAME_INTERVAL * (1.0 - 1e-9)
        )

    def frame(self, t: float, state: Samples, *, force: bool = False) -> None:
        """Store a copy of a frame, arrays (1, n, 3), if one is due or `force` is True."""
        if self.record == "trajectory" and (force or self.wants_frame(t)):
            x, v, w = (np.array(one[0]) for one in state)
            self._frames.append((t, x, v, w))
            self._last, self._event_since_frame = t, False

    def result(
        self,
        *,
        engine: str,
        settings: Mapping[str, Any],
        status: Status,
        final_state: Samples,
        rest_time: float,
        work: Mapping[str, int],
        engine_time: float | None = None,
        reason: str = "",
    ) -> Result:
        """Stop the clock and return the result of the run; `final_state` is its last frame."""
        wall_time = time.perf_counter() - self._started
        trajectory = None
        if self.record == "trajectory":
            self.frame(rest_time, final_state, force=True)
            times, *states = zip(*self._frames, strict=True)
            trajectory = SampledTrajectory(np.array(times), *(np.array(s) for s in states))
        events = None
        if self.record != "rest":
            events = np.array(self._events, dtype=EVENT_DTYPE)
            events = events[np.argsort(events["t"], kind="stable")]
        return Result(
            engine=engine,
            settings=settings,
            scene=self.scene,
            status=status,
            final_state=final_state,
            rest_time=rest_time,
            collision_counts=self._counts,
            work=work,
            wall_time=wall_time,
            # An estimate from a sample of the steps; if these are slower than the other steps, the
            # estimate can exceed the time of the whole run.
            engine_time=None if engine_time is None else min(engine_time, wall_time),
            events=events,
            trajectory=trajectory,
            reason=reason,
        )


def rolling_state(positions: FloatArray, velocities: FloatArray, radii: FloatArray) -> Samples:
    """Return the state of balls that roll on the cloth, arrays (k, n, 3).

    `positions`, `velocities`: (k, n, 2) float64 [m], [m/s].
    `radii`: (n,) float64 [m].
    """
    centres = np.empty((*positions.shape[:2], 3))
    centres[..., :2], centres[..., 2] = positions, radii
    spatial = np.zeros_like(centres)
    spatial[..., :2] = velocities
    return Samples(centres, spatial, rolling_angular_velocity(spatial, radii))
