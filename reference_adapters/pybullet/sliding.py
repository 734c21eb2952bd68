"""Bullet in space: balls that slide until they roll, with gravity, on a table.

All physics is Bullet's own: Coulomb friction on the table turns sliding into rolling, and a moment
of rolling friction stops the ball. That moment would act while a ball slides, too, which the
scene's law excludes; so it is switched on for a ball only while its contact doesn't slip.

Bullet solves the velocities and moves the balls by the result, so a distance under a deceleration a
is short by up to v dt/2: first order in `dt`, where the planar run has no such error.
"""

from __future__ import annotations

import numpy as np

from ghostball.model import EventKind, Samples, Scene
from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.reference_adapters.pybullet.world import Contact, World
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters.stepping.clock import Clock
from ghostball.reference_adapters.stepping.laws import slips_of
from ghostball.reference_adapters.stepping.pocketing import (
    Pocketing,
    instant_of,
    states_at_falls,
)
from ghostball.reference_adapters.stepping.sides import sides_of
from ghostball.reference_adapters.stepping.space import slowest_bounce

ROLLING_SLIP = 1e-6
"""Slip of the contact point below which a ball rolls [m/s].

Bullet's solver leaves 1e-11 or less once friction holds; a step of 0.1 ms takes 7e-4 from a ball
that still slides on mu = 0.2.
"""


