"""Right shots of Ghostball's engine, reported with one fault each; see `wrong_engines`.

Each function simulates a scene and returns the run, with the motion in frames, or returns such a
function.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import (
    COLLISION_KINDS,
    EventKind,
    Events,
    Phase,
    Result,
    SampledTrajectory,
    Scene,
    initial_state,
)

FloatArray = NDArray[np.float64]
Play = Callable[[Scene], Result]

FRAMES = 500
"""Number of frames of a run, in addition to frames at events."""


def right(scene: Scene) -> Result:
    """Simulate a scene without a fault."""
    return framed(simulate(scene, record="trajectory"))


def framed(result: Result, after: float = 0.0) -> Result:
    """Return a run with its motion in frames, with frames just before and at each event.

    While balls push each other in impacts that last, there are no frames, because the recorded
    velocities are means there.

    `after` [s]: duration of the frames after the end.
    """
    events = events_in(result)
    grid = np.linspace(0.0, result.rest_time + after, FRAMES + 1)
    before = np.maximum(np.nextafter(events["t"], 0.0), 0.0)
    times = np.unique(np.concatenate([grid, events["t"], before]))
    if result.scene.physics.impacts == "compliant":
        times = times[~np.any(result.phases(times) == Phase.COMPRESSED, axis=1)]
    return replace(result, trajectory=SampledTrajectory(times, *result.sample(times)))


def events_in(result: Result) -> Events:
    """Return the events of a run that recorded them."""
    assert result.events is not None
    return result.events


def frames_of(result: Result) -> SampledTrajectory:
    """Return the motion of a run in frames."""
    assert isinstance(result.trajectory, SampledTrajectory)
    return result.trajectory


def states_of(frames: SampledTrajectory) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return positions, velocities and angular velocities of frames, (k, n, 3) each."""
    return frames.positions, frames.velocities, frames.angular_velocities


def with_frames(result: Result, **states: FloatArray) -> Result:
    """Return a run with changed states in its frames, (k, n, 3) each."""
    return replace(result, trajectory=replace(frames_of(result), **states))


def with_end(result: Result, **states: FloatArray) -> Result:
    """Return a run with a changed final state, (n, 3) each; the frames are unchanged."""
    end = {name: array[np.newaxis] for name, array in states.items()}
    return replace(result, final_state=result.final_state._replace(**end))


def with_events(result: Result, events: Events) -> Result:
    """Return a run with the given events, in order of time, and with their counts."""
    ordered = events[np.argsort(events["t"], kind="stable")]
    counts = {kind.label: int(np.sum(ordered["kind"] == kind)) for kind in COLLISION_KINDS}
    return replace(result, events=ordered, collision_counts=counts)


def collisions_of(result: Result) -> NDArray[np.intp]:
    """Return which events of a run are collisions."""
    return np.flatnonzero(np.isin(events_in(result)["kind"], COLLISION_KINDS))


# --- events, times and counts


def late(by: float, *kinds: EventKind) -> Play:
    """Report events of some kinds late [s], or all; the motion is right."""

    def play(scene: Scene) -> Result:
        result = with_late_events(right(scene), by, kinds or EventKind)
        end = max(result.rest_time, float(np.max(events_in(result)["t"])))
        return resting_at(result, end)

    return play


def with_late_events(
    result: Result, by: float, kinds: Iterable[EventKind] = COLLISION_KINDS
) -> Result:
    """Return a run whose events of some kinds are late [s]."""
    events = events_in(result).copy()
    events["t"][np.isin(events["kind"], list(kinds))] += by
    return with_events(result, events)


def rests_late(by: float) -> Play:
    """Report a late rest time, by `by` [s]; the events are right."""

    def play(scene: Scene) -> Result:
        result = right(scene)
        return resting_at(result, result.rest_time + by)

    return play


def rests_late_but_the_last(by: float) -> Play:
    """Report that balls come to rest late [s], but not later than the last ball."""

    def play(scene: Scene) -> Result:
        result = right(scene)
        events = events_in(result).copy()
        rests = events["kind"] == EventKind.ROLL_TO_REST
        events["t"][rests] = np.minimum(events["t"][rests] + by, result.rest_time)
        return with_events(result, events)

    return play


