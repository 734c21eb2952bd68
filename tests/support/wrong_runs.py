"""Runs of our engine with one fault each; see `wrong_engines` for the table of them.

Each function plays a scene and returns the run, with the motion in frames.
"""

from __future__ import annotations

import os
import random
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import simulate
from ghostball.model import (
    COLLISION_KINDS,
    EventKind,
    Events,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    initial_state,
)

FloatArray = NDArray[np.float64]
Play = Callable[[Scene], Result]

FRAMES = 500
"""Frames of a run, beside those at its events."""


def right(scene: Scene) -> Result:
    """Play a scene without a fault."""
    return framed(simulate(scene, record="trajectory"))


def framed(result: Result) -> Result:
    """Return a run with its motion in frames, some just before and at each event."""
    events = events_in(result)
    grid = np.linspace(0.0, result.rest_time, FRAMES + 1)
    before = np.maximum(np.nextafter(events["t"], 0.0), 0.0)
    times = np.unique(np.concatenate([grid, events["t"], before]))
    return replace(result, trajectory=SampledTrajectory(times, *result.sample(times)))


def events_in(result: Result) -> Events:
    """Return the events of a run that recorded them."""
    assert result.events is not None
    return result.events


def frames_of(result: Result) -> SampledTrajectory:
    """Return the motion of a run in frames."""
    assert isinstance(result.trajectory, SampledTrajectory)
    return result.trajectory


def with_frames(result: Result, **states: FloatArray) -> Result:
    """Return a run with other states in its frames, (k, n, 3) each."""
    return replace(result, trajectory=replace(frames_of(result), **states))


def with_end(result: Result, **states: FloatArray) -> Result:
    """Return a run with another final state, (n, 3) each; the frames stay."""
    end = {name: array[np.newaxis] for name, array in states.items()}
    return replace(result, final_state=result.final_state._replace(**end))


def with_events(result: Result, events: Events) -> Result:
    """Return a run with other events, in order of time, and with the counts of these."""
    ordered = events[np.argsort(events["t"], kind="stable")]
    counts = {kind.label: int(np.sum(ordered["kind"] == kind)) for kind in COLLISION_KINDS}
    return replace(result, events=ordered, collision_counts=counts)


def collisions_of(result: Result) -> NDArray[np.intp]:
    """Return which events of a run are collisions."""
    return np.flatnonzero(np.isin(events_in(result)["kind"], COLLISION_KINDS))


# --- events, times and counts


def late(by: float, *, collisions_only: bool = False) -> Play:
    """Report events late [s]; the motion is right."""

    def play(scene: Scene) -> Result:
        result = right(scene)
        events = events_in(result).copy()
        chosen = collisions_of(result) if collisions_only else slice(None)
        events["t"][chosen] += by
        end = max(result.rest_time, float(np.max(events["t"])))
        return replace(with_events(result, events), rest_time=end)

    return play


def rests_late(by: float) -> Play:
    """Report that the last ball comes to rest late [s]."""
    return lambda scene: replace(right(scene), rest_time=simulate(scene).rest_time + by)


def in_milliseconds(scene: Scene) -> Result:
    """Report milliseconds where seconds are asked for; velocities are right."""
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
        *(np.concatenate([states[:1], states]) for states in _states(frames)),
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
    """Report the first two collisions in the other order, at the instants of each other."""
    result = right(scene)
    events = events_in(result).copy()
    first, second = collisions_of(result)[:2]
    for name in ("kind", "a", "b"):
        events[name][[first, second]] = events[name][[second, first]]
    return with_events(result, events)


def with_another_count(scene: Scene) -> Result:
    """Count a collision more than there are events."""
    result = right(scene)
    counts = {kind: count + 1 for kind, count in result.collision_counts.items()}
    return replace(result, collision_counts=counts)


# --- where balls end


def ends_moved(move: Callable[[FloatArray, Scene], FloatArray]) -> Play:
    """Report other rest positions, (n, 3) [m], than the motion ends at."""

    def play(scene: Scene) -> Result:
        result = right(scene)
        return with_end(result, positions=move(result.rest_positions.copy(), scene))

    return play


def swapped(places: FloatArray, _: Scene) -> FloatArray:
    """Give each ball the place of the one before."""
    return np.roll(places, 1, axis=0)


def displaced(by: float) -> Callable[[FloatArray, Scene], FloatArray]:
    """Move each ball along x [m]."""
    return lambda places, _: places + np.array([by, 0.0, 0.0])


def mirrored(places: FloatArray, scene: Scene) -> FloatArray:
    """Mirror the places at the middle of the table."""
    assert scene.table is not None
    return np.array([scene.table.length, 0.0, 0.0]) + places * np.array([-1.0, 1.0, 1.0])


def drifting(by: float) -> Play:
    """Let all balls drift along x, by this [m] until the end."""

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
    """End the run after half its time, and say that all balls rest."""
    result = right(scene)
    frames, end = frames_of(result), 0.5 * result.rest_time
    kept = frames.times <= end
    motion = SampledTrajectory(frames.times[kept], *(states[kept] for states in _states(frames)))
    events = events_in(result)
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


