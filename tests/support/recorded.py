"""Read a recorded shot: events, their hash, and the states around an event."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ghostball.model import EventKind, Result, Samples
from ghostball.model.hashes import bits_hash

FloatArray = NDArray[np.float64]

EPS = 2.0**-52


def collisions(result: Result) -> list[tuple[int, int, int]]:
    """Return (kind, a, b) of every collision, in order of time."""
    assert result.events is not None
    return [
        (int(event["kind"]), int(event["a"]), int(event["b"]))
        for event in result.events
        if event["kind"] in (EventKind.BALL_BALL, EventKind.BALL_CUSHION)
    ]


def fingerprint(result: Result) -> str:
    """Return the sha256 of the event log and the rest positions."""
    assert result.events is not None
    return bits_hash(result.events, result.rest_positions)


def state_at(result: Result, t: float) -> Samples:
    """Return the state (n, 3) at time `t`, after an event at this time."""
    return Samples(*(array[0] for array in result.sample(t)))


def state_before(result: Result, t: float) -> Samples:
    """Return the state at the last double before `t`; for t = 0, the initial state."""
    if t == 0.0:
        scene = result.scene
        return Samples(scene.positions, scene.velocities, scene.angular_velocities)
    return state_at(result, float(np.nextafter(t, 0.0)))


def times_of(result: Result, kind: EventKind, ball: int | None = None) -> list[float]:
    """Return the times of all events of a kind, or only of those of one ball."""
    assert result.events is not None
    of_kind = result.events[result.events["kind"] == kind]
    if ball is not None:
        of_kind = of_kind[of_kind["a"] == ball]
    times: list[float] = of_kind["t"].tolist()
    return times


def direction(velocity: FloatArray) -> float:
    """Return the angle of a velocity from the x axis [degrees], in (-180, 180]."""
    return math.degrees(math.atan2(velocity[1], velocity[0]))


def speed(velocity: FloatArray) -> float:
    """Return the speed in the plane [m/s]."""
    return math.hypot(velocity[0], velocity[1])
