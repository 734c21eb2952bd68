"""Clean events of tracks, and how a model goes through the windows of each.

An event has what was measured before it, `given`, and after it, `seen`, with their covariances for
samples of variance 1. A model is played from the `given`, and read by the curves of the tracks: it
slides, creeps and is slowed in the same windows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.measured.fit.lines import Curve
from ghostball.validation.measured.tracks import FloatArray

_SIZE = 20.0
"""The sides of the tables on which models are played [m]: no other cushion is near."""


class Event(Protocol):
    """What happened once in a shot, and can be played again."""

    @property
    def shot(self) -> str:
        """The shot it belongs to."""
        ...

    @property
    def speed(self) -> float:
        """The speed of the ball before it [m/s]."""
        ...

    @property
    def given(self) -> FloatArray:
        """What was measured before it, (m,)."""
        ...

    @property
    def given_covariance(self) -> FloatArray:
        """Its covariance, (m, m)."""
        ...

    @property
    def hidden(self) -> int:
        """How many of the `given` nothing has measured."""
        ...

    @property
    def guesses(self) -> Sequence[FloatArray]:
        """What may have been before it, from where a search can begin."""
        ...

    @property
    def steps(self) -> FloatArray:
        """How far to go from it for derivatives, (m,)."""
        ...

    @property
    def seen(self) -> FloatArray:
        """What was measured after it, (k,)."""
        ...

    @property
    def seen_covariance(self) -> FloatArray:
        """Its covariance, (k, k)."""
        ...

    @property
    def times(self) -> FloatArray:
        """When its samples are, from where a model begins [s]."""
        ...

    def scene(self, physics: Physics, given: FloatArray) -> Scene:
        """Return the scene that plays it, begun as `given`."""
        ...

    def read(self, positions: FloatArray) -> FloatArray:
        """Return what is `seen` of positions (len(times), balls, 2)."""
        ...


@dataclass(frozen=True)
class RollingEvent:
    """A ball that rolls alone: `given` its speed in the middle [m/s], `seen` how it slows [m/s^2]."""

    shot: str
    curve: Curve  # a parabola, its times from the first sample on
    speed: float
    deceleration: float
    noise: float
    radius: float

    @property
    def given(self) -> FloatArray:
        return np.array([self.speed])

    @property
    def given_covariance(self) -> FloatArray:
        return self.noise**2 * self.curve.covariance[1:2, 1:2]

    @property
    def hidden(self) -> int:
        return 0

    @property
    def guesses(self) -> Sequence[FloatArray]:
        return [self.given]

    @property
    def steps(self) -> FloatArray:
        return np.sqrt(np.diag(self.given_covariance))

    @property
    def seen(self) -> FloatArray:
        return np.array([self.deceleration])

    @property
    def seen_covariance(self) -> FloatArray:
        return self.noise**2 * 4.0 * self.curve.covariance[2:3, 2:3]

    @property
    def times(self) -> FloatArray:
        return self.curve.times

    def scene(self, physics: Physics, given: FloatArray) -> Scene:
        speed = _rolling_back(physics, float(given[0]), self.curve.middle)
        ball = Ball(id="a", position=(1.0, 1.0), velocity=(speed, 0.0), radius=self.radius)
        return _scene([ball], physics, float(self.times[-1]))

    def read(self, positions: FloatArray) -> FloatArray:
        _, velocity, half = self.curve.of(positions[:, 0])
        return np.array([-2.0 * half @ velocity / np.linalg.norm(velocity)])


@dataclass(frozen=True)
class CushionEvent:
    """A ball that rolls to a cushion and away: its velocities before given, and after seen.

    `given`: towards the cushion and along it [m/s], and its side, as of a `HitEvent` when they meet; `seen`: away
    from the cushion and along it [m/s].
    """

    shot: str
    before: Curve  # lines, their times from the first sample before
    after: Curve
    gap: float  # to the cushion, of the line at time 0 [m]
    given: FloatArray
    seen: FloatArray
    noise: float
    radius: float

    @property
    def speed(self) -> float:
        return float(np.linalg.norm(self.given[:2]))

    @property
    def given_covariance(self) -> FloatArray:
        speed = self.noise**2 * self.before.covariance[1, 1]
        return np.diag([speed, speed, SIDE**2])

    @property
    def hidden(self) -> int:
        return 1

    @property
    def guesses(self) -> Sequence[FloatArray]:
        return _sides(self.given)

    @property
    def steps(self) -> FloatArray:
        return _steps(self.given_covariance)

    @property
    def seen_covariance(self) -> FloatArray:
        return self.noise**2 * self.after.covariance[1, 1] * np.eye(2)

    @property
    def times(self) -> FloatArray:
        return self.after.times

    def scene(self, physics: Physics, given: FloatArray) -> Scene:
        place = (_SIZE - self.radius - self.gap, _SIZE / 2.0)
        start, spin = _begun(
            physics, given, self.before.middle, self.gap / float(given[0]), self.radius
        )
        ball = Ball(
            id="a", position=place, velocity=start, angular_velocity=spin, radius=self.radius
        )
        return _scene([ball], physics, float(self.times[-1]))

    def read(self, positions: FloatArray) -> FloatArray:
        towards, along = self.after.of(positions[:, 0])[1]
        return np.array([-towards, along])


@dataclass(frozen=True)
class HitEvent:
    """A ball that rolls to another at rest: both seen afterwards, their places and velocities.

    In axes whose first is the ball's way: `given` its place in the middle of the samples, from the
    other's [m], its velocity [m/s], and its side when they meet: the speed of its equator about the
    vertical, over that of its centre. No tracker sees that: 0, give or take `SIDE`.
    """

    shot: str
    before: Curve  # a line, its times from the first sample on
    after: tuple[Curve, Curve]
    resting: int  # samples of the ball at rest
    given: FloatArray
    seen: FloatArray
    noise: float
    radius: float

    @property
    def speed(self) -> float:
        return float(np.linalg.norm(self.given[2:4]))

    @property
    def given_covariance(self) -> FloatArray:
        line = self.noise**2 * self.before.covariance
        place = line[0, 0] + self.noise**2 / self.resting
        return np.diag([place, place, line[1, 1], line[1, 1], SIDE**2])

    @property
    def hidden(self) -> int:
        return 1

    @property
    def guesses(self) -> Sequence[FloatArray]:
        return _sides(self.given)

    @property
    def steps(self) -> FloatArray:
        return _steps(self.given_covariance)

    @property
    def seen_covariance(self) -> FloatArray:
        lines = [np.kron(after.covariance, np.eye(2)) for after in self.after]
        zero = np.zeros((4, 4))
        return self.noise**2 * np.block([[lines[0], zero], [zero, lines[1]]])

    @property
    def times(self) -> FloatArray:
        return np.union1d(self.after[0].times, self.after[1].times)

    def scene(self, physics: Physics, given: FloatArray) -> Scene:
        place, velocity, time = given[:2], given[2:4], self.before.middle
        reach = 2.0 * self.radius
        way = -place[0] - math.sqrt(max(reach**2 - place[1] ** 2, 0.0))
        meeting = time + float(way / velocity[0])
        start, spin = _begun(physics, given[2:], time, meeting, self.radius)
        slowing = (np.array(start) - velocity) / time
        way = np.array(start) * time - slowing * np.mean(self.before.times**2) / 2.0
        x, y = _SIZE / 2.0 + place - way  # so that the mean of its places is that of the track's
        balls = [
            Ball(
                id="a",
                position=(x, y),
                velocity=start,
                angular_velocity=spin,
                radius=self.radius,
            ),
            Ball(id="b", position=(_SIZE / 2.0, _SIZE / 2.0), radius=self.radius),
        ]
        return _scene(balls, physics, float(self.times[-1]))

    def read(self, positions: FloatArray) -> FloatArray:
        lines = [
            after.of(positions[np.searchsorted(self.times, after.times), ball] - _SIZE / 2.0)
            for ball, after in enumerate(self.after)
        ]
        return np.concatenate([line.ravel() for line in lines])


SIDE = 1.0
"""How much side a ball may have, typically."""


_GUESSES = (-1.2, -0.4, 0.0, 0.4, 1.2)
_STEP = 0.02


def _sides(given: FloatArray) -> list[FloatArray]:
    """Return what is given with all sides that may be: a contact that slips may hide which."""
    return [np.append(given[:-1], side) for side in _GUESSES]


def _steps(covariance: FloatArray) -> FloatArray:
    """Return steps of derivatives: an error of each, but for the side, whose error is large."""
    return np.append(np.sqrt(np.diag(covariance))[:-1], _STEP)


def _begun(
    physics: Physics, given: FloatArray, middle: float, meeting: float, radius: float
) -> tuple[tuple[float, float], tuple[float, float, float]]:
    """Return velocity and spin of a rolling ball at the time 0.

    `given`: its velocity at the time `middle` [s] and the side that it has at the time `meeting`;
    until then the cloth slows its spin.
    """
    velocity, side = given[:2], float(given[2])
    speed = float(np.linalg.norm(velocity))
    x, y = (velocity * (_rolling_back(physics, speed, middle) / speed)).tolist()
    spin = side * speed / radius
    slowed = math.copysign(physics.spinning_friction_rate * max(meeting, 0.0), side) if side else 0.0
    return (x, y), (-y / radius, x / radius, spin + slowed)


def _rolling_back(physics: Physics, speed: float, time: float) -> float:
    """Return the speed of a rolling ball `time` [s] before it has `speed` [m/s]."""
    slowing = physics.rolling_friction * physics.gravity
    slowing += physics.rolling_friction_quadratic * speed**2
    return speed + slowing * time


def _scene(balls: list[Ball], physics: Physics, last: float) -> Scene:
    table = Table(length=_SIZE, width=_SIZE)
    return Scene(name="event", table=table, physics=physics, balls=balls, t_max=last + 0.01)
