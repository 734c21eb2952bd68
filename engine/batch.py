"""Simulation of many scenes on all processors, with the results as arrays."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core import state as st
from ghostball.engine.running.from_scene import layout_of
from ghostball.engine.running.room import STATUS, Limits, Shots, shots_of
from ghostball.engine.running.threads import run_tasks, tasks_of_each
from ghostball.engine.shot import MAX_EVENTS, MAX_WORK, check_request
from ghostball.model import Scene
from ghostball.model.errors import GhostballError
from ghostball.model.events import Status
from ghostball.model.rounding import position_rounding

STATUSES = tuple(Status)
"""Meaning of the numbers in `Batch.status`, which are indices of this tuple."""


@dataclass(frozen=True, eq=False)
class Batch:
    """The results of k shots, as arrays.

    Attributes
    ----------
    status : (k,) int8
        How each run ended: an index of `ghostball.engine.STATUSES`; see `complete`.
    rest_times : (k,) float64 [s]
        Time when the last ball came to rest, or the run stopped.
    rest_positions : (k, n, 3) float64 [m]
        Final positions of the centres; if a scene has fewer than n balls, the other rows are NaN.
    ball_ball, ball_cushion, events : (k,) int64
        Numbers of ball-ball collisions, of cushion collisions, and of all events.
    """

    status: NDArray[np.int8]
    rest_times: NDArray[np.float64]
    rest_positions: NDArray[np.float64]
    ball_ball: NDArray[np.int64]
    ball_cushion: NDArray[np.int64]
    events: NDArray[np.int64]

    def __repr__(self) -> str:
        """Return the number of shots and how they ended, on one line."""
        k, n = self.rest_positions.shape[:2]
        return f"<Batch of {k} shots with up to {n} balls, {int(self.complete.sum())} complete>"

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Whether each run reached its natural end, (k,) bool."""
        return np.array([status.complete for status in STATUSES])[self.status]


def simulate_many(
    scenes: Sequence[Scene],
    *,
    threads: int | None = None,
    max_events: int = MAX_EVENTS,
    max_work: int = MAX_WORK,
) -> Batch:
    """Simulate scenes; each result is bit-identical to that of `simulate`.

    Parameters
    ----------
    scenes : sequence of k Scene
        They may differ in everything.
    threads : int or None
        Number of threads; None: one per processor. The results don't depend on it.
    max_events, max_work : int
        As for `simulate`, for each shot.

    Returns
    -------
    Batch

    Raises
    ------
    UnsupportedSceneError, GhostballError
        As for `simulate`, before anything is simulated.
    """
    workers = workers_of(threads)
    scenes = tuple(scenes)
    for scene in scenes:
        check_request(scene, "rest", max_events, max_work)
    layouts = [layout_of(scene) for scene in scenes]
    shots = shots_of(len(scenes), max((layout.count for layout in layouts), default=0), 1)
    shots.ends[:] = np.nan
    run_tasks(tasks_of_each(layouts, workers), shots, Limits(max_events, max_work), workers)
    return batch_of(shots, np.array([layout.smallest_radius for layout in layouts]))


def batch_of(shots: Shots, smallest: NDArray[np.float64] | float) -> Batch:
    """Return the results of shots that have been simulated.

    `smallest` [m]: the smallest radius in each shot, (k,), or one number for all.
    """
    resolved = position_rounding(1.0) * shots.clocks[:, st.FARTHEST] < smallest
    codes = np.empty(max(STATUS) + 1, dtype=np.int8)
    for code, status in STATUS.items():
        codes[code] = STATUSES.index(status)
    failed = np.int8(STATUSES.index(Status.FAILED))
    return Batch(
        np.where(resolved, codes[shots.counts[:, st.STATUS]], failed),
        shots.clocks[:, st.END].copy(),
        shots.ends[:, 0],
        *(shots.counts[:, [st.BALL_BALL, st.BALL_CUSHION, st.EVENTS]].T.copy()),
    )


def workers_of(threads: int | None) -> int:
    """Return the number of threads; by default, the number of processors."""
    if threads is None:
        affinity = getattr(os, "sched_getaffinity", None)
        return len(affinity(0)) if affinity else os.cpu_count() or 1
    if not isinstance(threads, int) or isinstance(threads, bool) or threads < 1:
        raise GhostballError(f"`threads` must be a whole number of at least 1, got {threads!r}")
    return threads
