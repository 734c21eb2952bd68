"""Balls of a 3D engine on its own cloth: a plane under gravity, with the engine's friction.

The engine has Coulomb friction, which turns sliding into rolling, but no rolling friction and no
friction of vertical spin. The adapter applies both in closed form around each step, rolling
friction to the balls that roll.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator
from typing import ClassVar, Protocol

import numpy as np

from ghostball.model import EventKind, Samples, Scene
from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.reference_adapters.stepping.laws import slips_of, tangential_restitution
from ghostball.reference_adapters.stepping.plane import (
    Change,
    PlaneWorld,
    WorldStepper,
    scale_along_cushions,
)
from ghostball.reference_adapters.stepping.plane_engine import PlaneEngine
from ghostball.reference_adapters.stepping.run_end import end_of
from ghostball.reference_adapters.stepping.sides import Normals, sides_of
from ghostball.reference_adapters.stepping.step_ends import Clock

REST_SPEED = 1e-5
"""Speed of centre and surface below which a ball is at rest [m/s]."""


class SpaceWorld(PlaneWorld, Protocol):
    """A world that can also have a plane under gravity.

    `on_cloth`: balls that the plane pushed in the last step.
    """

    on_cloth: set[int]

    def motion(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return centres [m], velocities [m/s] and spins [rad/s], three arrays (n, 3)."""
        ...

    def set_motion(self, velocities: FloatArray, spins: FloatArray) -> None:
        """Set the velocities [m/s] and spins [rad/s], two arrays (n, 3)."""
        ...


