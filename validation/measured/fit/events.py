"""Clean events in tracks, and their simulation, evaluated in the same windows.

An event has measured values before it, `given`, and after it, `seen`, with their covariances. A
simulation starts from `given` and is evaluated with the fitted curves of the tracks, so sliding,
rolling and deceleration in the windows are included.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ghostball.model import Ball, Physics
from ghostball.model.arrays import FloatArray
from ghostball.validation.measured.fit.curves import Curve
from ghostball.validation.measured.simulated_ball import rolling_deceleration

SIDE = 1.0
"""Typical side of a ball: the speed of its equator about the vertical axis, divided by its speed.
"""
_GUESSES = (-1.2, -0.4, 0.0, 0.4, 1.2)
_STEP = 0.02  # step of derivatives with respect to the side
SIZE = 20.0
"""Side length of the table part of each event [m]; events don't affect each other."""


@dataclass(frozen=True)
class FitEvent(ABC):
    """An event of a shot that can be simulated."""

    shot: str
    speed: float  # of the ball before it [m/s]
    radius: float  # [m]
    given: FloatArray  # (m,)
    given_covariance: FloatArray  # (m, m)
    seen: FloatArray  # (k,)
    seen_covariance: FloatArray  # (k, k)
    times: FloatArray
    """Times of the samples, from the start of the simulation [s]."""

    count: ClassVar[int] = 1
    """Number of its balls."""
    hides_side: ClassVar[bool] = True
    """Whether the last `given` value is an unseen side: 0 with a standard deviation of `SIDE`."""

    @abstractmethod
    def balls(self, physics: Physics, given: FloatArray) -> list[Ball]:
        """Return its balls, started with the values `given`."""

    @abstractmethod
    def read(self, positions: FloatArray) -> FloatArray:
        """Return the values of `seen` for positions (len(times), balls, 2)."""

    @property
    def guesses(self) -> Sequence[FloatArray]:
        """Start values of the search: several sides, because a slipping contact hides the side."""
        if not self.hides_side:
            return [self.given]
        return [np.append(self.given[:-1], side) for side in _GUESSES]

    @property
    def steps(self) -> FloatArray:
        """Steps for derivatives, (m,): the errors, but a fixed step for the side."""
        errors = np.sqrt(np.diag(self.given_covariance))
        return np.append(errors[:-1], _STEP) if self.hides_side else errors


@dataclass(frozen=True)
class RollingEvent(FitEvent):
    """A ball that rolls freely: `given` its speed [m/s], `seen` its deceleration [m/s^2]."""

    curve: Curve  # a parabola

    hides_side: ClassVar[bool] = False

    def balls(self, physics: Physics, given: FloatArray) -> list[Ball]:
        """Return a ball with this speed in the middle of the window."""
        speed = _rolling_back(physics, float(given[0]), self.curve.middle)
        return [Ball(id="a", position=(1.0, 1.0), velocity=(speed, 0.0), radius=self.radius)]

    def read(self, positions: FloatArray) -> FloatArray:
        """Return the deceleration in the middle of the window."""
        return np.array([slowing_of(self.curve.of(positions[:, 0]))[1]])


@dataclass(frozen=True)
class CushionEvent(FitEvent):
    """A ball that rolls to a cushion and back: velocities before and after the contact.

    `given`: towards the cushion and along it [m/s], and the side at the contact; `seen`: away from
        the cushion and along it [m/s].
    """

    before: Curve  # straight lines; times from the first sample before the contact
    after: Curve
    gap: float  # gap to the cushion, on the line at time 0 [m]

    def balls(self, physics: Physics, given: FloatArray) -> list[Ball]:
        """Return a ball that rolls to a cushion across x."""
        meeting = self.gap / float(given[0])
        start, spin = _begun(physics, given, self.before.middle, meeting, self.radius)
        place = (SIZE - self.radius - self.gap, SIZE / 2.0)
        return [
            Ball(id="a", position=place, velocity=start, angular_velocity=spin, radius=self.radius)
        ]

    def read(self, positions: FloatArray) -> FloatArray:
        """Return the velocities of the line after the contact."""
        towards, along = self.after.of(positions[:, 0])[1]
        return np.array([-towards, along])


@dataclass(frozen=True)
class HitEvent(FitEvent):
    """A rolling ball that hits a ball at rest: positions and velocities of both afterwards.

    The first axis is the direction of the ball, the origin the position of the ball at rest.
    `given`: position in the middle of the samples [m], velocity [m/s], and the side at the hit;
    `seen`: for each ball, position and velocity in the middle of its samples.
    """

    before: Curve  # a straight line; times from the first sample
    after: tuple[Curve, Curve]

    count: ClassVar[int] = 2

    def balls(self, physics: Physics, given: FloatArray) -> list[Ball]:
        """Return a ball that moves along x towards another one."""
        place, velocity, time = given[:2], given[2:4], self.before.middle
        reach = math.sqrt(max(4.0 * self.radius**2 - float(place[1]) ** 2, 0.0))
        meeting = time + float((-place[0] - reach) / velocity[0])
        start, spin = _begun(physics, given[2:], time, meeting, self.radius)
        # The mean of its simulated positions equals that of the track.
        slowing = (np.array(start) - velocity) / time
        way = np.array(start) * time - slowing * float(np.mean(self.before.times**2)) / 2.0
        x, y = (SIZE / 2.0 + place - way).tolist()
        return [
            Ball(
                id="a", position=(x, y), velocity=start, angular_velocity=spin, radius=self.radius
            ),
            Ball(id="b", position=(SIZE / 2.0, SIZE / 2.0), radius=self.radius),
        ]

    def read(self, positions: FloatArray) -> FloatArray:
        """Return the positions and velocities of both lines after the hit."""
        lines = [
            after.of(positions[np.searchsorted(self.times, after.times), ball] - SIZE / 2.0)
            for ball, after in enumerate(self.after)
        ]
        return np.concatenate([line.ravel() for line in lines])


def slowing_of(parabola: FloatArray) -> tuple[float, float]:
    """Return speed and deceleration in the middle of a parabola (3, 2)."""
    _, velocity, half = parabola
    speed = float(np.linalg.norm(velocity))
    return speed, float(-2.0 * half @ velocity) / speed


def _begun(
    physics: Physics, given: FloatArray, middle: float, meeting: float, radius: float
) -> tuple[tuple[float, float], tuple[float, float, float]]:
    """Return velocity and spin of a rolling ball at time 0.

    `given`: its velocity at the time `middle` [s], and its side at the time `meeting`; until then
        the cloth decelerates its spin.
    """
    velocity, side = given[:2], float(given[2])
    speed = float(np.linalg.norm(velocity))
    x, y = (velocity * (_rolling_back(physics, speed, middle) / speed)).tolist()
    slowed = physics.spinning_friction_rate * max(meeting, 0.0)
    spin = side * speed / radius + (math.copysign(slowed, side) if side else 0.0)
    return (x, y), (-y / radius, x / radius, spin)


def _rolling_back(physics: Physics, speed: float, time: float) -> float:
    """Return the speed of a rolling ball `time` [s] before its speed is `speed` [m/s]."""
    return speed + rolling_deceleration(physics, speed) * time