def rests_again(scene: Scene) -> Result:
    """Report each rest before the end twice: at the right time, and at the end of the run."""
    result = right(scene)
    events = events_in(result)
    again = events[(events["kind"] == EventKind.ROLL_TO_REST) & (events["t"] < result.rest_time)]
    again["t"] = result.rest_time
    return with_events(result, np.concatenate([events, again]))


def resting_at(result: Result, end: float) -> Result:
    """Return a run with the rest time `end` [s]; the last sample is moved to this time."""
    frames = frames_of(result)
    motion = replace(frames, times=np.append(frames.times[:-1], end))
    return replace(result, trajectory=motion, rest_time=end)


def in_milliseconds(scene: Scene) -> Result:
    """Report times in milliseconds in place of seconds; velocities are right."""
    result = right(scene)
    events, frames = events_in(result).copy(), frames_of(result)
    events["t"] *= 1e3
    motion = replace(frames, times=1e3 * frames.times)
    return replace(result, events=events, trajectory=motion, rest_time=1e3 * result.rest_time)


def waits(scene: Scene) -> Result:
    """Start the shot 10 ms late."""
    result, delay = right(scene), 0.01
    events, frames = events_in(result).copy(), frames_of(result)
    events["t"] += delay
    still = SampledTrajectory(
        np.append(0.0, delay + frames.times),
        *(np.concatenate([states[:1], states]) for states in states_of(frames)),
    )
    return replace(result, events=events, trajectory=still, rest_time=result.rest_time + delay)


def without_first_collision(scene: Scene) -> Result:
    """Leave the first collision out of the events."""
    result = right(scene)
    return with_events(result, np.delete(events_in(result), collisions_of(result)[0]))


def first_collision_twice(scene: Scene) -> Result:
    """Report the first collision twice."""
    result = right(scene)
    first = collisions_of(result)[0]
    return with_events(result, np.insert(events_in(result), first, events_in(result)[first]))


def without_collisions(scene: Scene) -> Result:
    """Report no collision at all."""
    result = right(scene)
    return with_events(result, np.delete(events_in(result), collisions_of(result)))


def with_another_cushion(scene: Scene) -> Result:
    """Report the opposite cushion."""
    return _with_first(EventKind.BALL_CUSHION, scene, lambda event: {"b": event["b"] ^ 1})


def with_another_ball(scene: Scene) -> Result:
    """Report the last ball as the partner in the first collision of balls."""
    last = len(scene.balls) - 1
    return _with_first(EventKind.BALL_BALL, scene, lambda _: {"b": last})


def _with_first(kind: EventKind, scene: Scene, change: Callable[[Any], dict[str, int]]) -> Result:
    result = right(scene)
    events = events_in(result).copy()
    first = int(np.flatnonzero(events["kind"] == kind)[0])
    for name, value in change(events[first]).items():
        events[name][first] = value
    return with_events(result, events)


def with_swapped_collisions(scene: Scene) -> Result:
    """Report the first two collisions with exchanged times."""
    result = right(scene)
    events = events_in(result).copy()
    first, second = collisions_of(result)[:2]
    for name in ("kind", "a", "b"):
        events[name][[first, second]] = events[name][[second, first]]
    return with_events(result, events)


def with_another_count(scene: Scene) -> Result:
    """Report one more collision of each kind in the counts than in the events."""
    result = right(scene)
    counts = {kind: count + 1 for kind, count in result.collision_counts.items()}
    return replace(result, collision_counts=counts)


# --- final positions


def ends_moved(move: Callable[[FloatArray, Scene], FloatArray]) -> Play:
    """Report rest positions, (n, 3) [m], that differ from the end of the motion."""
    return lambda scene: with_moved_ends(right(scene), move)


def with_moved_ends(result: Result, move: Callable[[FloatArray, Scene], FloatArray]) -> Result:
    """Return a run with changed rest positions, (n, 3) [m]; the motion is unchanged."""
    return with_end(result, positions=move(result.rest_positions.copy(), result.scene))


def swapped(places: FloatArray, _: Scene) -> FloatArray:
    """Give each ball the position of the ball before it."""
    return np.roll(places, 1, axis=0)


def along_x(by: float) -> Callable[[FloatArray, Scene], FloatArray]:
    """Move each ball along x [m]."""
    return lambda places, _: places + np.array([by, 0.0, 0.0])