class OwnClothStepper(WorldStepper):
    """Fixed steps of an engine whose balls lie on a plane under gravity, or fly above it.

    `slows`: whether the adapter applies rolling friction and slows spins, or the engine does.

    Landings below `slowest_bounce` don't bounce. A ball therefore counts as flying if it is higher
    than a bounce of this speed, or if its vertical speed is larger.
    """

    def __init__(
        self, scene: Scene, world: SpaceWorld, dt: float, t_end: float, *, slows: bool = True
    ) -> None:
        super().__init__(scene)
        self._world = world
        self._slows = slows and bool(
            np.any(scene.rolling_frictions) or np.any(scene.spinning_friction_rates)
        )
        self._clock = Clock(dt, t_end)
        # One half before and one half after the engine's step, so that rolling is exact.
        half = 0.5 * self._clock.dt
        self._slows_by = scene.rolling_frictions * scene.physics.gravity * half
        # The friction of a step ends any smaller slip; a remaining slip comes from the solver.
        self._no_slip = scene.sliding_frictions * scene.physics.gravity * self._clock.dt
        self._slip_per_step = 3.5 * self._no_slip  # friction also turns a ball
        self._spins_by = scene.spinning_friction_rates * half
        # The step of the settings, as in the world, not the step shortened to end at `t_end`.
        self._slowest_fall = slowest_bounce(scene, dt)
        self._lowest_bounce = self._slowest_fall * dt
        self._noses = sides_of(scene) if scene.physics.airborne else ()
        self._nose_height = scene.physics.cushion_height
        self._left = np.zeros(len(scene.balls), dtype=np.bool_)
        self._along, self._normals = tangential_restitution(scene.physics), Normals(scene)
        self._touching: set[int] = set()
        world.set_motion(scene.velocities, scene.angular_velocities)
        self._centres, self._velocities, self._spins = world.motion()
        self._rolling = self._rolls()

    @property
    def at_rest(self) -> bool:
        """Whether all balls are at rest."""
        return bool(self.resting.all())

    @property
    def resting(self) -> BoolArray:
        """Whether each ball is at rest, (n,) bool; a spin that never decays is ignored."""
        turns = np.abs(self._radii * self._spins[:, 2]) >= REST_SPEED
        resting: BoolArray = self._stopped & ~(turns & (self._spins_by > 0.0))
        return resting

    @property
    def _stopped(self) -> BoolArray:
        """Which balls neither slide nor roll, (n,) bool; they may spin about the vertical."""
        # Balls on the cloth may jitter vertically.
        fastest = np.maximum(
            np.linalg.norm(self._velocities[:, :2], axis=1),
            self._radii * np.linalg.norm(self._spins[:, :2], axis=1),
        )
        stopped: BoolArray = (fastest < REST_SPEED) & self._lies()
        return stopped

    def state(self) -> Samples:
        """Return the present state, arrays (1, n, 3)."""
        return Samples(
            self._centres[np.newaxis], self._velocities[np.newaxis], self._spins[np.newaxis]
        )

    def step(self) -> None:
        """Advance the engine by dt; slow rolling balls, one half before and one half after."""
        self.before = self.state() if self.recorded and self._world.collides_first else None
        had_stopped, before = self._stopped, self._centres[:, :2]
        rolled, slips = self._rolling, None if self._rolling.all() else self._slips()
        if self._slows:
            self._slow(rolled)
        lands = self._step_and_land()
        left = self._remove_balls_that_left()
        rolling, halves = self._rolls(), None
        if slips is not None:
            # A ball whose slide ended inside this step has rolled only since then.
            slid = slips / np.maximum(self._slip_per_step, 1e-300)
            rolling &= rolled | (slid <= 1.0)
            halves = np.where(rolling & ~rolled, 2.0 * (1.0 - slid), 1.0)
        if self._slows:
            self._slow(rolling, halves)
        stopped = self._stopped
        starts_rolling = rolling & ~rolled & ~stopped
        self.changes = [(EventKind.BALL_CLOTH, i) for i in lands]
        self.changes += [
            (EventKind.SLIDE_TO_ROLL, i) for i in np.flatnonzero(starts_rolling).tolist()
        ]
        stops = np.flatnonzero(stopped & ~had_stopped & ~self._left).tolist()
        self.changes += [(EventKind.ROLL_TO_REST, i) for i in stops]
        self.changes += left
        self._rolling = rolling
        if self._pocketing:
            self._let_fall(before)

    def _step_and_land(self) -> list[int]:
        """Advance the engine by dt; return the balls that landed."""
        falls, before = -self._velocities[:, 2], self._centres[:, :2]
        self.seen_at = self.t
        self._step_world(self._world, self._clock.dt)
        self.t = self._clock.tick()
        self._centres, self._velocities, self._spins = self._world.motion()
        self._take_collisions(self._world.collisions, before)
        if self._along != 1.0 and self.collisions:
            along = self._velocities[:, :2]
            scale_along_cushions(along, before, self.collisions, self._normals, self._along)
            self._world.set_motion(self._velocities, self._spins)
        on_cloth, touched = self._world.on_cloth, self._touching
        self._touching = on_cloth
        return sorted(i for i in on_cloth - touched if falls[i] > self._slowest_fall)

    def _let_fall(self, before: FloatArray) -> None:
        """Remove the balls that fell on their paths from `before`, (n, 2) [m], in this step."""
        self.falls = self._pocketing.take(before, self._centres[:, :2])
        self._note_falls(before, self.state() if self.falls else None)
        fallen = {fall.ball for fall in self.falls}
        for ball in fallen:
            self._world.remove(ball)
            self._velocities[ball] = self._spins[ball] = 0.0
            self._rolling[ball] = True
        if fallen:
            self._world.set_motion(self._velocities, self._spins)
            self.changes = [change for change in self.changes if change[1] not in fallen]
        self._pocketing.keep(self._centres)

    def _remove_balls_that_left(self) -> list[Change]:
        """Remove the balls whose centres passed over a lower cushion nose."""
        changes: list[Change] = []
        for side in self._noses:
            away = (self._centres[:, :2] - side.point) @ side.normal
            out = (away < 0.0) & (self._centres[:, 2] > self._nose_height) & ~self._left
            for i in np.flatnonzero(out).tolist():
                changes.append((EventKind.LEAVES_TABLE, i, side.cushion))
                self._world.remove(i)
                self._left[i] = True
                self._velocities[i] = self._spins[i] = 0.0
        return changes

    def _slow(self, rolling: BoolArray, halves: FloatArray | None = None) -> None:
        """Apply rolling friction and the friction of spins for a half step.

        `halves`: duration of the rolling friction of each ball, (n,) [half steps]; None means one
            half step.
        """
        speeds = np.linalg.norm(self._velocities[:, :2], axis=1)
        slows_by = self._slows_by if halves is None else halves * self._slows_by
        factors = np.where(speeds > slows_by, 1.0 - slows_by / np.maximum(speeds, 1e-300), 0.0)
        vertical = self._spins[:, 2]
        slower = np.sign(vertical) * np.maximum(np.abs(vertical) - self._spins_by, 0.0)
        lies = self._lies()
        # Copies, because callers may have stored the states. Velocity and spin are both scaled, so
        # that a rolling ball keeps rolling.
        self._velocities, self._spins = self._velocities.copy(), self._spins.copy()
        self._velocities[rolling, :2] *= factors[rolling, np.newaxis]
        self._spins[rolling, :2] *= factors[rolling, np.newaxis]
        self._spins[lies, 2] = slower[lies]
        self._world.set_motion(self._velocities, self._spins)

    def _rolls(self) -> BoolArray:
        """Return which balls may roll: their slip is negligible and they are on the cloth."""
        rolls: BoolArray = (self._slips() < self._no_slip) & self._lies()
        return rolls

    def _slips(self) -> FloatArray:
        """Return the slips of the balls on the cloth, (n,) [m/s]."""
        slips: FloatArray = np.hypot(*slips_of(self._velocities, self._spins, self._radii).T)
        return slips

    def _lies(self) -> BoolArray:
        """Return which balls are on the cloth, or have left the table; all if none may fly."""
        if self._slowest_fall == math.inf:
            return np.ones(len(self._radii), dtype=np.bool_)
        heights = self._centres[:, 2] - self._radii
        lies: BoolArray = (heights <= self._lowest_bounce) & (
            np.abs(self._velocities[:, 2]) <= self._slowest_fall
        )
        return lies | self._left


