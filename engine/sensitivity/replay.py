"""Simulate the balls of a scene from given states, for a given duration.

The kernel is the same as for shots of the scene. The other modules of this package use it to
measure how small differences between two states develop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.state import FloatArray, Laws
from ghostball.engine.running.driver import KernelRun, warm_up
from ghostball.engine.running.from_scene import layout_of
from ghostball.engine.running.room import Limits, Room, shots_of
from ghostball.model import ExactTrajectory, Scene

_OUTER = Laws._fields.index("outer")

_LIMITS = Limits(4_000, 300_000)
"""Limits that no simulation between two events reaches: some two milliseconds of computing.

Recorded with all powers of the time, the motion of two balls over 4000 events takes 7 MB.
"""

_ENDS = st.RUN_RESTED, st.RUN_T_MAX


class Replay:
    """Balls of a scene, which can be simulated from any state."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._layout = layout_of(scene)
        warm_up(self._layout.variant)
        self._room = Room(self._layout)

    @property
    def count(self) -> int:
        """Number of balls."""
        return self._layout.count

    def after(
        self, starts: FloatArray, duration: float, obstacles: Sequence[int] | None = None
    ) -> FloatArray:
        """Return the states of the balls of k shots after a duration, (k, 3, n, 3).

        The second axis has positions [m], velocities [m/s] and angular velocities [rad/s]. A ball
        that is in a pocket, or off the table, has its position there. All numbers of a shot are NaN
        if the shot reached a limit or failed.

        `starts` (k, n, START_COLUMNS): the state of each ball at the start; see `event_loop.play`.
        `duration` [s].
        `obstacles`: rows of the scene's obstacles that the balls can meet; None: all rows.
        """
        layout = self._layout.ending(duration)
        if obstacles is not None:
            there = layout.obstacles[list(obstacles)]
            layout.laws[_OUTER] = len(there)
            layout = replace(layout, obstacles=there)
        self._room.turn_to(layout)
        k, n, _ = starts.shape
        shots = shots_of(k, n, 3)._replace(starts=np.ascontiguousarray(starts))
        self._room.play_all(shots, np.arange(k), _LIMITS)
        shots.ends[~np.isin(shots.counts[:, st.STATUS], _ENDS)] = np.nan
        return shots.ends

    def motion(self, start: FloatArray, duration: float) -> ReplayedMotion:
        """Return the motion of the balls of one shot up to a duration [s].

        `start` (n, START_COLUMNS): the state of each ball at the start.
        """
        run = KernelRun(self._scene, keep_log=True, start=start, t_max=duration)
        run.go(_LIMITS)
        trajectory = run.trajectory()
        assert trajectory is not None
        return ReplayedMotion(trajectory, math.inf if run.status.complete else run.t_end)


class ReplayedMotion(NamedTuple):
    """The motion of the balls of one shot, known until a time [s]: the run may have stopped."""

    trajectory: ExactTrajectory
    known_until: float

    def states(self, times: FloatArray) -> FloatArray:
        """Return the states at k times, (k, 3, n, 3), as `Replay.after`; NaN if unknown."""
        states = np.stack(self.trajectory.sample(times), axis=1)
        states[times > self.known_until] = np.nan
        return states