def mirrored(places: FloatArray, scene: Scene) -> FloatArray:
    """Mirror the positions at the middle of the table."""
    assert scene.table is not None
    return np.array([scene.table.length, 0.0, 0.0]) + places * np.array([-1.0, 1.0, 1.0])


def drifting(by: float) -> Play:
    """Let all balls drift along x by a given length [m] until the end."""

    def play(scene: Scene) -> Result:
        result = right(scene)
        share = frames_of(result).times / result.rest_time
        along = np.array([by, 0.0, 0.0])
        moved = frames_of(result).positions + share[:, np.newaxis, np.newaxis] * along
        return with_end(
            with_frames(result, positions=moved), positions=result.rest_positions + along
        )

    return play


def mirrored_table(scene: Scene) -> Result:
    """Swap the left and the right of the table after the start."""
    result = right(scene)
    frames, across = frames_of(result), np.array([-1.0, 1.0, 1.0])
    positions = np.array([mirrored(places, scene) for places in frames.positions])
    positions[0] = frames.positions[0]
    velocities = frames.velocities * across
    ended = with_end(result, positions=mirrored(result.rest_positions, scene))
    return with_frames(ended, positions=positions, velocities=velocities)


def falls_asleep(scene: Scene) -> Result:
    """Stop each ball as soon as it is slower than 5 cm/s, as solvers put bodies to sleep."""
    result = right(scene)
    frames = frames_of(result)
    positions, velocities = frames.positions.copy(), frames.velocities.copy()
    for ball in range(len(scene.balls)):
        fast = np.flatnonzero(np.linalg.norm(velocities[:, ball], axis=1) >= 0.05)
        after = fast[-1] + 1 if len(fast) else 0
        positions[after:, ball] = positions[after - 1, ball] if after else positions[0, ball]
        velocities[after:, ball] = 0.0
    asleep = with_frames(result, positions=positions, velocities=velocities)
    return with_end(asleep, positions=positions[-1])


def ends_early(scene: Scene) -> Result:
    """End the run after half of its time, and report that all balls rest."""
    return _cut(right(scene), 0.5)


def stops_late(scene: Scene) -> Result:
    """Stop all balls dead at 60 % of the shot."""
    ended = _cut(right(scene), 0.6)
    _, velocities, spins = (states.copy() for states in states_of(frames_of(ended)))
    velocities[-1] = spins[-1] = 0.0
    return with_frames(ended, velocities=velocities, angular_velocities=spins)


def _cut(result: Result, share: float) -> Result:
    """Return a run cut after a share of its time, with the report that all balls rest there."""
    frames, events = frames_of(result), events_in(result)
    kept = frames.times <= share * result.rest_time
    motion = SampledTrajectory(frames.times[kept], *(states[kept] for states in states_of(frames)))
    ended = with_events(result, events[events["t"] <= motion.t_end])
    ended = replace(ended, trajectory=motion, rest_time=motion.t_end)
    return with_end(ended, positions=motion.positions[-1])


def stops_at_once(scene: Scene) -> Result:
    """Stop all balls dead after 20 ms, before anything happens."""
    start, end = initial_state(scene), 0.02
    still = np.zeros_like(start.velocities)
    moved = start.positions + end * start.velocities
    frames = SampledTrajectory(
        np.array([0.0, end]),
        np.concatenate([start.positions, moved]),
        np.concatenate([start.velocities, still]),
        np.concatenate([start.angular_velocities, still]),
    )
    ended = replace(right(scene), trajectory=frames, rest_time=end)
    ended = with_events(ended, events_in(ended)[:0])
    return with_end(ended, positions=moved[0], velocities=still[0], angular_velocities=still[0])


def moves_at_rest(scene: Scene) -> Result:
    """Report that all balls rest while one still moves at 5 cm/s."""
    result = right(scene)
    velocities = result.final_state.velocities[0].copy()
    velocities[0, 0] = 0.05
    moving = frames_of(result).velocities.copy()
    moving[-1, 0, 0] = 0.05
    return with_end(with_frames(result, velocities=moving), velocities=velocities)


