"""Bullet in space: balls that slide until they roll, with gravity, on a table.

All physics is Bullet's own: Coulomb friction on the table turns sliding into rolling, and a moment
of rolling friction stops the ball. That moment would act while a ball slides, too, which the
scene's law excludes; so it is switched on for a ball only while its contact doesn't slip.

Bullet solves the velocities and moves the balls by the result, so a distance under a deceleration a
is short by up to v dt/2: first order in `dt`, where the planar run has no such error.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ghostball.model import EventKind, Samples, Scene
from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.reference_adapters.pybullet.settings import PybulletSettings
from ghostball.reference_adapters.pybullet.steps import BulletSteps
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters.stepping.pocketing import instant_of
from ghostball.reference_adapters.stepping.sides import sides_of
from ghostball.reference_adapters.stepping.space import OnItsOwnCloth, slowest_bounce

if TYPE_CHECKING:
    from ghostball.reference_adapters.pybullet.world import World

ROLLING_SLIP = 1e-6
"""Slip of the contact point below which a ball rolls [m/s].

Bullet's solver leaves 1e-11 or less once friction holds; a step of 0.1 ms takes 7e-4 from a ball
that still slides on mu = 0.2.
"""


class Sliding(BulletSteps, OnItsOwnCloth):
    """Steps of balls that slide, or fly; one rests as `PybulletSettings.rest_speed` says.

    Tuned, rolling friction waits for rolling; else Bullet applies it at all times.
    """

    _world: World

    def __init__(
        self, scene: Scene, world: World, settings: PybulletSettings, t_end: float
    ) -> None:
        # Balls may leave over noses: other engines in space have no cushions in flight.
        self._noses = sides_of(scene) if scene.physics.airborne else ()
        self._gone = np.zeros(len(scene.balls), dtype=np.bool_)
        super().__init__(scene, world, settings.step, t_end)
        self._gated = settings.config == "tuned"
        self._rest_speed = settings.rest_speed
        self._spin_ends = scene.spinning_friction_rates > 0.0
        self._height = scene.physics.cushion_height
        self._lands: list[int] = []
        # As the world has it: of the step that is set, not of the one that ends at `t_end`.
        self._slowest_fall = slowest_bounce(scene, settings.step)
        self._lowest_bounce = self._slowest_fall * settings.step
        self._no_slip = np.full(len(scene.balls), ROLLING_SLIP)
        self._resting, self._spinning, self._rolling = self._rests(), self._turns(), self._rolls()
        if self._gated:
            for i in np.flatnonzero(~self._rolling).tolist():
                world.set_rolling_friction(i, False)

    @property
    def at_rest(self) -> bool:
        """Whether every ball is slower than `rest_speed`, and none has a spin that still slows."""
        return bool(self._resting.all() and not self._spinning.any())

    def step(self) -> None:
        """Let Bullet step by dt; then switch the rolling friction of balls that roll."""
        velocities, spins, places = self._velocities, self._spins, self._centres[:, :2]
        self._lands = self._step_and_land()
        self._pocketing.keep(self._centres)
        self._notes, self._around = [], ()
        if self.recorded and (self.collisions or self._lands):
            back = self._centres - self._velocities * self._clock.dt
            motions = (velocities, spins), (self._velocities.copy(), self._spins.copy())
            self._around = tuple(
                Samples(back[np.newaxis], v[np.newaxis], w[np.newaxis]) for v, w in motions
            )
        if self._pocketing:
            self._let_fall(places)
        if self._noses:
            self._take_out_what_left()
        self._note_phases()

    def _rests(self) -> BoolArray:
        speed = np.sqrt(np.sum(self._velocities**2, axis=1))
        surface = self._radii * np.sqrt(np.sum(self._spins[:, :2] ** 2, axis=1))
        rests: BoolArray = (np.maximum(speed, surface) < self._rest_speed) & self._lies()
        return rests

    def _lies(self) -> BoolArray:
        """Whether each ball is on the table, or has left the game."""
        lies = super()._lies()
        return lies | self._gone if self._noses else lies

    def _turns(self) -> BoolArray:
        """Whether each ball has a spin about the vertical that will end, and hasn't yet."""
        surface = self._radii * np.abs(self._spins[:, 2])
        turns: BoolArray = self._spin_ends & (surface >= self._rest_speed)
        return turns

    def _take_out_what_left(self) -> None:
        """Take out the balls whose centres have come over a nose that is below them."""
        for side in self._noses:
            away = (self._centres[:, :2] - side.point) @ side.normal
            out = (away < 0.0) & (self._centres[:, 2] > self._height) & ~self._gone
            for i in np.flatnonzero(out).tolist():
                self._notes.append((self.t, EventKind.LEAVES_TABLE, i, side.cushion))
                self._world.remove(i)
                self._gone[i] = True
                self._velocities[i] = self._spins[i] = 0.0

    def _let_fall(self, before: FloatArray) -> None:
        super()._let_fall(before)
        for fall in self.falls:
            self._note_rest(instant_of(fall, self.seen_at, self.t))
            self._resting[fall.ball], self._spinning[fall.ball] = True, False

    def _note_phases(self) -> None:
        """Note what began to roll or came to rest in the step, at its end; set the gates."""
        rolls, rests, turns = self._rolls(), self._rests(), self._turns()
        if self._gated:
            for i in np.flatnonzero(rolls != self._rolling).tolist():
                self._world.set_rolling_friction(i, bool(rolls[i]))
        stops = rests & ~self._resting
        for kind, which in (
            (EventKind.SLIDE_TO_ROLL, rolls & ~self._rolling & ~rests),
            (EventKind.ROLL_TO_REST, stops),
        ):
            self._notes += [(self.t, kind, i, -1) for i in np.flatnonzero(which).tolist()]
        if np.any(stops) or np.any(self._spinning & ~turns):
            self.rest_time = self.t
        self._rolling, self._resting, self._spinning = rolls, rests, turns

    def _tell_of_collisions(self, recorder: Recorder) -> None:
        super()._tell_of_collisions(recorder)
        for ball in self._lands:
            recorder.event(self.seen_at, EventKind.BALL_CLOTH, ball)
