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
from ghostball.engine.running.calls import Limits, memory_for, play_all, shots_of
from ghostball.engine.running.driver import KernelRun, warm_up
from ghostball.engine.running.from_scene import SceneLayout, blank_block
from ghostball.model import ExactTrajectory, Scene

_OUTER = Laws._fields.index("outer")

_LIMITS = Limits(4_000, 300_000)
"""Limits that no simulation between two events reaches: some two milliseconds of computing.

Recorded with all powers of the time, the motion of two balls over 4000 events takes 7 MB.
"""

_ENDS = st.RUN_RESTED, st.RUN_T_MAX


def states_after(layout: SceneLayout, starts: FloatArray, duration: float) -> FloatArray:
    """Return the states of the balls of k shots after a duration, (k, 3, n, 3).

    The second axis has positions [m], velocities [m/s] and angular velocities [rad/s]. A ball that
    is in a pocket, or off the table, has its position there. All numbers of a shot are NaN if the
    shot reached a limit or failed.

    `starts` (k, n, START_COLUMNS): the state of each ball at the start; see `event_loop.play`.
    `duration` [s].
    """
    warm_up(layout.variant)
    k, n, _ = starts.shape
    shots = shots_of(k, n, 3)._replace(starts=np.ascontiguousarray(starts))
    play_all(layout.ending(duration), memory_for(layout), shots, np.arange(k), _LIMITS)
    shots.ends[~np.isin(shots.counts[:, st.STATUS], _ENDS)] = np.nan
    return shots.ends


def alone(layout: SceneLayout, balls: Sequence[int], obstacles: Sequence[int]) -> SceneLayout:
    """Return the layout of a scene on the cloth with some of its balls and rows of obstacles."""
    which = list(balls)
    laws = layout.laws.copy()
    laws[_OUTER] = len(obstacles)
    return replace(
        layout,
        block=blank_block(len(which), layout.variant).begun(layout.state[which], None),
        laws=laws,
        obstacles=layout.obstacles[list(obstacles)],
        radii=layout.radii[which],
    )


def motion_after(scene: Scene, start: FloatArray, duration: float) -> ReplayedMotion:
    """Return the motion of the balls of one shot up to a duration [s].

    `start` (n, START_COLUMNS): the state of each ball at the start.
    """
    run = KernelRun(scene, keep_log=True, start=start, t_max=duration)
    run.go(_LIMITS)
    trajectory = run.trajectory()
    assert trajectory is not None
    return ReplayedMotion(trajectory, math.inf if run.status.complete else run.t_end)


class ReplayedMotion(NamedTuple):
    """The motion of the balls of one shot, known until a time [s]: the run may have stopped."""

    trajectory: ExactTrajectory
    known_until: float

    def states(self, times: FloatArray) -> FloatArray:
        """Return the states at k times, (k, 3, n, 3), as `states_after`; NaN if unknown."""
        states = np.stack(self.trajectory.sample(times), axis=1)
        states[times > self.known_until] = np.nan
        return states
