"""Many shots at once, on all processors, their results as arrays."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Event

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic_core import PydanticCustomError

from ghostball.engine.core import state as st
from ghostball.engine.running import room, sweep_driver
from ghostball.engine.running.driver import Run, warm_up
from ghostball.engine.running.from_scene import layout_of, phases_of
from ghostball.engine.shot import MAX_EVENTS, MAX_WORK, check_request
from ghostball.model import Ball, Scene, rolling_angular_velocity
from ghostball.model.errors import GhostballError, SceneError
from ghostball.model.events import Status
from ghostball.model.rounding import position_rounding
from ghostball.model.scene.messages import refusal
from ghostball.model.scene.motion_rules import Motions, check_motions

STATUSES = tuple(Status)
"""What the numbers in `Batch.status` mean: indices of this."""

_SCENES_AT_ONCE = 64
"""Most scenes that a thread takes at a time: to hand over each alone took as long as to play it."""


@dataclass(frozen=True, eq=False)
class Batch:
    """What became of k shots; where scenes have fewer balls than n, NaN fills the rest.

    Attributes
    ----------
    status : (k,) int8
        How each run ended: an index of `STATUSES`.
    rest_times : (k,) float64 [s]
        When the last ball came to rest, or the run stopped.
    rest_positions : (k, n, 3) float64 [m]
        Centres when the run ended.
    ball_ball, ball_cushion, events : (k,) int64
        Impacts of two balls, impacts on cushions, all events.
    """

    status: NDArray[np.int8]
    rest_times: NDArray[np.float64]
    rest_positions: NDArray[np.float64]
    ball_ball: NDArray[np.int64]
    ball_cushion: NDArray[np.int64]
    events: NDArray[np.int64]

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
    """Simulate scenes, each as `simulate` would, to the bit.

    Parameters
    ----------
    scenes : sequence of k Scene
        They may differ in everything.
    threads : int or None
        How many work at once; None: one per processor. The results don't depend on it.
    max_events, max_work : int
        As for `simulate`, for each.

    Returns
    -------
    Batch

    Raises
    ------
    UnsupportedSceneError, GhostballError
        As `simulate`, before anything is simulated.
    """
    workers = _workers(threads)
    scenes = tuple(scenes)
    for scene in scenes:
        check_request(scene, "rest", max_events, max_work)
    limits = room.Limits(max_events, max_work)

    for variant in {layout_of(scene).variant for scene in scenes}:
        warm_up(variant)  # with contacts when a scene turns out to need them
    most = max((len(scene.balls) for scene in scenes), default=0)
    rest = np.full((len(scenes), most, 3), np.nan)
    times, counts = np.empty(len(scenes)), np.zeros((len(scenes), 3), dtype=np.int64)
    status = np.empty(len(scenes), dtype=np.int8)
    stop = Event()

    def simulate_part(part: range) -> None:
        for k in part:
            if stop.is_set():
                return
            run = Run(scenes[k], keep_log=False)
            run.go(limits, stop)
            rest[k, : len(scenes[k].balls)] = run.final_state().positions[0]
            times[k] = run.t_end
            counts[k] = run.counts()
            status[k] = STATUSES.index(run.status)

    size = max(1, min(_SCENES_AT_ONCE, len(scenes) // (4 * workers)))
    parts = [range(k, min(k + size, len(scenes))) for k in range(0, len(scenes), size)]
    with ThreadPoolExecutor(workers) as pool:
        try:
            for _ in pool.map(simulate_part, parts):
                pass
        except KeyboardInterrupt:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)
            raise
    return Batch(status, times, rest, *counts.T)


def simulate_sweep(
    scene: Scene,
    speeds: ArrayLike,
    angles: ArrayLike,
    *,
    ball: int = 0,
    threads: int | None = None,
    max_events: int = MAX_EVENTS,
    max_work: int = MAX_WORK,
) -> Batch:
    """Simulate one scene with one ball shot at each of k speeds and angles.

    Parameters
    ----------
    scene : Scene
        Its ball `ball` is shot; if that has an angular velocity of its own, it is turned with the
        direction and scaled with the speed, so that the tip would hit the same spot. Else it rolls.
        Where it is shot upwards, that velocity is scaled with the speed, too.
    speeds : (k,) float64 [m/s], or one number for all; more than 0
        Over the cloth.
    angles : (k,) float64 [rad], or one number for all; from the x axis, counterclockwise
    ball : int
        Index of the ball that is shot.
    threads, max_events, max_work
        As for `simulate_many`.

    Returns
    -------
    Batch
        The results of `simulate` on such scenes, to the bit; sooner, since no scene is built.

    Raises
    ------
    UnsupportedSceneError, GhostballError
        Where the scene, or an argument, is wrong; SceneError where one with such a shot would be.
    """
    workers = _workers(threads)
    check_request(scene, "rest", max_events, max_work)
    with np.errstate(over="ignore", invalid="ignore"):  # what isn't finite is refused by the rules
        velocity, spin = _cue_motions(scene, speeds, angles, ball)
    _check_shots(scene, ball, velocity, spin)
    layout, shot = layout_of(scene), scene.balls[ball]
    rises = (velocity[:, 2] > 0.0) | (shot.position[2] > shot.radius)
    phases = phases_of(scene.rolls[ball], rises, scene.physics.motion == "sliding")
    shots = room.shots_of(len(velocity), len(scene.balls), 1)._replace(
        motions=np.column_stack((velocity, spin, phases))
    )
    sweep_driver.run_sweep(scene, ball, shots, room.Limits(max_events, max_work), workers)
    resolved = position_rounding(1.0) * shots.clocks[:, st.FARTHEST] < layout.smallest_radius
    codes = np.empty(max(room.STATUS) + 1, dtype=np.int8)
    for code, status in room.STATUS.items():
        codes[code] = STATUSES.index(status)
    failed = np.int8(STATUSES.index(Status.FAILED))
    return Batch(
        np.where(resolved, codes[shots.counts[:, st.STATUS]], failed),
        shots.clocks[:, st.END].copy(),
        shots.ends[:, 0],
        *(shots.counts[:, [st.BALL_BALL, st.BALL_CUSHION, st.EVENTS]].T.copy()),
    )


def _workers(threads: int | None) -> int:
    """Return how many threads work: as many as there are processors, where it isn't given."""
    if threads is None:
        affinity = getattr(os, "sched_getaffinity", None)
        return len(affinity(0)) if affinity else os.cpu_count() or 1
    if not isinstance(threads, int) or isinstance(threads, bool) or threads < 1:
        raise GhostballError(f"`threads` must be a whole number of at least 1, got {threads!r}")
    return threads


