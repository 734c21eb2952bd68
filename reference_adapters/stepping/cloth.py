"""What the cloth does to balls between contacts, in closed form: rolling, and sliding before it.

Pymunk sees the table from above and has no cloth. Its own way to slow a ball is a joint (see
`pymunk.world`); where that isn't enough, when steps end at contacts or balls slide, the cloth is
applied from here, between the steps.
"""

from __future__ import annotations

from copy import copy
from functools import cache

import numpy as np

from ghostball.engine.library.entry import Needed
from ghostball.model import EventKind, Samples, Scene, rolling_angular_velocity
from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.reference_adapters.stepping.laws import slips_of
from ghostball.reference_adapters.stepping.slowing import accelerate, last, move, turn

EPS = float(np.finfo(np.float64).eps)

SHORTEST = 1e-6
"""Slides, rolls and spins that would end sooner than this after a contact are over at once [s]."""


class ClosedFormCloth:
    """Velocities and spins of all balls of a scene, advanced exactly while nothing touches.

    `velocities` (n, 2) float64 [m/s].
    `rolling` (n,) bool: which balls roll without slip or rest; the others slide.
    """

    def __init__(self, scene: Scene) -> None:
        gravity = scene.physics.gravity
        self._radii = scene.radii
        self._rolls_by = scene.rolling_frictions * gravity
        self._slides_by = scene.sliding_frictions * gravity
        self._spins_by = scene.spinning_friction_rates
        self._may_slide = scene.physics.motion == "sliding"
        self.velocities = scene.velocities[:, :2].copy()
        # Of a rolling ball only the vertical part is kept; its velocity says the rest.
        self._angular_velocities = scene.angular_velocities
        self.rolling = scene.rolls

    @property
    def _motion(self) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        """What the kernels are given of the balls."""
        return self.velocities, self._angular_velocities, self._radii, self.rolling

    @property
    def angular_velocities(self) -> FloatArray:
        """Angular velocities, (n, 3) float64 [rad/s]; a fresh array."""
        return self._spins(self.velocities)

    @property
    def resting(self) -> BoolArray:
        """Which balls neither move nor spin, (n,) bool; a spin that nothing slows doesn't count."""
        still = np.all(self.velocities == 0.0, axis=1) & self.rolling
        spins = (self._angular_velocities[:, 2] != 0.0) & (self._spins_by > 0.0)
        resting: BoolArray = still & ~spins
        return resting

    def copy(self) -> ClosedFormCloth:
        """Return a cloth with the same motion, which goes on by itself."""
        other = copy(self)
        other.velocities = self.velocities.copy()
        other._angular_velocities = self._angular_velocities.copy()
        other.rolling = self.rolling.copy()
        return other

    def accelerations(self) -> FloatArray:
        """Return the accelerations, (n, 2) [m/s^2], constant until `time_to_change`."""
        accelerations = np.empty_like(self.velocities)
        accelerate(*self._motion, self._rolls_by, self._slides_by, accelerations)
        return accelerations

    def time_to_change(self) -> float:
        """Return the time until some ball stops sliding, rolling or spinning [s], or inf."""
        return _first(self._durations())

    def advance(self, dt: float) -> tuple[FloatArray, list[tuple[EventKind, int]]]:
        """Move on by `dt` without contact.

        Returns the displacements, (n, 2) float64 [m], and which balls began to roll or came to
        rest, in order of time.
        """
        displacements = np.zeros_like(self.velocities)
        changes: list[tuple[EventKind, int]] = []
        left = dt
        while left > 0.0:
            durations = self._durations()
            step = min(left, _first(durations))
            displacements += self._move(step, durations <= step, changes)
            left -= step
        return displacements, changes

    def kick(self, changes: FloatArray, turns: FloatArray | None, dt: float) -> None:
        """Add what the contacts of a step of `dt` [s] did to the velocities, (n, 2) [m/s].

        `turns`, (n, 3) [rad/s], is what they did to the angular velocities; None is nothing.
        """
        if changes.any() or (turns is not None and turns.any()):
            self._kick_all(changes, turns, dt)
            return
        # Most steps. Without a ball that collided, all else that `_kick_all` would do is to write
        # the spins that velocities say into those of rolling balls, which nothing reads before a
        # collision has written them. What is added is 0, and makes a velocity or a spin of -0 one
        # of 0.
        self.velocities = self.velocities + changes
        if turns is not None and self._may_slide:
            self._angular_velocities += turns

    def _kick_all(self, changes: FloatArray, turns: FloatArray | None, dt: float) -> None:
        before = self.velocities
        self.velocities = before + changes
        collided = np.any(changes != 0.0, axis=1)
        # A ball that gives all its speed away stops; what cancellation leaves of it is rounding.
        cancelled = np.abs(self.velocities) <= 4.0 * EPS * np.abs(before)
        self.velocities[collided[:, np.newaxis] & cancelled] = 0.0
        if self._may_slide:
            self._angular_velocities = self._spins(before)
            if turns is not None:
                self._angular_velocities += turns
                collided |= np.any(turns != 0.0, axis=1)
            self._end_slides(collided, max(dt, SHORTEST))
        self._end_rolls(collided & self.rolling, max(dt, SHORTEST))

    def stop(self, ball: int) -> None:
        """Take all its motion from a ball: nothing of it goes on."""
        self.velocities[ball] = self._angular_velocities[ball] = 0.0
        self.rolling[ball] = True

    def state(self, positions: FloatArray) -> Samples:
        """Return the state at `positions`, (n, 2) [m], as arrays (1, n, 3)."""
        return Samples(
            np.column_stack([positions, self._radii])[np.newaxis],
            _in_space(self.velocities)[np.newaxis],
            self._spins(self.velocities)[np.newaxis],
        )

    def _move(
        self, dt: float, ending: BoolArray, changes: list[tuple[EventKind, int]]
    ) -> FloatArray:
        """Advance by `dt`, at most `time_to_change`, and return the displacements.

        `ending`, (n, 2), says which of `_durations` end with it.

        Slide: a = -mu_s g u^, and the same force turns the ball by 5 mu_s g / 2R of angular
        acceleration, so that the slip u falls by 7/2 mu_s g per second in a fixed direction.
        """
        sliding = ~self.rolling
        moving = np.any(self.velocities != 0.0, axis=1)
        accelerations = self.accelerations()
        displacements = np.empty_like(self.velocities)
        move(dt, self.velocities, accelerations, displacements)
        if self._may_slide:
            turn(
                dt,
                self._angular_velocities,
                accelerations,
                self._radii,
                sliding,
                self._spins_by,
                # One layout, whatever the number of balls, or each would be compiled for.
                np.ascontiguousarray(ending[:, 1]),
            )
        # What ends together with another by all but rounding may have nothing left although its
        # own duration was longer: it ends here too, for a ball that counted as sliding without
        # slip would have no friction until the end of the next step.
        over = ending[:, 0] | (self._durations()[:, 0] == 0.0)
        starts_rolling, stops = sliding & over, self.rolling & moving & over
        self.rolling |= starts_rolling
        self.velocities[stops] = 0.0
        changes += [(EventKind.SLIDE_TO_ROLL, int(i)) for i in np.flatnonzero(starts_rolling)]
        changes += [(EventKind.ROLL_TO_REST, int(i)) for i in np.flatnonzero(stops)]
        return displacements

    def _durations(self) -> FloatArray:
        """Return how long each ball keeps sliding or rolling, and keeps spinning, (n, 2) [s].

        0 is "doesn't now"; inf is "for ever".
        """
        durations = np.empty((len(self.rolling), 2))
        last(*self._motion, self._rolls_by, self._slides_by, self._spins_by, durations)
        return durations

    def _end_rolls(self, collided: BoolArray, shortest: float) -> None:
        """Stop the rolling balls that collided and would roll for less than `shortest` [s].

        As for slides, see `_end_slides`.
        """
        speeds = np.hypot(self.velocities[:, 0], self.velocities[:, 1])
        self.velocities[collided & (speeds <= shortest * self._rolls_by)] = 0.0

    def _end_slides(self, collided: BoolArray, shortest: float) -> None:
        """Find out which of the balls that collided slide now, for more than `shortest` [s].

        A slide that would be over sooner than the contact's step was long is over at once: the
        velocity is the same, and the place within mu_s g t^2 / 2. Else a rolling ball that another
        presses on, which only friction holds, would slide a little after each step, without the
        rolling resistance that it still has, and the steps that end with every slide would shrink
        until they hardly move the clock.
        """
        slip = slips_of(self.velocities, self._angular_velocities, self._radii)
        rolls = np.hypot(slip[:, 0], slip[:, 1]) <= 3.5 * shortest * self._slides_by
        self.rolling = np.where(collided, rolls, self.rolling)
        self.velocities[collided & rolls] -= 2.0 / 7.0 * slip[collided & rolls]
        spin = self._angular_velocities[:, 2]
        spin[collided & (np.abs(spin) <= shortest * self._spins_by)] = 0.0

    def _spins(self, velocities: FloatArray) -> FloatArray:
        """Return the angular velocities, (n, 3) [rad/s], of balls with `velocities`, (n, 2)."""
        tied = rolling_angular_velocity(_in_space(velocities), self._radii)
        tied[:, 2] = self._angular_velocities[:, 2]
        return np.where(self.rolling[:, np.newaxis], tied, self._angular_velocities)


