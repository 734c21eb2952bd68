"""Shots of Ghostball's engine with wrong physics, wrong contacts or no end; see `wrong_engines`.

Each function simulates a scene and returns the run, with the motion in frames, or returns such a
function.
"""

from __future__ import annotations

import os
import random
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from wrong_runs import (
    FloatArray,
    Play,
    events_in,
    framed,
    frames_of,
    right,
    states_of,
    with_end,
    with_events,
    with_frames,
)

from ghostball.engine import simulate
from ghostball.model import EventKind, Result, SampledTrajectory, Scene


def with_physics(**change: Callable[[Any], Any]) -> Play:
    """Change numbers of the physics."""

    def play(scene: Scene) -> Result:
        update = {name: law(getattr(scene.physics, name)) for name, law in change.items()}
        physics = scene.physics.model_copy(update=update)
        return _as(scene, right(scene.model_copy(update={"physics": physics})))

    return play


def with_balls(**change: Callable[[Any], Any]) -> Play:
    """Change numbers of the first ball."""

    def play(scene: Scene) -> Result:
        first, *others = scene.balls
        update = {name: law(getattr(first, name)) for name, law in change.items()}
        # The centre of a larger ball is higher; this isn't the fault.
        height = np.zeros((len(scene.balls), 3))
        height[0, 2] = update.get("radius", first.radius) - first.radius
        place = tuple((scene.positions + height)[0].tolist())
        balls = (first.model_copy(update=update | {"position": place}), *others)
        result = right(scene.model_copy(update={"balls": balls}))
        moved = with_frames(result, positions=frames_of(result).positions - height)
        return _as(scene, with_end(moved, positions=result.rest_positions - height))

    return play


Change = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Function that changes the velocities and angular velocities, (n, 3) each, after an impact."""


def at_each(kind: EventKind, change: Change) -> Play:
    """Change the motion just after each event of a kind, and continue from there."""

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
    """Rotate all velocities to the left by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return lambda v, w: (v @ rotation.T, w @ rotation.T)


def makes_energy(share: float, *, only_once: bool = False) -> Play:
    """Gain a share of the energy at each collision of balls, or only at the first one."""
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
    """Return the scene that continues from a state at time t."""
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
    """Return a run up to an event; the log includes the event, the frames end just before it."""
    frames, events = frames_of(result), events_in(result)
    kept = frames.times < t
    motion = SampledTrajectory(frames.times[kept], *(states[kept] for states in states_of(frames)))
    return replace(result, events=events[events["t"] <= t], trajectory=motion)


def _shifted(result: Result, t: float) -> Result:
    """Return a run shifted in time, so that it starts at time t [s]."""
    events, frames = events_in(result).copy(), frames_of(result)
    events["t"] += t
    motion = replace(frames, times=frames.times + t)
    return replace(result, events=events, trajectory=motion, rest_time=result.rest_time + t)


def _joined(scene: Scene, parts: list[Result]) -> Result:
    """Return successive runs joined to one run."""
    states = zip(*(states_of(frames_of(part)) for part in parts), strict=True)
    times = np.concatenate([frames_of(part).times for part in parts])
    motion = SampledTrajectory(times, *(np.concatenate(list(one)) for one in states))
    whole = replace(parts[-1], scene=scene, trajectory=motion)
    return with_events(whole, np.concatenate([events_in(part) for part in parts]))


def _as(scene: Scene, result: Result) -> Result:
    return replace(result, scene=scene)


# --- contacts


def passes_through(scene: Scene) -> Result:
    """Let the balls pass through each other, by simulating them 50 m apart."""
    offsets = np.arange(len(scene.balls))[:, np.newaxis] * np.array([0.0, 50.0, 0.0])
    return _played_elsewhere(scene.model_copy(update={"table": None}), offsets)


def sees_late(overlap: float) -> Play:
    """Detect a collision when the balls overlap by a given length [m]."""

    def play(scene: Scene) -> Result:
        less = 0.5 * overlap
        lower = np.full((len(scene.balls), 1), -less) * np.array([0.0, 0.0, 1.0])
        return _played_elsewhere(scene, lower, radius=lambda radius: radius - less)

    return play


def _played_elsewhere(scene: Scene, by: FloatArray, **change: Callable[[float], float]) -> Result:
    """Simulate a scene with displaced balls, `by` (n, 3) [m], and move the result back."""
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
    """Change the stroke in each run by up to a thousandth."""
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
    """Wait forever."""
    while True:
        time.sleep(1.0)
