"""Bullet in the plane: balls that roll, without gravity or a table, as in the paper's model.

Bullet finds and resolves the collisions and moves the balls. Rolling resistance isn't a law of its
planar bodies, so it is applied here, as two half kicks around each step of Bullet:

    v_mean = v - mu g dt/2;   Bullet: collide, then x += v_mean dt;   v = v_mean - mu g dt/2

which between collisions is the closed form v t - mu g t^2/2 at any `dt`; a single kick a step
leaves a bias of v dt/2 in the distance. A ball that stops within the step gets the mean velocity
that takes it to where it stops.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ghostball.model import EventKind, Samples, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.pybullet.steps import BulletSteps
from ghostball.reference_adapters.recording import rolling_state
from ghostball.reference_adapters.stepping.contact_time import rolling_accelerations, time_to_rest
from ghostball.reference_adapters.stepping.ends import Ends, Motion
from ghostball.reference_adapters.stepping.plane import InPlane
from ghostball.reference_adapters.stepping.pocketing import instant_of

if TYPE_CHECKING:
    from ghostball.reference_adapters.pybullet.world import World

EPS = float(np.finfo(np.float64).eps)

Vectors = list[list[float]]
"""One of two components for each ball: with so few, numpy would cost its calls at every step."""


class Rolling(BulletSteps, InPlane):
    """Steps of balls that roll; one rests when its velocity is exactly 0.

    In steps that end at contacts, one gets there, one overlaps, one lets Bullet resolve: it sees
    spheres from the first step that starts with an overlap.
    """

    ROLLS: ClassVar[bool] = True

    def __init__(self, scene: Scene, world: World, ends: Ends) -> None:
        super().__init__(scene, ends)
        self._world = world
        self._decelerations = scene.rolling_frictions * scene.physics.gravity
        self._slowed_by: list[float] = self._decelerations.tolist()
        self._velocities: Vectors = scene.velocities[:, :2].tolist()

    @property
    def at_rest(self) -> bool:
        """Whether every ball's velocity is exactly 0."""
        return not any(x or y for x, y in self._velocities)

    def state(self) -> Samples:
        """Return the state now, arrays (1, n, 3); z is the radius, spin that of rolling."""
        return self._rolling(self._places(), self._velocities)

    def _motion(self) -> Motion:
        velocities, here = np.array(self._velocities), self._pocketing.here
        stops = time_to_rest(velocities, self._decelerations)
        return Motion(
            self._places()[here],
            velocities[here],
            rolling_accelerations(velocities, self._decelerations)[here],
            self._radii[here],
            # Up to the next stop, and by a few roundings past it, so that the ball does stop.
            float(np.min(stops[stops > 0.0])) * (1.0 + 4.0 * EPS),
        )

    def _advance(self, dt: float, t: float) -> None:
        before, speeds = self._velocities, _speeds(self._velocities)
        # Most steps need no places.
        asked = self._pocketing or self._corners
        started_at = self._places() if asked else np.empty((0, 2))
        self._world.start(np.array(self._mean_velocities(speeds, dt)), None)
        self._world.step(dt)
        self._take_collisions(self._world.collisions, started_at)
        pushed, after = self._world.pushed, self._world.velocities()
        self._notes, self._around = [], ()
        if self.recorded and self.collisions:
            places = self._places() - np.array(after) * dt
            changed = [after[i] if i in pushed else v for i, v in enumerate(before)]
            self._around = self._rolling(places, before), self._rolling(places, changed)
        self._velocities = self._second_half_kick(after, dt)
        self.seen_at, self.t = self.t, t
        if self._pocketing:
            self._let_fall(started_at)
        for i, (speed, (x, y)) in enumerate(zip(speeds, self._velocities, strict=True)):
            if speed > 0.0 and not (x or y) and not self._pocketing.gone[i]:
                # One that Bullet left alone stops where the closed form says, within the step.
                slowed_by = 0.0 if i in pushed else self._slowed_by[i]
                stops_at = self.seen_at + (min(dt, speed / slowed_by) if slowed_by else dt)
                self._notes.append((stops_at, EventKind.ROLL_TO_REST, i, -1))
                self._note_rest(stops_at)

    def _let_fall(self, before: FloatArray) -> None:
        """Take out the balls that fell on their way from `before`, (n, 2) [m], in this step."""
        after = self._places()
        self.falls = self._pocketing.take(before, after)
        self._note_falls(before, self._rolling(after, self._velocities) if self.falls else None)
        for fall in self.falls:
            self._note_rest(instant_of(fall, self.seen_at, self.t))
            self._world.remove(fall.ball)
            self._velocities[fall.ball] = [0.0, 0.0]

    def _places(self) -> FloatArray:
        places = self._world.positions()[:, :2]
        self._pocketing.keep(places)
        return places

    def _rolling(self, places: FloatArray, velocities: Vectors) -> Samples:
        return rolling_state(places[np.newaxis], np.array(velocities)[np.newaxis], self._radii)

    def _mean_velocities(self, speeds: list[float], dt: float) -> Vectors:
        """Return what each ball has on average in the coming step: v (|v| - mu g dt/2) / |v|."""
        means = []
        for slowed_by, speed, (x, y) in zip(self._slowed_by, speeds, self._velocities, strict=True):
            factor = 0.0
            if speed > 0.0:
                loss = slowed_by * dt
                mean = speed * speed / (2.0 * loss) if speed < loss else speed - 0.5 * loss
                factor = mean / speed
            means.append([x * factor, y * factor])
        return means

    def _second_half_kick(self, velocities: Vectors, dt: float) -> Vectors:
        """Return the velocities at the end of the step [m/s].

        A ball that stopped in it had at most mu g dt/2 of mean velocity, so it gets exactly 0.
        """
        kicked = []
        for slowed_by, speed, (x, y) in zip(
            self._slowed_by, _speeds(velocities), velocities, strict=True
        ):
            factor = max(speed - 0.5 * slowed_by * dt, 0.0) / speed if speed > 0.0 else 0.0
            kicked.append([x * factor, y * factor])
        return kicked


def _speeds(velocities: Vectors) -> list[float]:
    """Return the lengths of vectors; by numpy, whose last bit `math.hypot` doesn't always share."""
    x, y = np.array(velocities).T
    speeds: list[float] = np.hypot(x, y).tolist()
    return speeds
