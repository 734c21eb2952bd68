"""Clean events of tracks, and how a model goes through the windows of each.

An event has what was measured before it, `given`, and after it, `seen`, with their covariances. A
model is played from the `given`, and read by the curves of the tracks: it slides, creeps and is
slowed in the same windows.
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
from ghostball.validation.measured.fit.lines import Curve
from ghostball.validation.measured.play import rolling_deceleration

SIDE = 1.0
"""How much side a ball may have, typically: the speed of its equator about the vertical, over that
of its centre.
"""
_GUESSES = (-1.2, -0.4, 0.0, 0.4, 1.2)
_STEP = 0.02  # of derivatives by the side
SIZE = 20.0
"""The sides of the table that each event has for itself [m]: nothing else is near."""


@dataclass(frozen=True)
class Event(ABC):
    """What happened once in a shot, and can be played again."""

    shot: str
    speed: float  # of the ball before it [m/s]
    radius: float  # [m]
    given: FloatArray  # (m,)
    given_covariance: FloatArray  # (m, m)
    seen: FloatArray  # (k,)
    seen_covariance: FloatArray  # (k, k)
    times: FloatArray
    """When samples are read, from where a model begins [s]."""

    count: ClassVar[int] = 1
    """How many balls play it."""
    hides_side: ClassVar[bool] = True
    """Whether the last number `given` is a side, which no tracker sees: 0, give or take `SIDE`."""

    @abstractmethod
    def balls(self, physics: Physics, given: FloatArray) -> list[Ball]:
        """Return the balls that play it, begun as `given`."""

    @abstractmethod
    def read(self, positions: FloatArray) -> FloatArray:
        """Return what is `seen` of positions (len(times), balls, 2)."""

    @property
    def guesses(self) -> Sequence[FloatArray]:
        """What may have been before it: with all sides, since a contact that slips hides which."""
        if not self.hides_side:
            return [self.given]
        return [np.append(self.given[:-1], side) for side in _GUESSES]

    @property
    def steps(self) -> FloatArray:
        """How far to go from it for derivatives, (m,): an error; the side's is too large."""
        errors = np.sqrt(np.diag(self.given_covariance))
        return np.append(errors[:-1], _STEP) if self.hides_side else errors


@dataclass(frozen=True)
class RollingEvent(Event):
    """A ball that rolls alone: `given` its speed [m/s], `seen` its deceleration [m/s^2]."""

    curve: Curve  # a parabola

    hides_side: ClassVar[bool] = False

    def balls(self, physics: Physics, given: FloatArray) -> list[Ball]:
        """Return a ball that has the speed in the middle."""
        speed = _rolling_back(physics, float(given[0]), self.curve.middle)
        return [Ball(id="a", position=(1.0, 1.0), velocity=(speed, 0.0), radius=self.radius)]

    def read(self, positions: FloatArray) -> FloatArray:
        """Return the deceleration in the middle."""
        return np.array([slowing_of(self.curve.of(positions[:, 0]))[1]])


@dataclass(frozen=True)
class CushionEvent(Event):
    """A ball that rolls to a cushion and away: its velocities before given, and after seen.

    `given`: towards the cushion and along it [m/s], and its side when they meet; `seen`: away from
    the cushion and along it [m/s].
    """

    before: Curve  # lines, their times from the first sample before
    after: Curve
    gap: float  # to the cushion, of the line at time 0 [m]

    def balls(self, physics: Physics, given: FloatArray) -> list[Ball]:
        """Return a ball that goes to a cushion across x."""
        meeting = self.gap / float(given[0])
        start, spin = _begun(physics, given, self.before.middle, meeting, self.radius)
        place = (SIZE - self.radius - self.gap, SIZE / 2.0)
        return [
            Ball(id="a", position=place, velocity=start, angular_velocity=spin, radius=self.radius)
        ]

    def read(self, positions: FloatArray) -> FloatArray:
        """Return the velocities of the line after it."""
        towards, along = self.after.of(positions[:, 0])[1]
        return np.array([-towards, along])


@dataclass(frozen=True)
class HitEvent(Event):
    """A ball that rolls to another at rest: both seen afterwards, their places and velocities.

    In axes whose first is the ball's way, from the place of the other: `given` its place in the
    middle of the samples [m], its velocity [m/s], and its side when they meet; `seen` of each ball
    place and velocity in the middle of its samples.
    """

    before: Curve  # a line, its times from the first sample on
    after: tuple[Curve, Curve]

    count: ClassVar[int] = 2

    def balls(self, physics: Physics, given: FloatArray) -> list[Ball]:
        """Return a ball that goes along x to another one."""
        place, velocity, time = given[:2], given[2:4], self.before.middle
        reach = math.sqrt(max(4.0 * self.radius**2 - float(place[1]) ** 2, 0.0))
        meeting = time + float((-place[0] - reach) / velocity[0])
        start, spin = _begun(physics, given[2:], time, meeting, self.radius)
        # So that the mean of its places is that of the track's.
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
        """Return the places and velocities of both lines after it."""
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
    """Return velocity and spin of a rolling ball at the time 0.

    `given`: its velocity at the time `middle` [s] and the side that it has at the time `meeting`;
    until then the cloth slows its spin.
    """
    velocity, side = given[:2], float(given[2])
    speed = float(np.linalg.norm(velocity))
    x, y = (velocity * (_rolling_back(physics, speed, middle) / speed)).tolist()
    slowed = physics.spinning_friction_rate * max(meeting, 0.0)
    spin = side * speed / radius + (math.copysign(slowed, side) if side else 0.0)
    return (x, y), (-y / radius, x / radius, spin)


def _rolling_back(physics: Physics, speed: float, time: float) -> float:
    """Return the speed of a rolling ball `time` [s] before it has `speed` [m/s]."""
    return speed + rolling_deceleration(physics, speed) * time
