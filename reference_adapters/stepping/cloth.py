"""Cloth friction on balls between contacts, in closed form: rolling, and sliding before it.

2D engines see the table from above and have no cloth. In Pymunk, a joint can slow a ball (see
`pymunk.world`). If this isn't enough, because steps end at contacts or balls slide, this module
applies the cloth friction between the steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ghostball.engine.library.entry import Needed
from ghostball.model import EventKind, Samples, Scene, rolling_angular_velocity
from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.reference_adapters.stepping.laws import slips_of
from ghostball.reference_adapters.stepping.slowing import (
    accelerate,
    advance_steps,
    advance_within_phases,
    all_rest,
    last,
    move,
    turn,
)

EPS = float(np.finfo(np.float64).eps)

SHORTEST_PHASE = 1e-6
"""Slides, rolls and spins shorter than this time after a contact end at once [s]."""


class Steps(NamedTuple):
    """The motion in coming steps of equal length in which nothing touches, and no phase ends.

    `means`: (k, n, 2) float64 [m/s], mean velocities in each step.
    `velocities`, `spins`: (k + 1, n, 2) float64 [m/s] and (k + 1, n, 3) float64 [rad/s], the motion
        at the start of each step, and at the end of the last step; more rows have no meaning.
    """

    means: FloatArray
    velocities: FloatArray
    spins: FloatArray


class ClosedFormCloth:
    """Velocities and spins of all balls of a scene, advanced exactly while nothing touches.

    `velocities`: (n, 2) float64 [m/s].
    `rolling`: (n,) bool, which balls roll without slip or rest; the remaining balls slide.
    `stopped`: whether a ball stopped sliding, rolling or spinning in the last call of `advance`.
    """

    def __init__(self, scene: Scene) -> None:
        gravity = scene.physics.gravity
        self._radii = scene.radii
        self._rolls_by = scene.rolling_frictions * gravity
        self._slides_by = scene.sliding_frictions * gravity
        self._spins_by = scene.spinning_friction_rates
        self._may_slide = scene.physics.motion == "sliding"
        self.velocities = scene.velocities[:, :2].copy()
        # For a rolling ball, only the vertical component is stored; the velocity determines the
        # rest.
        self._angular_velocities = scene.angular_velocities
        self.rolling = scene.rolls
        self.stopped = False
        # The kernel of the last step, bound to its arrays, and the duration of the step.
        self._again: Callable[[], Any] | None = None
        self._last_dt = math.nan
        self._displacements: FloatArray = np.empty(0)

    @property
    def _motion(self) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        """The arguments of the kernels that describe the motion."""
        return self.velocities, self._angular_velocities, self._radii, self.rolling

    @property
    def angular_velocities(self) -> FloatArray:
        """Angular velocities, (n, 3) float64 [rad/s]; a new array."""
        return self._spins(self.velocities)

    @property
    def at_rest(self) -> bool:
        """Whether no ball moves or spins; spin that doesn't decay isn't counted."""
        rest: bool = all_rest(
            self.velocities, self._angular_velocities, self.rolling, self._spins_by
        )
        return rest

    def copy(self) -> ClosedFormCloth:
        """Return a copy with the same motion, which can be advanced independently."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)  # `copy.copy` takes as long as a step of an engine
        other.velocities = self.velocities.copy()
        other._angular_velocities = self._angular_velocities.copy()
        other.rolling = self.rolling.copy()
        other._again = None
        return other

    def accelerations(self) -> FloatArray:
        """Return the accelerations, (n, 2) [m/s^2], constant until `time_to_change`."""
        accelerations = np.empty_like(self.velocities)
        accelerate(*self._motion, self._rolls_by, self._slides_by, accelerations)
        return accelerations

    def time_to_change(self) -> float:
        """Return the time until a ball stops sliding, rolling or spinning [s], or inf."""
        return _first(self._durations())

    def advance(self, dt: float) -> tuple[FloatArray, list[tuple[EventKind, int]]]:
        """Advance by `dt` without contacts.

        Returns the displacements, (n, 2) float64 [m], valid until the next call, and the balls that
        started to roll or came to rest, in order of time.
        """
        changes: list[tuple[EventKind, int]] = []
        self.stopped = False
        if self._again is not None and dt == self._last_dt and self._again():
            return self._displacements, changes
        displacements = np.zeros(self.velocities.shape)
        by = self._rolls_by, self._slides_by, self._spins_by
        arguments = dt, *self._motion, *by, self._may_slide, displacements
        if advance_within_phases(*arguments):
            self._displacements = displacements
            self._again = advance_within_phases.bind(*arguments) if dt == self._last_dt else None
            self._last_dt = dt
            return displacements, changes
        self.stopped = True
        left = dt
        while left > 0.0:
            durations = self._durations()
            step = min(left, _first(durations))
            displacements += self._move(step, durations <= step, changes)
            left -= step
        return displacements, changes

    def steps(self, dt: float, most: int) -> Steps:
        """Return the motion in the next steps of `dt` [s], at most `most`, without contacts.

        The bits are those of `advance` and `keep` in each step. The present motion isn't changed;
        see `set_motion`.
        """
        n = len(self.rolling)
        means, velocities = np.empty((most, n, 2)), np.empty((most + 1, n, 2))
        spins = np.empty((most + 1, n, 3))
        count = advance_steps(
            dt,
            self.velocities.copy(),
            self._angular_velocities.copy(),
            self._radii,
            self.rolling,
            self._rolls_by,
            self._slides_by,
            self._spins_by,
            self._may_slide,
            means,
            velocities,
            spins,
        )
        return Steps(means[:count], velocities, spins)

    def set_motion(self, steps: Steps, step: int) -> None:
        """Set the motion at the start of one of the steps that `steps` returned."""
        self.velocities, self._angular_velocities = steps.velocities[step], steps.spins[step]
        self._again = None

    def kick(self, changes: FloatArray, turns: FloatArray | None, dt: float) -> None:
        """Add the velocity changes caused by the contacts of a step of `dt` [s], (n, 2) [m/s].

        `turns`, (n, 3) [rad/s], are the changes of the angular velocities; None means no change.
        """
        if changes.any() or (turns is not None and turns.any()):
            self._kick_all(changes, turns, dt)
            return
        self.keep(rubs=turns is not None)

    def keep(self, *, rubs: bool) -> None:
        """Keep the motion in a step without contacts; same bits as `kick` with changes of 0.

        `rubs`: whether `kick` would get `turns`.
        """
        # Without a collision, `_kick_all` would only write the spins determined by the velocities
        # into those of rolling balls, which nothing reads before a collision has written them.
        # Adding 0 turns a velocity or spin of -0 into 0.
        self.velocities += 0.0
        if rubs and self._may_slide:
            self._angular_velocities += 0.0

    def _kick_all(self, changes: FloatArray, turns: FloatArray | None, dt: float) -> None:
        before, self._again = self.velocities, None
        self.velocities = before + changes
        collided = np.any(changes != 0.0, axis=1)
        # A ball that transfers all its speed stops; the remainder of the cancellation is rounding.
        cancelled = np.abs(self.velocities) <= 4.0 * EPS * np.abs(before)
        self.velocities[collided[:, np.newaxis] & cancelled] = 0.0
        if self._may_slide:
            self._angular_velocities = self._spins(before)
            if turns is not None:
                self._angular_velocities += turns
                collided |= np.any(turns != 0.0, axis=1)
            self._end_slides(collided, max(dt, SHORTEST_PHASE))
        self._end_rolls(collided & self.rolling, max(dt, SHORTEST_PHASE))

    def stop(self, ball: int) -> None:
        """Stop a ball: set its velocity and spin to 0."""
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

        `ending`, (n, 2), marks the entries of `_durations` that end with this step.

        While sliding, a = -mu_s g u^. The same force gives an angular acceleration of 5 mu_s g /
        2R, so the slip u decreases by 7/2 mu_s g per second in a fixed direction.
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
                # The same memory layout for any number of balls, to avoid compiling a second
                # version.
                np.ascontiguousarray(ending[:, 1]),
            )
        # A phase that ends together with another one up to rounding may have no time left, although
        # its duration was longer. It ends here too: a ball that counts as sliding without slip
        # would have no friction until the end of the next step.
        over = ending[:, 0] | (self._durations()[:, 0] == 0.0)
        starts_rolling, stops = sliding & over, self.rolling & moving & over
        self.rolling |= starts_rolling
        self.velocities[stops] = 0.0
        changes += [(EventKind.SLIDE_TO_ROLL, int(i)) for i in np.flatnonzero(starts_rolling)]
        changes += [(EventKind.ROLL_TO_REST, int(i)) for i in np.flatnonzero(stops)]
        return displacements

    def _durations(self) -> FloatArray:
        """Return how long each ball keeps sliding or rolling, and spinning, (n, 2) [s].

        0 means that the ball doesn't slide, roll or spin now; inf means that it never stops.
        """
        durations = np.empty((len(self.rolling), 2))
        last(*self._motion, self._rolls_by, self._slides_by, self._spins_by, durations)
        return durations

    def _end_rolls(self, collided: BoolArray, shortest: float) -> None:
        """Stop the rolling balls that collided and would roll for less than `shortest` [s].

        The reason is the same as for slides, see `_end_slides`.
        """
        speeds = np.hypot(self.velocities[:, 0], self.velocities[:, 1])
        self.velocities[collided & (speeds <= shortest * self._rolls_by)] = 0.0

    def _end_slides(self, collided: BoolArray, shortest: float) -> None:
        """Determine which of the balls that collided slide now, for more than `shortest` [s].

        A slide shorter than the step of the contact ends at once: the velocity is the same, and the
        position error is at most mu_s g t^2 / 2. Otherwise, a rolling ball that a different ball
        presses on, and that only friction holds, would slide a little after each step, without its
        rolling friction, and steps that end with every slide would become so short that the clock
        hardly moves.
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
    """Load all kernels of this module once per process, before any run time is measured."""
    for one in needed():
        one.load()


def needed() -> tuple[Needed, ...]:
    """Return the kernels that this module calls, for compilation or loading."""
    name, numbers, flags = "cloth between steps", np.ones(1), np.zeros(1, dtype=np.bool_)
    v, w = np.zeros((1, 2)), np.zeros((1, 3))
    vs, ws = np.zeros((1, 1, 2)), np.zeros((1, 1, 3))
    motion, slowing = (v, w, numbers, flags), (numbers, numbers)
    return (
        Needed(accelerate, (*motion, *slowing, v), f"{name}: accelerations"),
        Needed(last, (*motion, *slowing, numbers, v), f"{name}: durations"),
        Needed(move, (0.0, v, v, v), f"{name}: motion"),
        Needed(
            advance_within_phases,
            (0.0, *motion, *slowing, numbers, True, v),
            f"{name}: motion within phases",
        ),
        Needed(
            advance_steps,
            (0.0, *motion, *slowing, numbers, True, vs, vs, ws),
            f"{name}: motion in many steps",
        ),
        Needed(all_rest, (v, w, flags, numbers), f"{name}: rest"),
        Needed(turn, (0.0, w, v, numbers, flags, numbers, flags), f"{name}: spins"),
    )


def _in_space(vectors: FloatArray) -> FloatArray:
    """Return vectors in the plane, (n, 2), with a vertical component of 0, (n, 3)."""
    spatial = np.zeros((len(vectors), 3))
    spatial[:, :2] = vectors
    return spatial


def _first(durations: FloatArray) -> float:
    """Return the shortest duration that isn't 0, or inf."""
    return float(np.min(durations, initial=np.inf, where=durations > 0.0))