class SlidingRun:
    """The run of one scene whose balls slide.

    `dt` [s]: of its steps.
    `gated`: whether rolling friction waits for rolling; without it Bullet applies it at all times.
    `rest_speed` [m/s]: a ball rests while its centre's speed and its surface's, R |w|, are both
        below this.

    `t`, `rest_time`, `work`: as in `PlanarRun`.
    """

    def __init__(
        self,
        world: World,
        scene: Scene,
        recorder: Recorder,
        *,
        dt: float,
        gated: bool,
        rest_speed: float,
    ) -> None:
        self._world = world
        self._recorder = recorder
        self._radii = scene.radii
        self._dt = dt
        self._spin_ends = scene.spinning_friction_rates > 0.0
        self._gated = gated
        self._rest_speed = rest_speed
        self._flies = scene.physics.airborne
        self._noses = sides_of(scene) if scene.physics.airborne else []
        self._gone = np.zeros(len(scene.balls), dtype=np.bool_)
        self._pocketing = Pocketing(scene)
        self._height = scene.physics.cushion_height
        # What falls no faster lies on the table, and what is no higher than it could bounce.
        self._slow = slowest_bounce(scene, dt)
        self._low = self._slow * dt
        self.t = 0.0
        self.rest_time = 0.0
        self.work = {"steps": 0, "contacts": 0}
        for i, (v, w) in enumerate(zip(scene.velocities, scene.angular_velocities, strict=True)):
            world.set_velocity(i, v.tolist(), w.tolist())
        self._velocities, self._spins = scene.velocities, scene.angular_velocities
        self._resting = self._rests()
        self._spinning = self._spins_on()
        self._rolling = self._rolls()
        if gated:
            for i in np.flatnonzero(~self._rolling).tolist():
                world.set_rolling_friction(i, False)
        recorder.frame(0.0, self.state())

    @property
    def at_rest(self) -> bool:
        """Whether every ball is slower than `rest_speed`, and none has a spin that still slows."""
        return bool(np.all(self._resting) and not np.any(self._spinning))

    def state(self) -> Samples:
        """Return the state now, arrays (1, n, 3)."""
        return self._samples(self._positions(), self._velocities, self._spins)

    def run(self, t_end: float, max_steps: int) -> None:
        """Run until every ball rests, or to `t_end` exactly, in steps of `dt`."""
        clock = Clock(self._dt, t_end)
        while not self.at_rest and clock.t < t_end and self.work["steps"] < max_steps:
            self._advance(clock.dt, clock.tick())

    def _positions(self) -> FloatArray:
        positions = self._world.positions()
        self._pocketing.keep(positions)
        return positions

    def _advance(self, dt: float, t: float) -> None:
        started_at = self._positions() if self._pocketing else None
        self._world.step(dt)
        self.work["steps"] += 1
        contacts, new = self._world.contacts()
        self.work["contacts"] += len(contacts)
        before = self._velocities, self._spins
        states = np.array([self._world.velocity(i) for i in range(len(self._radii))])
        self._velocities, self._spins = states[:, 0], states[:, 1]
        new = [c for c in new if c.b >= 0 or before[0][c.a, 2] < -self._slow]
        if new:
            self._note_collisions(new, before, dt)
        if started_at is not None:
            self._let_fall(started_at, t)
        self.t = t
        if self._noses:
            self._take_out_what_left()
        self._note_phases()
        # A ball that fell may have been the last to move: then the shot ended within the step.
        if not self.at_rest and self._recorder.wants_frame(t):
            self._recorder.frame(t, self.state())

    def _rests(self) -> BoolArray:
        speed = np.sqrt(np.sum(self._velocities**2, axis=1))
        surface = self._radii * np.sqrt(np.sum(self._spins[:, :2] ** 2, axis=1))
        rests: BoolArray = (np.maximum(speed, surface) < self._rest_speed) & self._lies()
        return rests

    def _lies(self) -> BoolArray:
        """Whether each ball is on the table, or has left the game."""
        if not self._flies:
            return np.ones(len(self._radii), dtype=np.bool_)
        low = self._world.positions()[:, 2] - self._radii <= self._low
        slow = np.abs(self._velocities[:, 2]) <= self._slow
        lies: BoolArray = (low & slow) | self._gone
        return lies

    def _take_out_what_left(self) -> None:
        """Take out the balls whose centres have come over a nose that is below them."""
        positions = self._world.positions()
        for side in self._noses:
            away = (positions[:, :2] - side.point) @ side.normal
            out = (away < 0.0) & (positions[:, 2] > self._height) & ~self._gone
            for i in np.flatnonzero(out).tolist():
                self._recorder.event(self.t, EventKind.LEAVES_TABLE, i, side.cushion)
                self._world.remove(i)
                self._gone[i] = True
                self._velocities[i] = self._spins[i] = 0.0

    def _let_fall(self, before: FloatArray, t: float) -> None:
        """Take out the balls that fell on the way from `before`, (n, 3) [m], until `t` [s]."""
        after = self._positions()
        falls = self._pocketing.take(before[:, :2], after[:, :2])
        moving = self._samples(after, self._velocities.copy(), self._spins.copy())
        for fall, state in states_at_falls(before[:, :2], moving, falls):
            self._recorder.frame(instant_of(fall, self.t, t), state, force=True)
        for fall in falls:
            at, ball = instant_of(fall, self.t, t), fall.ball
            self._recorder.event(at, EventKind.POCKETED, ball, fall.pocket)
            self.rest_time = max(self.rest_time, at)
            self._world.remove(ball)
            self._velocities[ball] = self._spins[ball] = 0.0
            self._resting[ball] = self._rolling[ball] = True
            self._spinning[ball] = False

    def _spins_on(self) -> BoolArray:
        """Whether each ball has a spin about the vertical that will end, and hasn't yet."""
        surface = self._radii * np.abs(self._spins[:, 2])
        spins: BoolArray = self._spin_ends & (surface >= self._rest_speed)
        return spins

    def _rolls(self) -> BoolArray:
        """Whether each ball's lowest point rests on the cloth."""
        slips = slips_of(self._velocities, self._spins, self._radii)
        rolls: BoolArray = (np.hypot(*slips.T) < ROLLING_SLIP) & self._lies()
        return rolls

    def _note_phases(self) -> None:
        """Record what began to roll or came to rest in the step, at its end; set the gates."""
        rolls, rests, spins = self._rolls(), self._rests(), self._spins_on()
        if self._gated:
            for i in np.flatnonzero(rolls != self._rolling).tolist():
                self._world.set_rolling_friction(i, bool(rolls[i]))
        for i in np.flatnonzero(rolls & ~self._rolling & ~rests).tolist():
            self._recorder.event(self.t, EventKind.SLIDE_TO_ROLL, i)
        for i in np.flatnonzero(rests & ~self._resting).tolist():
            self._recorder.event(self.t, EventKind.ROLL_TO_REST, i)
        if np.any(rests & ~self._resting) or np.any(self._spinning & ~spins):
            self.rest_time = self.t
        self._rolling, self._resting, self._spinning = rolls, rests, spins

    def _note_collisions(
        self, new: list[Contact], before: tuple[FloatArray, FloatArray], dt: float
    ) -> None:
        """Record collisions, at the step's start: there Bullet saw them and changed velocities."""
        for contact in new:
            self._recorder.event(self.t, contact.kind, contact.a, contact.b)
        if self._recorder.record == "trajectory":
            positions = self._positions() - self._velocities * dt
            for velocities, spins in (before, (self._velocities, self._spins)):
                state = self._samples(positions, velocities, spins)
                self._recorder.frame(self.t, state, force=True)

    def _samples(self, positions: FloatArray, velocities: FloatArray, spins: FloatArray) -> Samples:
        return Samples(positions[np.newaxis], velocities[np.newaxis], spins[np.newaxis])