def _cue_motions(
    scene: Scene, speeds: ArrayLike, angles: ArrayLike, ball: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return velocities (k, 3) and angular velocities (k, 3) of the ball that is shot."""
    n = len(scene.balls)
    if not isinstance(ball, int) or isinstance(ball, bool) or not 0 <= ball < n:
        raise GhostballError(f"`ball` must be the index of a ball, 0 to {n - 1}, got {ball!r}")
    speed, angle = _numbers("speeds", speeds), _numbers("angles", angles)
    if len(speed) != len(angle) and 1 not in (len(speed), len(angle)):
        raise GhostballError(
            f"`speeds` and `angles` must have the same length, or one of them length 1, got "
            f"{len(speed)} and {len(angle)}. For a grid, give all pairs: numpy.meshgrid, raveled"
        )
    if np.any(speed <= 0.0):
        raise GhostballError(f"`speeds` must be more than 0 m/s, got {speed[speed <= 0.0][0]}")
    speed, angle = np.broadcast_arrays(speed, angle)
    velocity = np.zeros((len(speed), 3))
    velocity[:, 0], velocity[:, 1] = speed * np.cos(angle), speed * np.sin(angle)
    shot = scene.balls[ball]
    over_cloth = math.hypot(*shot.velocity[:2])
    if over_cloth == 0.0 and shot.velocity[2] != 0.0:
        raise GhostballError(
            f'ball "{shot.id}" goes straight up or down, so its velocity can\'t be turned or '
            "scaled. Give it a velocity over the cloth, too"
        )
    if shot.velocity[2] != 0.0:
        velocity[:, 2] = speed / over_cloth * shot.velocity[2]
    if shot.angular_velocity is None:
        return velocity, rolling_angular_velocity(velocity, np.array(shot.radius))
    if over_cloth == 0.0:
        raise GhostballError(
            f"ball \"{shot.id}\" spins but doesn't move, so its spin can't be turned with the "
            "direction. Give it a velocity, or leave out its angular velocity"
        )
    factor = speed / over_cloth
    turn = angle - np.arctan2(shot.velocity[1], shot.velocity[0])
    wx, wy, wz = shot.angular_velocity
    spin = np.empty_like(velocity)
    spin[:, 0] = factor * (np.cos(turn) * wx - np.sin(turn) * wy)
    spin[:, 1] = factor * (np.sin(turn) * wx + np.cos(turn) * wy)
    spin[:, 2] = factor * wz
    return velocity, spin


def _check_shots(
    scene: Scene, ball: int, velocity: NDArray[np.float64], spin: NDArray[np.float64]
) -> None:
    """Refuse a shot that a scene with it would be refused for: by the rules of scenes themselves.

    What a single number may be is a range, so that the largest of all is the one to be asked about.
    """
    if len(velocity) == 0:
        return
    shot = scene.balls[ball]
    fields = shot.model_dump()
    given = np.full(len(velocity), shot.angular_velocity is not None)
    for name, vectors in (("velocity", velocity), ("angular_velocity", spin)):
        if name == "velocity" or given[0]:
            k = int(np.argmax(np.max(np.abs(vectors), axis=1)))  # the first NaN, if there is one
            try:
                Ball(**{**fields, name: tuple(vectors[k].tolist())})
            except SceneError as error:
                raise refusal(f"shot {k} of `balls[{ball}]`: {error}") from None
    rolling = rolling_angular_velocity(velocity, np.array(shot.radius))
    who = np.full(len(velocity), ball)
    try:
        check_motions(scene, Motions(who, velocity, spin, rolling, given, in_sweep=True))
    except PydanticCustomError as error:
        raise refusal(error.message()) from None


def _numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return `values` as a checked array (k,)."""
    try:
        array = np.atleast_1d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        raise GhostballError(f"`{name}` must be numbers, got {values!r}") from None
    if array.ndim != 1:
        raise GhostballError(f"`{name}` must be one-dimensional, got shape {array.shape}")
    wrong = array[~np.isfinite(array)]
    if len(wrong):
        raise GhostballError(f"`{name}` must be finite, got {wrong[0]}")
    return array
