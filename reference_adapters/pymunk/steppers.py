"""How the balls of a Pymunk world are moved on: Pymunk's own steps, or steps that land on contacts.

Each stepper makes one step at a time and says what it was: see `Stepper`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ghostball.engine import EventKind, Samples, Scene
from ghostball.reference_adapters.recording import Recorder, rolling_state
from ghostball.reference_adapters.stepping import cloth as pymunk_cloth, landing
from ghostball.reference_adapters.stepping.clock import Clock
from ghostball.reference_adapters.stepping.cloth import ClosedFormCloth
from ghostball.reference_adapters.stepping.landing import time_to_contact

if TYPE_CHECKING:
    from ghostball.reference_adapters.pymunk.world import World

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


class Stepper(ABC):
    """Moves the balls of a world, a step at a time.

    Attributes
    ----------
    t : float
        Now [s].
    changes : list of (EventKind, int)
        Which balls began to roll or came to rest in the last step.
    keep_frame : bool
        Whether the state now belongs in a recorded trajectory whatever its spacing.
    """

    def __init__(self, scene: Scene, world: World) -> None:
        self.t = 0.0
        self.changes: list[tuple[EventKind, int]] = []
        self.keep_frame = False
        self._world = world
        self._radii = scene.radii
        self._positions, _ = world.positions_and_velocities()

    @property
    @abstractmethod
    def resting(self) -> BoolArray:
        """Which balls are at rest, (n,) bool."""

    @abstractmethod
    def state(self) -> Samples:
        """Return the state now, arrays (1, n, 3)."""

    @abstractmethod
    def record(self, recorder: Recorder, *, force: bool = False) -> None:
        """Hand the state now to a recorder, as `Recorder.frame` takes it."""

    @abstractmethod
    def step(self) -> None:
        """Make one step."""


def make_stepper(
    scene: Scene, world: World, mode: Literal["native", "landed"], dt: float, t_end: float
) -> Stepper:
    """Return the stepper for `mode`, with steps of at most `dt` [s] that end on `t_end` [s]."""
    if mode == "landed":
        return Landed(scene, world, dt, t_end)
    if scene.physics.motion == "sliding":
        return NativeClosedForm(scene, world, dt, t_end)
    return NativeRolling(scene, world, dt, t_end)


class NativeRolling(Stepper):
    """Pymunk's own steps and Pymunk's own way to slow a ball.

    Chipmunk moves a ball before it changes its velocity. With the tuned joint, which takes exactly
    mu g dt in each step, half a kick before the first step makes that a leapfrog: velocities belong
    to the middle of the step to come, and a roll ends within mu g dt^2 / 8 of v^2 / (2 mu g).
    Without it the ball rolls v dt / 2 too far. `state` takes the half kick back.
    """

    def __init__(self, scene: Scene, world: World, dt: float, t_end: float) -> None:
        super().__init__(scene, world)
        self._clock = Clock(dt, t_end)
        self._kick = scene.rolling_frictions * scene.physics.gravity * self._clock.dt
        self._half_kick = np.zeros_like(self._kick)
        # What rounding leaves of a speed that the joint stops, in units of what it takes.
        self._rounding = 1e-9 * self._kick
        if world.tuned:
            self._half_kick = 0.5 * self._kick
            world.add_rolling_joints()
        velocities = scene.velocities[:, :2]
        self._moving = np.any(velocities != 0.0, axis=1)
        self._velocities = _faster(velocities, -self._half_kick)
        world.set_velocities(self._velocities)

    @property
    def resting(self) -> BoolArray:
        """Which balls have stopped, (n,) bool."""
        resting: BoolArray = ~self._moving
        return resting

    def state(self) -> Samples:
        """Return the state now, arrays (1, n, 3)."""
        velocities = _faster(self._velocities, self._half_kick)
        return rolling_state(self._positions[np.newaxis], velocities[np.newaxis], self._radii)

    def record(self, recorder: Recorder, *, force: bool = False) -> None:
        """Hand the state now to a recorder."""
        velocities = _faster(self._velocities, self._half_kick)
        recorder.rolling_frame(self.t, self._positions, velocities, force=force)

    def step(self) -> None:
        """Let Pymunk step by dt."""
        self._world.step(self._clock.dt)
        self.t = self._clock.tick()
        self._positions, self._velocities = self._world.positions_and_velocities()
        if not self._world.tuned:
            self._velocities = _faster(self._velocities, -self._kick)
            self._world.set_velocities(self._velocities)
        moving = np.hypot(self._velocities[:, 0], self._velocities[:, 1]) > self._rounding
        resting = ~moving
        self._velocities[resting] = 0.0
        stopped = self._moving & resting
        for a, b, cushion in self._world.collisions:  # stopped by a ball, not by the cloth
            stopped[[a] if cushion else [a, b]] = False
        self.changes = [(EventKind.ROLL_TO_REST, i) for i in stopped.nonzero()[0].tolist()]
        self._moving = moving


class _ClosedForm(Stepper):
    """Steps in which Pymunk moves the balls as the closed form says, and resolves contacts.

    Each ball is given its mean velocity over the step, so that Pymunk takes it where the cloth
    would; what Pymunk changes of that velocity is what contacts did.
    """

    def __init__(self, scene: Scene, world: World) -> None:
        super().__init__(scene, world)
        pymunk_cloth.warm_up()
        self._cloth = ClosedFormCloth(scene)
        self._solved = 0

    @property
    def resting(self) -> BoolArray:
        """Which balls neither move nor spin, (n,) bool."""
        return self._cloth.resting

    def state(self) -> Samples:
        """Return the state now, arrays (1, n, 3)."""
        return self._cloth.state(self._positions)

    def record(self, recorder: Recorder, *, force: bool = False) -> None:
        """Hand the state now to a recorder."""
        recorder.frame(self.t, self.state(), force=force)

    def _advance(self, dt: float) -> None:
        displacements, self.changes = self._cloth.advance(dt)
        if self._world.contacts_solved > self._solved:
            self._solved = self._world.contacts_solved
            self._world.forget_contacts()
        means = displacements / dt
        friction = self._world.friction
        self._world.set_velocities(means)
        if friction is not None:
            friction.set_spins(self._cloth.angular_velocities)
        self._world.step(dt)
        self._positions, velocities = self._world.positions_and_velocities()
        turns = None if friction is None else friction.turns()
        self._cloth.kick(velocities - means, turns, dt)


class NativeClosedForm(_ClosedForm):
    """Fixed steps that know nothing of contacts: Pymunk sees them where it does."""

    def __init__(self, scene: Scene, world: World, dt: float, t_end: float) -> None:
        super().__init__(scene, world)
        self._clock = Clock(dt, t_end)

    def step(self) -> None:
        """Step by dt."""
        self._advance(self._clock.dt)
        self.t = self._clock.tick()


class Landed(_ClosedForm):
    """Steps that end where something touches, or a ball stops sliding, rolling or spinning.

    A contact takes two: to a gap of 1e-10 m, and to as much overlap, which Pymunk resolves.
    """

    def __init__(self, scene: Scene, world: World, dt: float, t_end: float) -> None:
        super().__init__(scene, world)
        landing.warm_up()
        self._longest = dt
        self._t_end = t_end
        self._table = scene.table

    def step(self) -> None:
        """Step to the next contact, the next change of motion, `dt` or the end."""
        left = self._t_end - self.t
        horizon = min(self._longest, left, self._cloth.time_to_change())
        to_contact = time_to_contact(
            self._positions,
            self._cloth.velocities,
            self._cloth.accelerations(),
            self._radii,
            self._table,
            horizon=horizon,
        )
        dt = min(horizon, to_contact)
        self._advance(dt)
        self.t = self._t_end if dt == left else self.t + dt
        self.keep_frame = to_contact <= horizon


def _faster(velocities: FloatArray, changes: FloatArray) -> FloatArray:
    """Return `velocities` with `changes`, (n,) [m/s], added to the speeds; none turns or starts."""
    speeds = np.hypot(velocities[:, 0], velocities[:, 1])
    # What loses all that it has isn't divided: of a speed near 0 the quotient would overflow.
    moving = speeds > np.maximum(-changes, 0.0)
    factor = np.where(moving, 1.0 + changes / np.where(moving, speeds, 1.0), 0.0)
    faster: FloatArray = velocities * factor[:, np.newaxis]
    return faster