@cache
def warm_up() -> None:
    """Load all that is compiled here, once in a process: no run's time should hold it."""
    for one in needed():
        one.load()


def needed() -> tuple[Needed, ...]:
    """Return the kernels that are called here, to be compiled or loaded."""
    name, numbers, flags = "cloth between steps", np.ones(1), np.zeros(1, dtype=np.bool_)
    v, w = np.zeros((1, 2)), np.zeros((1, 3))
    motion, slowing = (v, w, numbers, flags), (numbers, numbers)
    return (
        Needed(accelerate, (*motion, *slowing, v), f"{name}: accelerations"),
        Needed(last, (*motion, *slowing, numbers, v), f"{name}: durations"),
        Needed(move, (0.0, v, v, v), f"{name}: motion"),
        Needed(turn, (0.0, w, v, numbers, flags, numbers, flags), f"{name}: spins"),
    )


def _in_space(vectors: FloatArray) -> FloatArray:
    """Return vectors of the plane, (n, 2), with a vertical part of 0, (n, 3)."""
    spatial = np.zeros((len(vectors), 3))
    spatial[:, :2] = vectors
    return spatial


def _first(durations: FloatArray) -> float:
    """Return the shortest duration that isn't 0, or inf."""
    return float(np.min(durations, initial=np.inf, where=durations > 0.0))
