"""The stepper of a world in which the engine's own joints slow rolling balls."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from ghostball.model import EventKind, Samples, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.recording import rolling_state
from ghostball.reference_adapters.stepping import plane
from ghostball.reference_adapters.stepping.laws import tangential_restitution
from ghostball.reference_adapters.stepping.sides import Normals
from ghostball.reference_adapters.stepping.step_ends import Clock


class JointWorld(plane.PlaneWorld, Protocol):
    """A world with joints that slow balls."""

    def add_rolling_joints(self) -> None:
        """Slow every ball by mu g with a joint of limited force to the table."""
        ...

    def set_velocities(self, velocities: FloatArray) -> None:
        """Set the velocities, (n, 2) float64 [m/s]."""
        ...


class JointStepper(plane.WorldStepper):
    """Fixed steps in which the engine's own joints slow rolling balls.

    `joints`: whether the world has joints; without, the adapter slows the balls after each step.
    `leapfrog`: whether the velocities belong to the middle of a step, for an engine like Pymunk.
    `rounding`: rounding of a speed that a joint has stopped, relative to its effect per step [1].

    Chipmunk moves a ball before it changes its velocity. The tuned joint reduces the speed by
    exactly mu g dt in each step. Half of this before the first step makes the method a leapfrog:
    velocities belong to the middle of the coming step, and a roll ends within mu g dt^2 / 8 of v^2
    / (2 mu g). Without this half, the ball rolls v dt / 2 too far. `state` adds the half back.

    Steps in which nothing touches and no ball can stop are quiet: the stepper reads the motion from
    the engine only when it is needed, so that such a step costs little more than the engine's own.
    """

    def __init__(
        self,
        scene: Scene,
        world: JointWorld,
        dt: float,
        t_end: float,
        *,
        joints: bool = True,
        leapfrog: bool = True,
        rounding: float = 1e-9,
    ) -> None:
        super().__init__(scene)
        self._world = world
        self._positions, _ = world.positions_and_velocities()
        self._along = tangential_restitution(scene.physics)
        self._normals = Normals(scene)
        self._clock = Clock(dt, t_end)
        self._kick = scene.rolling_frictions * scene.physics.gravity * self._clock.dt
        self._half_kick = np.zeros_like(self._kick)
        self._rounding = rounding * self._kick
        self._joints = joints
        if joints and leapfrog:
            self._half_kick = 0.5 * self._kick
        if joints:
            world.add_rolling_joints()
        velocities = scene.velocities[:, :2]
        self._moving = np.any(velocities != 0.0, axis=1)
        self._velocities = _faster(velocities, -self._half_kick)
        world.set_velocities(self._velocities)
        self._rests = not self._moving.any()
        self._may_be_quiet = joints and not self._pocketing
        self._quiet_steps = 0.0
        self._is_stale = False

    @property
    def at_rest(self) -> bool:
        """Whether all balls have stopped."""
        return self._rests

    def state(self) -> Samples:
        """Return the present state, arrays (1, n, 3)."""
        if self._is_stale:
            self._read()
            self._velocities[~self._moving] = 0.0
        velocities = _faster(self._velocities, self._half_kick)
        return rolling_state(self._positions[np.newaxis], velocities[np.newaxis], self._radii)

    def step(self) -> None:
        """Advance the engine by dt."""
        self.before = self.state() if self.recorded and self._world.collides_first else None
        if self._pocketing:
            self._let_fall()
        self._step_world(self._world, self._clock.dt)
        started, self.t = self.t, self._clock.tick()
        self.seen_at = started if self._world.collides_first else self.t
        self.changes.clear()
        if self._quiet_steps > 0.0 and not self._world.touched:
            self._quiet_steps -= 1.0
            self._is_stale = True
            self.collisions = []
            return
        self._read()
        self._take_collisions(self._world.collisions, self._positions)
        if self._along != 1.0 and self.collisions:
            plane.scale_along_cushions(
                self._velocities,
                self._positions,
                self.collisions,
                self._normals,
                self._along,
            )
            self._world.set_velocities(self._velocities)
        if not self._joints:
            self._velocities = _faster(self._velocities, -self._kick)
            self._world.set_velocities(self._velocities)
        moving = np.hypot(self._velocities[:, 0], self._velocities[:, 1]) > self._rounding
        self._velocities[~moving] = 0.0
        stopped = self._moving > moving
        if stopped.any():
            for contact in self.collisions:  # stopped by a ball, not by the joint
                stopped[contact.balls] = False
            self.changes += [(EventKind.ROLL_TO_REST, i) for i in stopped.nonzero()[0].tolist()]
        self._moving, self._rests = moving, not moving.any()
        if self._pocketing:
            self._pocketing.keep(self._positions)
        quiet = self._may_be_quiet and not self._world.touched
        self._quiet_steps = self._steps_to_stop() if quiet else 0.0

    def _read(self) -> None:
        """Read the positions and velocities from the engine."""
        self._positions, self._velocities = self._world.positions_and_velocities()
        self._is_stale = False

    def _steps_to_stop(self) -> float:
        """Return a number of coming steps in which the joints stop no ball, possibly inf."""
        speeds = np.hypot(self._velocities[:, 0], self._velocities[:, 1])
        slowed = self._moving & (self._kick > 0.0)
        with np.errstate(over="ignore"):
            steps = float(np.min(speeds[slowed] / self._kick[slowed], initial=math.inf))
        return steps - 2.0  # one for the last step, and one for rounding

    def _let_fall(self) -> None:
        """Remove the balls that fall in the coming step, before they can collide.

        A ball moves in a straight line by its present velocity.
        """
        after = self._positions + self._velocities * self._clock.dt
        self.falls = self._pocketing.take(self._positions, after)
        if not self.falls:
            self.moving = None
            return
        moving = _faster(self._velocities, self._half_kick)
        state = rolling_state(after[np.newaxis], moving[np.newaxis], self._radii)
        self._note_falls(self._positions, state)
        for fall in self.falls:
            self._world.remove(fall.ball)
            self._velocities[fall.ball] = 0.0
            self._moving[fall.ball] = False
        self._world.set_velocities(self._velocities)


def _faster(velocities: FloatArray, changes: FloatArray) -> FloatArray:
    """Return `velocities` with `changes` of the speeds, (n,) [m/s]; directions stay the same."""
    speeds = np.hypot(velocities[:, 0], velocities[:, 1])
    # Balls that stop aren't divided: for a speed near 0 the quotient would overflow.
    moving = speeds > np.maximum(-changes, 0.0)
    factor = np.where(moving, 1.0 + changes / np.where(moving, speeds, 1.0), 0.0)
    faster: FloatArray = velocities * factor[:, np.newaxis]
    return faster
