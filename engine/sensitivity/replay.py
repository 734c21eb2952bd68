"""Plays balls of a scene on from states that are given, for a time that is given.

By the kernel that plays its shots: what a shot does next to states that differ by little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.state import FloatArray, Laws
from ghostball.engine.running.driver import warm_up
from ghostball.engine.running.from_scene import layout_of, log_of
from ghostball.engine.running.room import Limits, Room, shots_of
from ghostball.model import Scene

_T_MAX, _OUTER = Laws._fields.index("t_max"), Laws._fields.index("outer")

_LIMITS = Limits(10_000, 300_000)
"""No time between two events takes as much: a millisecond or two."""

_ENDS = st.RUN_RESTED, st.RUN_T_MAX


class Replay:
    """The balls of a scene, which can be played on from any state."""

    def __init__(self, scene: Scene) -> None:
        self._layout = layout_of(scene)
        warm_up(self._layout.variant)
        self._room = Room(self._layout)
        self._log = log_of(0, self._layout.count)

    @property
    def count(self) -> int:
        """Number of balls."""
        return self._layout.count

    def after(
        self, starts: FloatArray, duration: float, obstacles: Sequence[int] | None = None
    ) -> FloatArray:
        """Return how the balls move some time later: k shots, (k, 3, n, 3).

        Positions [m], velocities [m/s], angular velocities [rad/s]; of a ball that is gone, where
        it is. NaN where a shot comes to no end.

        `starts` (k, n, START_COLUMNS): see `event_loop.play`.
        `duration` [s].
        `obstacles`: rows of those that are there; None: all.
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
        which, first = np.arange(k), 0
        while first < k:
            first = self._room.play(
                shots, which, first, False, self._log, _LIMITS, budget=2 * _LIMITS.work
            )
        shots.ends[~np.isin(shots.counts[:, st.STATUS], _ENDS)] = np.nan
        return shots.ends