def stops_late(scene: Scene) -> Result:
    """Stop all balls dead at 60 % of the shot."""
    whole = right(scene)
    frames, log = frames_of(whole), events_in(whole)
    kept = int(np.searchsorted(frames.times, 0.6 * whole.rest_time, side="right"))
    states = [part[:kept].copy() for part in _states(frames)]
    states[1][-1] = states[2][-1] = 0.0
    end = float(frames.times[kept - 1])
    ended = replace(
        whole,
        trajectory=SampledTrajectory(frames.times[:kept], *states),
        rest_time=end,
        final_state=Samples(*(part[-1:] for part in states)),
    )
    return with_events(ended, log[log["t"] <= end])


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
    result = right(scene)
    still = np.zeros_like(frames_of(result).velocities)
    still[0] = scene.velocities
    places = np.broadcast_to(scene.positions, still.shape).copy()
    moved = with_frames(result, positions=places, velocities=still)
    ended = replace(moved, rest_time=0.0, trajectory=None)
    ended = with_events(ended, events_in(result)[:0])
    start = Samples(places[:1], still[:1], still[:1])
    return replace(
        with_end(ended, positions=scene.positions),
        trajectory=SampledTrajectory(np.zeros(1), *start),
    )


# --- the motion between


def slow_in_the_middle(scene: Scene) -> Result:
    """Report velocities that are up to 30 % too low halfway."""
    result = right(scene)
    share = frames_of(result).times / result.rest_time
    factor = (1.0 - 0.3 * np.sin(np.pi * share))[:, np.newaxis, np.newaxis]
    return with_frames(result, velocities=factor * frames_of(result).velocities)


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
    """Slow one ball down by another law, which leads it to the same place at the same time."""
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


def gains_slowly(scene: Scene) -> Result:
    """Make a ten-thousandth of the energy from start to end."""
    result = right(scene)
    share = frames_of(result).times / result.rest_time
    factor = np.sqrt(1.0 + 1e-4 * share)[:, np.newaxis, np.newaxis]
    return with_frames(result, velocities=factor * frames_of(result).velocities)


def overlaps(scene: Scene) -> Result:
    """Put a ball 5 mm into another one for a moment."""
    result = right(scene)
    positions = frames_of(result).positions.copy()
    first, second = positions[:, 0], positions[:, 1]
    k = int(np.argmin(np.linalg.norm(second - first, axis=1)))
    positions[k, 1] = first[k] + 0.9 * (second[k] - first[k])
    return with_frames(result, positions=positions)


def not_finite(scene: Scene) -> Result:
    """Lose a velocity in the middle."""
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
    """Round once more: each number is off by one spacing of doubles."""
    result = right(scene)
    events = events_in(result).copy()
    events["t"] = np.maximum(np.nextafter(events["t"], 0.0), 0.0)
    ended = with_end(result, positions=np.nextafter(result.rest_positions, np.inf))
    return with_events(ended, events)


# --- other physics


def with_physics(**change: Callable[[Any], Any]) -> Play:
    """Play with other numbers in the physics."""

    def play(scene: Scene) -> Result:
        update = {name: law(getattr(scene.physics, name)) for name, law in change.items()}
        physics = scene.physics.model_copy(update=update)
        return _as(scene, right(scene.model_copy(update={"physics": physics})))

    return play


def with_balls(**change: Callable[[Any], Any]) -> Play:
    """Play with other numbers of the first ball."""

    def play(scene: Scene) -> Result:
        first, *others = scene.balls
        update = {name: law(getattr(first, name)) for name, law in change.items()}
        # A larger ball lies higher; that alone isn't the fault.
        height = np.zeros((len(scene.balls), 3))
        height[0, 2] = update.get("radius", first.radius) - first.radius
        place = tuple((scene.positions + height)[0].tolist())
        balls = (first.model_copy(update=update | {"position": place}), *others)
        result = right(scene.model_copy(update={"balls": balls}))
        moved = with_frames(result, positions=frames_of(result).positions - height)
        return _as(scene, with_end(moved, positions=result.rest_positions - height))

    return play


