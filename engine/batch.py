"""Simulation of many scenes on all processors, with the results as arrays."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core import state as st
from ghostball.engine.running.calls import STATUS, Limits, Shots, shots_of
from ghostball.engine.running.from_scene import layout_of
from ghostball.engine.running.threads import run_tasks, tasks_of_each
from ghostball.engine.shot import MAX_EVENTS, MAX_WORK, check_request
from ghostball.engine.strokes import DrawnStrokes
from ghostball.model import Scene, SceneError
from ghostball.model.errors import GhostballError
from ghostball.model.events import Status
from ghostball.model.rounding import position_rounding
from ghostball.model.scene.messages import refusal

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
    pocketed : (k, n) int64
        Index of the pocket that each ball fell into, or -1.
    pocketed_at : (k, n) float64 [s]
        When each ball fell into its pocket; NaN if it didn't.
    off_table : (k, n) bool
        Whether each ball left the table other than into a pocket.
    first_contact : (k, n) int64
        The first ball that each ball hits, or -1; `first_contact[:, 0]` if ball 0 is the cue ball.
        If a ball hits several balls at the same time, this is the one whose event comes first.
    cushions_before : (k, n) int64
        Number of cushion collisions of each ball before its first contact; all of its cushion
        collisions if it hits no ball.
    ball_cushions : (k, n) int64
        Number of cushion collisions of each ball.
    scenes : tuple of k Scene, or of one scene for all shots
    strokes : DrawnStrokes or None
        The strokes that were played, with their noise, if strokes were given.

    Notes
    -----
    The engine counts these outcomes while it simulates, so no events are recorded. If a scene has
    fewer than n balls, its other balls have -1, NaN, False and 0.
    """

    status: NDArray[np.int8]
    rest_times: NDArray[np.float64]
    rest_positions: NDArray[np.float64]
    ball_ball: NDArray[np.int64]
    ball_cushion: NDArray[np.int64]
    events: NDArray[np.int64]
    pocketed: NDArray[np.int64]
    pocketed_at: NDArray[np.float64]
    off_table: NDArray[np.bool_]
    first_contact: NDArray[np.int64]
    cushions_before: NDArray[np.int64]
    ball_cushions: NDArray[np.int64]
    scenes: tuple[Scene, ...] = field(repr=False)
    strokes: DrawnStrokes | None = None

    def __repr__(self) -> str:
        """Return the number of shots and how they ended, on one line."""
        k, n = self.rest_positions.shape[:2]
        return f"<Batch of {k} shots with up to {n} balls, {int(self.complete.sum())} complete>"

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Whether each run reached its natural end, (k,) bool."""
        return np.array([status.complete for status in STATUSES])[self.status]

    @property
    def gone(self) -> NDArray[np.bool_]:
        """Whether each ball was pocketed or left the table, (k, n) bool."""
        return (self.pocketed >= 0) | self.off_table

    def scene(
        self,
        i: int,
        *,
        name: str | None = None,
        changes: Mapping[str, Mapping[str, Any]] | None = None,
        **fields: Any,
    ) -> Scene:
        """Make the scene of the next shot after shot i, as `Scene.after` does.

        Parameters
        ----------
        i : int
            Index of the shot, from 0.
        name, changes, **fields
            As for `Scene.after`.

        Returns
        -------
        Scene

        Raises
        ------
        GhostballError
            If there is no shot i.
        SceneError
            As `Scene.after`; for example if a ball isn't at rest.
        """
        k = len(self.status)
        if not isinstance(i, int | np.integer) or isinstance(i, bool) or not 0 <= i < k:
            raise GhostballError(
                f"`i` must be the index of a shot, 0 to {k - 1}, got {i!r}"
                if k
                else "a batch without shots has no next scene"
            )
        scene = self.scenes[i if len(self.scenes) > 1 else 0]
        n, status = len(scene.balls), STATUSES[self.status[i]]
        ended = _EndedShot("ghostball", scene, status, self.rest_positions[i, :n], self.gone[i, :n])
        try:
            return Scene.after(ended, name=name, changes=changes, **fields)
        except SceneError as error:
            raise refusal(f"shot {i}: {error}") from None

    def to_frame(self, cue: int | str = 0) -> Any:
        """Return a polars data frame with one row per shot.

        Parameters
        ----------
        cue : int or str
            Index or id of the cue ball, whose columns are `first_contact` and `cushions_before`.

        Returns
        -------
        polars.DataFrame
            The columns are the attributes; `status` is text such as "rest". Each column of one
            value per ball is a fixed-size array. If strokes were given, their fields and `draws`
            are columns, too. `.write_parquet(path)` writes the frame as Parquet.

        Raises
        ------
        GhostballError
            If polars isn't installed, if the batch has no shots, or if there is no ball `cue`.
        """
        try:
            import polars  # noqa: PLC0415 - an optional dependency
        except ImportError:
            raise GhostballError(
                "a data frame needs polars, which isn't installed. Install it with `pip install "
                "'.[frames]'` in a clone of Ghostball"
            ) from None
        k = len(self.status)
        if k == 0:
            raise GhostballError("a data frame needs at least one shot, but this batch has none")
        who = np.array([scene.index_of(cue, "cue") for scene in self.scenes])
        skipped = ("scenes", "strokes")
        columns = {name: value for name, value in vars(self).items() if name not in skipped}
        for name in ("first_contact", "cushions_before"):
            columns[name] = columns[name][np.arange(k), who]
        if self.strokes is not None:
            columns |= {**self.strokes.aims._asdict(), "draws": self.strokes.draws}
        names = np.array([status.name.lower().replace("_", "-") for status in STATUSES])
        return polars.DataFrame(columns | {"status": names[self.status].astype(object)})


class _EndedShot(NamedTuple):
    """A shot of a batch, for `Scene.after`."""

    engine: str
    scene: Scene
    status: Status
    rest_positions: NDArray[np.float64]
    gone: NDArray[np.bool_]


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
    return batch_of(shots, np.array([layout.smallest_radius for layout in layouts]), scenes)


def batch_of(
    shots: Shots,
    smallest: NDArray[np.float64] | float,
    scenes: tuple[Scene, ...],
    strokes: DrawnStrokes | None = None,
) -> Batch:
    """Return the results of shots that have been simulated.

    `smallest` [m]: the smallest radius in each shot, (k,), or one number for all.
    `scenes`, `strokes`: as in `Batch`.
    """
    resolved = position_rounding(1.0) * shots.clocks[:, st.FARTHEST] < smallest
    k, n = shots.ends.shape[0], shots.ends.shape[2]
    codes = np.empty(max(STATUS) + 1, dtype=np.int8)
    for code, status in STATUS.items():
        codes[code] = STATUSES.index(status)
    failed = np.int8(STATUSES.index(Status.FAILED))
    ball_ball, ball_cushion, events = shots.counts[:, [st.BALL_BALL, st.BALL_CUSHION, st.EVENTS]].T
    outcomes = shots.counts[:, st.COUNTERS :].reshape(k, n, st.OUTCOMES)
    cushions, first, before, left = np.moveaxis(outcomes, 2, 0)
    return Batch(
        status=np.where(resolved, codes[shots.counts[:, st.STATUS]], failed),
        rest_times=shots.clocks[:, st.END].copy(),
        rest_positions=shots.ends[:, 0],
        ball_ball=ball_ball.copy(),
        ball_cushion=ball_cushion.copy(),
        events=events.copy(),
        pocketed=np.where(left > 0, left - 1, -1),
        pocketed_at=np.where(left > 0, shots.clocks[:, st.CLOCKS :], np.nan),
        off_table=left < 0,
        first_contact=first - 1,
        cushions_before=np.where(first > 0, before, cushions),
        ball_cushions=cushions.copy(),
        scenes=scenes,
        strokes=strokes,
    )


def workers_of(threads: int | None) -> int:
    """Return the number of threads; by default, the number of processors."""
    if threads is None:
        affinity = getattr(os, "sched_getaffinity", None)
        return len(affinity(0)) if affinity else os.cpu_count() or 1
    if not isinstance(threads, int) or isinstance(threads, bool) or threads < 1:
        raise GhostballError(f"`threads` must be a whole number of at least 1, got {threads!r}")
    return threads
