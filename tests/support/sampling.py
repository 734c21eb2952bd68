"""Reading a recorded shot: the states around an event, when a ball starts to roll, directions."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from invariants import FloatArray

from ghostball.engine import EventKind, Result, Scene


class State(NamedTuple):
    """All balls at one instant: three arrays (n, 3) [m], [m/s], [rad/s]."""

    positions: FloatArray
    velocities: FloatArray
    angular_velocities: FloatArray


def state_at(result: Result, t: float) -> State:
    """Return the state at the instant `t`; after the event, where one falls on it."""
    return State(*(array[0] for array in result.sample(t)))


def state_before(result: Result, t: float) -> State:
    """Return the state at the last double before `t`; at t = 0 the scene's own."""
    if t == 0.0:
        scene = result.scene
        return State(scene.positions, scene.velocities, scene.angular_velocities)
    return state_at(result, float(np.nextafter(t, 0.0)))


def times_of(result: Result, kind: EventKind, ball: int | None = None) -> list[float]:
    """Return the times of all events of one kind, of one ball where that is given."""
    events = result.events
    assert events is not None
    return [
        float(event["t"])
        for event in events
        if event["kind"] == kind
        and (
            ball is None
            or ball == event["a"]
            or (kind is EventKind.BALL_BALL and ball == event["b"])
        )
    ]


def once_rolling(result: Result, ball: int, since: float = 0.0) -> tuple[float, FloatArray]:
    """Return when a ball first starts to roll after `since` [s], and its velocity (2,) then."""
    t = next(t for t in times_of(result, EventKind.SLIDE_TO_ROLL, ball) if t > since)
    return t, state_at(result, t).velocities[ball, :2]


def direction(velocity: FloatArray) -> float:
    """Return the angle of a velocity from the x axis [degrees], in (-180, 180]."""
    return math.degrees(math.atan2(velocity[1], velocity[0]))


def speed(velocity: FloatArray) -> float:
    """Return the speed in the plane [m/s]."""
    return math.hypot(velocity[0], velocity[1])


def kinetic_energy(scene: Scene, state: State) -> FloatArray:
    """Return the kinetic energy of each ball, with its spin, (n,) [J]."""
    inertias = 0.4 * scene.masses * scene.radii**2
    moving = scene.masses * np.sum(state.velocities**2, axis=1)
    turning = inertias * np.sum(state.angular_velocities**2, axis=1)
    total: FloatArray = 0.5 * (moving + turning)
    return total