Change = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Makes other velocities and angular velocities, (n, 3) each, of those just after an impact."""


def at_each(kind: EventKind, change: Change) -> Play:
    """Change the motion just after each event of a kind, and play on from there."""

    def play(scene: Scene) -> Result:
        parts: list[Result] = []
        start, begun = scene, 0.0
        while True:
            whole = simulate(start, record="trajectory")
            at = events_in(whole)["t"][events_in(whole)["kind"] == kind]
            if not len(at) or len(parts) > 40:
                return _joined(scene, [*parts, _shifted(framed(whole), begun)])
            t = float(at[0])
            parts.append(_shifted(_until(framed(whole), t), begun))
            x, v, w = (states[0] for states in whole.sample([t]))
            v, w = change(v, w)
            start, begun = _started(scene, x, v, w, begun + t), begun + t

    return play


def scaled(velocities: float, spins: float) -> Change:
    """Scale the velocities and the angular velocities of all balls."""
    return lambda v, w: (velocities * v, spins * w)


def turned(angle: float) -> Change:
    """Turn all velocities to the left [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return lambda v, w: (v @ rotation.T, w @ rotation.T)


def makes_energy(share: float, *, only_once: bool = False) -> Play:
    """Make a share of the energy at each collision of balls, or at the first alone."""
    factor = (1.0 + share) ** 0.5
    done: list[int] = []

    def change(v: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
        done.append(1)
        return (v, w) if only_once and len(done) > 1 else (factor * v, factor * w)

    def play(scene: Scene) -> Result:
        done.clear()
        return at_each(EventKind.BALL_BALL, change)(scene)

    return play


def _started(scene: Scene, x: FloatArray, v: FloatArray, w: FloatArray, t: float) -> Scene:
    """Return the scene as it goes on from a state at an instant."""
    slides = scene.physics.motion == "sliding"
    balls = tuple(
        ball.model_copy(
            update={
                "position": tuple(x[i].tolist()),
                "velocity": tuple(v[i].tolist()),
                "angular_velocity": tuple(w[i].tolist()) if slides else None,
            }
        )
        for i, ball in enumerate(scene.balls)
    )
    left = None if scene.t_max is None else scene.t_max - t
    return scene.model_copy(update={"balls": balls, "t_max": left})


def _until(result: Result, t: float) -> Result:
    """Return a run up to an event, included in its log; the frames end just before it."""
    frames, events = frames_of(result), events_in(result)
    kept = frames.times < t
    motion = SampledTrajectory(frames.times[kept], *(states[kept] for states in _states(frames)))
    return replace(result, events=events[events["t"] <= t], trajectory=motion)


def _shifted(result: Result, t: float) -> Result:
    """Return a run that begins at an instant [s]."""
    events, frames = events_in(result).copy(), frames_of(result)
    events["t"] += t
    motion = replace(frames, times=frames.times + t)
    return replace(result, events=events, trajectory=motion, rest_time=result.rest_time + t)


def _joined(scene: Scene, parts: list[Result]) -> Result:
    """Return runs that follow each other as one."""
    states = zip(*(_states(frames_of(part)) for part in parts), strict=True)
    times = np.concatenate([frames_of(part).times for part in parts])
    motion = SampledTrajectory(times, *(np.concatenate(list(one)) for one in states))
    whole = replace(parts[-1], scene=scene, trajectory=motion)
    return with_events(whole, np.concatenate([events_in(part) for part in parts]))


def _states(frames: SampledTrajectory) -> tuple[FloatArray, FloatArray, FloatArray]:
    return frames.positions, frames.velocities, frames.angular_velocities


def _as(scene: Scene, result: Result) -> Result:
    return replace(result, scene=scene)


# --- contacts


def passes_through(scene: Scene) -> Result:
    """Let the balls pass through each other: they are played 50 m apart."""
    offsets = np.arange(len(scene.balls))[:, np.newaxis] * np.array([0.0, 50.0, 0.0])
    return _played_elsewhere(scene.model_copy(update={"table": None}), offsets)


def sees_late(overlap: float) -> Play:
    """See a collision when the balls are this far into each other [m]."""

    def play(scene: Scene) -> Result:
        less = 0.5 * overlap
        lower = np.full((len(scene.balls), 1), -less) * np.array([0.0, 0.0, 1.0])
        return _played_elsewhere(scene, lower, radius=lambda radius: radius - less)

    return play


def _played_elsewhere(scene: Scene, by: FloatArray, **change: Callable[[float], float]) -> Result:
    """Play a scene whose balls lie elsewhere, (n, 3) [m], and move what comes of it back."""
    balls = tuple(
        ball.model_copy(
            update={"position": tuple(place)}
            | {name: law(getattr(ball, name)) for name, law in change.items()}
        )
        for ball, place in zip(scene.balls, (scene.positions + by).tolist(), strict=True)
    )
    result = right(scene.model_copy(update={"balls": balls}))
    moved = with_frames(result, positions=frames_of(result).positions - by)
    return with_end(moved, positions=result.rest_positions - by)


# --- processes


def nondeterministic(scene: Scene) -> Result:
    """Play with another stroke each time, by up to a thousandth."""
    more = 1.0 + 1e-3 * random.SystemRandom().uniform(0.1, 1.0)
    balls = tuple(
        ball.model_copy(update={"velocity": tuple(more * part for part in ball.velocity)})
        for ball in scene.balls
    )
    return right(scene.model_copy(update={"balls": balls}))


def crashes(scene: Scene) -> Result:
    """End the process."""
    os._exit(7)


def hangs(scene: Scene) -> Result:
    """Wait without end."""
    while True:
        time.sleep(1.0)
