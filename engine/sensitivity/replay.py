"""Simulate the balls of a scene from given states, for a given duration.

The kernel is the same as for shots of the scene. The other modules of this package use it to
measure how small differences between two states develop.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.state import FloatArray, Laws
from ghostball.engine.running.driver import warm_up
from ghostball.engine.running.from_scene import layout_of
from ghostball.engine.running.room import Limits, Room, shots_of
from ghostball.model import Scene

_T_MAX, _OUTER = Laws._fields.index("t_max"), Laws._fields.index("outer")

_LIMITS = Limits(10_000, 300_000)
"""Limits that no simulation between two events reaches: some two milliseconds of computing."""

_ENDS = st.RUN_RESTED, st.RUN_T_MAX


class Replay:
    """Balls of a scene, which can be simulated from any state."""

    def __init__(self, scene: Scene) -> None:
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
        laws = self._layout.laws.copy()
        laws[_T_MAX] = duration
        there = self._layout.obstacles
        if obstacles is not None:
            there = there[list(obstacles)]
            laws[_OUTER] = len(there)
        self._room.turn_to(replace(self._layout, laws=laws, obstacles=there))
        k, n, _ = starts.shape
        shots = shots_of(k, n, 3)._replace(starts=np.ascontiguousarray(starts))
        self._room.play_all(shots, np.arange(k), _LIMITS)
        shots.ends[~np.isin(shots.counts[:, st.STATUS], _ENDS)] = np.nan
        return shots.ends