def without_motion(scene: Scene) -> Result:
    """Move nothing."""
    motion = SampledTrajectory(np.zeros(1), *initial_state(scene))
    ended = replace(right(scene), trajectory=motion, rest_time=0.0)
    return with_end(with_events(ended, events_in(ended)[:0]), positions=scene.positions)


# --- the motion between events


def scaled_velocities(law: Callable[[FloatArray], FloatArray]) -> Play:
    """Scale the velocities by a function of the elapsed share of the run."""
    return lambda scene: _with_scaled_velocities(right(scene), law)


def _with_scaled_velocities(result: Result, law: Callable[[FloatArray], FloatArray]) -> Result:
    factor = law(frames_of(result).times / result.rest_time)[:, np.newaxis, np.newaxis]
    return with_frames(result, velocities=factor * frames_of(result).velocities)


def with_slow_middle(result: Result, part: float) -> Result:
    """Return a run in frames with too low velocities, by up to the fraction `part` halfway."""
    return _with_scaled_velocities(framed(result), lambda share: 1.0 - part * np.sin(np.pi * share))


def slow_in_the_middle(scene: Scene) -> Result:
    """Report velocities that are up to 30 % too low halfway."""
    return with_slow_middle(simulate(scene, record="trajectory"), 0.3)


gains_slowly = scaled_velocities(lambda share: np.sqrt(1.0 + 1e-4 * share))
"""Gain a ten-thousandth of the energy from start to end."""


def straight_between_events(scene: Scene) -> Result:
    """Move balls at a constant velocity from each event to the next; velocities are right."""
    result = right(scene)
    frames = frames_of(result)
    marks = np.unique(np.concatenate([[0.0], events_in(result)["t"], [result.rest_time]]))
    places = result.sample(marks).positions
    positions = frames.positions.copy()
    for ball in range(len(scene.balls)):
        for axis in range(3):
            positions[:, ball, axis] = np.interp(frames.times, marks, places[:, ball, axis])
    return with_frames(result, positions=positions)


def slows_unevenly(scene: Scene) -> Result:
    """Slow one ball by a wrong law that gives the right rest position and rest time."""
    result = right(scene)
    s = (frames_of(result).times / result.rest_time)[:, np.newaxis, np.newaxis]
    speed = 1.0 - s + 0.2 * s * (1.0 - s) * (1.0 - 2.0 * s)
    way = s - s**2 / 2.0 + 0.2 * (s**2 / 2.0 - s**3 + s**4 / 2.0)
    positions = scene.positions + 2.0 * way * (result.rest_positions - scene.positions)
    return with_frames(result, positions=positions, velocities=speed * scene.velocities)


def jumps(scene: Scene) -> Result:
    """Let a ball jump by 1 mm and back halfway."""
    result = right(scene)
    positions = frames_of(result).positions.copy()
    positions[len(positions) // 2, 0, 1] += 1e-3
    return with_frames(result, positions=positions)


def overlaps(scene: Scene) -> Result:
    """Let a ball overlap another ball by a tenth of their smallest distance for a moment."""
    result = right(scene)
    positions = frames_of(result).positions.copy()
    first, second = positions[:, 0], positions[:, 1]
    k = int(np.argmin(np.linalg.norm(second - first, axis=1)))
    positions[k, 1] = first[k] + 0.9 * (second[k] - first[k])
    return with_frames(result, positions=positions)


def not_finite(scene: Scene) -> Result:
    """Replace a velocity in the middle by NaN."""
    result = right(scene)
    velocities = frames_of(result).velocities.copy()
    velocities[len(velocities) // 2, 0, 0] = np.nan
    return with_frames(result, velocities=velocities)


def in_single_precision(scene: Scene) -> Result:
    """Round all positions to 24 bits."""
    result = right(scene)
    rounded = frames_of(result).positions.astype(np.float32).astype(np.float64)
    ends = result.rest_positions.astype(np.float32).astype(np.float64)
    return with_end(with_frames(result, positions=rounded), positions=ends)


def rounded_once(scene: Scene) -> Result:
    """Round event times and rest positions once more: each number differs by one ulp."""
    result = right(scene)
    events = events_in(result).copy()
    events["t"] = np.maximum(np.nextafter(events["t"], 0.0), 0.0)
    ended = with_end(result, positions=np.nextafter(result.rest_positions, np.inf))
    return with_events(ended, events)