def slowest_bounce(scene: Scene, dt: float) -> float:
    """Return the speed below which no ball bounces off the cloth [m/s]; inf if none may fly.

    A landing detected a step late gains g dt, so a landing at g dt / (1 - e) would bounce at the
    same height forever. The returned speed is larger by g dt. For an elastic table, whose bounces
    never end, it is 2 g dt.
    """
    physics = scene.physics
    if not physics.airborne:
        return math.inf
    loss = 1.0 - physics.table_restitution
    return physics.gravity * dt * (1.0 + (1.0 / loss if loss > 0.0 else 1.0))


class SpaceEngine(PlaneEngine):
    """An engine with a `SpaceWorld`."""

    @abstractmethod
    def own_cloth(self, scene: Scene) -> bool:
        """Return whether balls lie on a plane of the engine."""

    def world(self, scene: Scene) -> SpaceWorld:
        """Load the engine, and build the scene in it."""
        own_cloth = self.own_cloth(scene)
        world: SpaceWorld = self.world_class()(scene, self.settings, own_cloth=own_cloth)
        return world

    def stepper(self, scene: Scene, world: SpaceWorld) -> WorldStepper:
        """Return the stepper of a world; its steps end at the end of the run."""
        own_cloth = self.own_cloth(scene)
        return self.on_cloth(scene, world) if own_cloth else super().stepper(scene, world)

    def on_cloth(self, scene: Scene, world: SpaceWorld) -> WorldStepper:
        """Return the stepper for balls on a plane of the engine."""
        return OwnClothStepper(scene, world, self.step(scene), end_of(scene, self.settings))


class OwnClothEngine(SpaceEngine):
    """A 3D engine with `OwnClothSettings`."""

    TITLE: ClassVar[str]
    """Name of the engine for display."""

    def _lacking(self, scene: Scene) -> Iterator[str]:
        yield from super()._lacking(scene)
        if not self.own_cloth(scene):
            return
        if len({ball.radius for ball in scene.balls}) > 1:
            yield (
                "no balls of different radii with `cloth` = own (in 3D their contact normal isn't "
                "horizontal)"
            )
        if scene.physics.airborne and scene.table is not None and scene.table.cushions:
            yield (
                f"no cushions in scenes with airborne balls (in {self.TITLE} they are planes of "
                "infinite height: no ball could hit a nose or leave the table)"
            )
        if len(set(scene.sliding_frictions.tolist())) > 1:
            yield (
                "no different sliding friction per ball with `cloth` = own (all balls lie on one "
                "plane)"
            )

    def own_cloth(self, scene: Scene) -> bool:
        """Return whether balls lie on a plane of the engine."""
        own: bool = self.settings.cloth == "own" and scene.physics.motion == "sliding"
        return own
