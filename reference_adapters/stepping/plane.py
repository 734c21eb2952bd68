"""Balls of an external engine in the plane of the table; the cloth acts between the steps.

The engine finds and resolves the contacts and moves the balls; the cloth friction is the closed
form in `stepping.cloth`. Each ball gets its mean velocity over the coming step, so that the engine
moves it as the cloth would. The change of this velocity by the engine is the effect of contacts.
Any engine that accepts velocities can thus simulate rolling and sliding balls. The ends of the
steps are determined in `stepping.step_ends`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from statistics import fmean
from time import perf_counter
from typing import NamedTuple, Protocol

import numpy as np

from ghostball.model import (
    EventKind,
    Samples,
    Scene,
)
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters.stepping import cloth
from ghostball.reference_adapters.stepping.cloth import ClosedFormCloth
from ghostball.reference_adapters.stepping.laws import tangential_restitution
from ghostball.reference_adapters.stepping.pocketing import (
    Fall,
    Pocketing,
    instant_of,
    states_at_falls,
)
from ghostball.reference_adapters.stepping.sides import CornerNames, Normals
from ghostball.reference_adapters.stepping.step_ends import BallMotion, StepEnds

TIMED_STEPS = 16
"""One in this number of steps is timed: to time each step takes 4 % of a run of Pymunk."""


class Collision(NamedTuple):
    """A collision of the last step.

    `a`: a ball.
    `b`: the second ball, or the index of the cushion.
    `cushion`: True if `b` is a cushion.
    """

    a: int
    b: int
    cushion: bool

    @property
    def balls(self) -> list[int]:
        """Indices of the balls in the collision."""
        return [self.a] if self.cushion else [self.a, self.b]


Change = tuple[EventKind, int] | tuple[EventKind, int, int]
"""Kind of event, ball and, if the ball left the table over a cushion, the index of the cushion."""


class PlaneWorld(Protocol):
    """The world of an external engine, as used by a stepper.

    `collisions`: collisions of the last step.
    `contacts_solved`: number of contacts that the solver has processed; a lasting contact counts
        once per step.
    `touched`: whether a contact of the last step may have changed a velocity or a spin. If not, the
        stepper doesn't read the motion.
    """

    collisions: list[Collision]
    contacts_solved: int
    touched: bool

    @property
    def iterations(self) -> int:
        """Number of iterations of the contact solver in each step."""
        ...

    @property
    def rubs(self) -> bool:
        """Whether contacts may change spins; then `start` gets the spins and `turns` is called."""
        ...

    @property
    def collides_first(self) -> bool:
        """Whether a step first finds contacts and then moves the balls, or the reverse.

        The times of events depend on this, because an event has the time of its detection.
        """
        ...

    def start(self, velocities: FloatArray, spins: FloatArray | None) -> FloatArray:
        """Set the velocities, (n, 2) [m/s], and spins, (n, 3) [rad/s], of the balls for a step.

        Returns the velocities in the engine, (n, 2) float64 [m/s], rounded for an engine in single
        precision.
        """
        ...

    def advance(self, dt: float) -> None:
        """Let the engine take its own step of `dt` [s]; only this call counts as `engine_time`."""
        ...

    def read_contacts(self, dt: float) -> None:
        """Store the collisions and contacts of the last step, of `dt` [s]."""
        ...

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        ...

    def turns(self) -> FloatArray:
        """Return the spin changes by contacts of the step, (n, 3) [rad/s]; called if `rubs`."""
        ...

    def remove(self, ball: int) -> None:
        """Remove a ball from the world, so that no other ball can collide with it.

        The stepper still sets the velocity of this ball, to 0, and the world still lists the ball.
        The listed values don't matter.
        """
        ...


class WorldStepper(ABC):
    """Advances the balls of a world, one step at a time.

    `t`: present time [s].
    `seen_at`: time at which the engine detected the collisions of the last step [s].
    `collisions`: collisions of the last step; a corner counts once, as the side that ends there.
    `changes`: all other events of the last step, with ball and, if it left the table, cushion.
    `falls`: balls that fell into pockets in the last step, in order of time.
    `moving`: state at the end of that step without the falls, arrays (1, n, 3), or None.
    `states_at_falls`: states just before and just after each fall.
    `recorded`: whether the motion is recorded.
    `before`: if it is recorded, and the engine collides first: state at the start of the last step
        with collisions, arrays (1, n, 3); without it, a ball would change its direction one step
        late.
    `keep_frame`: whether the present state must be recorded, whatever the interval of frames.
    """

    def __init__(self, scene: Scene) -> None:
        self.t = 0.0
        self.seen_at = 0.0
        self.collisions: list[Collision] = []
        self.changes: list[Change] = []
        self.falls: list[Fall] = []
        self.moving: Samples | None = None
        self.states_at_falls: list[tuple[Fall, Samples]] = []
        self.recorded = self.keep_frame = False
        self.before: Samples | None = None
        self._timed: list[float] = []
        self._until_timed = 1
        self._radii = scene.radii
        self._pocketing = Pocketing(scene)
        self._corners = CornerNames(scene)

    @property
    @abstractmethod
    def at_rest(self) -> bool:
        """Whether all balls are at rest."""

    @abstractmethod
    def state(self) -> Samples:
        """Return the present state, arrays (1, n, 3)."""

    @abstractmethod
    def step(self) -> None:
        """Advance by one step."""

    def _step_world(self, world: PlaneWorld, dt: float) -> None:
        """Advance a world by `dt` [s]; one of `TIMED_STEPS` steps of the engine is timed."""
        self._until_timed -= 1
        if self._until_timed:
            world.advance(dt)
        else:
            self._until_timed = TIMED_STEPS
            started = perf_counter()
            world.advance(dt)
            self._timed.append(perf_counter() - started)
        world.read_contacts(dt)

    def engine_time(self, steps: int) -> float:
        """Return the time in the engine's own steps [s], from the mean of the timed ones."""
        return steps * fmean(self._timed) if self._timed else 0.0

    def tell(self, recorder: Recorder, started: float) -> None:
        """Pass the events of the last step, which started at `started` [s], to a recorder."""
        before = self.before
        if before is not None and self.collisions:
            recorder.frame(self.seen_at, before, force=True)
            # If `keep_frame`, a contact is active in this step, and a frame would have the velocity
            # of the middle of the step.
            if not self.keep_frame:
                after = self._just_after(before)
                recorder.frame(self.seen_at, after._replace(positions=before.positions), force=True)
        for fall, state in self.states_at_falls if self.falls else ():
            recorder.frame(instant_of(fall, started, self.t), state, force=True)
        for fall in self.falls:
            t = instant_of(fall, started, self.t)
            recorder.event(t, EventKind.POCKETED, fall.ball, fall.pocket)
        for a, b, cushion in self.collisions:
            kind = EventKind.BALL_CUSHION if cushion else EventKind.BALL_BALL
            recorder.event(self.seen_at, kind, a, b)
        for change in self.changes:
            recorder.event(self.t, *change)
        self.record(recorder, force=self.keep_frame)

    def _just_after(self, before: Samples) -> Samples:  # noqa: ARG002
        """Return the motion just after the collisions of a step that started in `before`."""
        return self.state() if self.moving is None else self.moving

    def record(self, recorder: Recorder, *, force: bool = False) -> None:
        """Pass the present state to a recorder, if a frame is due or `force` is True."""
        if force or recorder.wants_frame(self.t):
            recorder.frame(self.t, self.state(), force=True)

    def _take_collisions(self, found: list[Collision], positions: FloatArray) -> None:
        """Store the collisions that the world found with the balls at `positions`, (n, 2) [m]."""
        if self._corners:
            named = (
                one._replace(b=self._corners.name(one.b, positions[one.a])) if one.cushion else one
                for one in found
            )
            found = list(dict.fromkeys(named))
        self.collisions = found

    def _note_falls(self, before: FloatArray, moving: Samples | None) -> None:
        """Store the states needed for the falls of a step.

        `before`: (n, 2) float64 [m], the centres at the start of the step.
        """
        self.moving = moving
        if moving is not None:
            self.states_at_falls = list(states_at_falls(before, moving, self.falls))


class ClosedFormStepper(WorldStepper):
    """Steps in which the engine moves the balls by the closed form; see this module.

    `ends` determines the ends of the steps.
    """

    def __init__(self, scene: Scene, world: PlaneWorld, ends: StepEnds) -> None:
        super().__init__(scene)
        cloth.warm_up()
        self._ends = ends
        self._world = world
        self._known_positions: FloatArray | None = world.positions_and_velocities()[0]
        self._rests: bool | None = None
        self._cloth = ClosedFormCloth(scene)
        self._along = tangential_restitution(scene.physics)
        self._normals = Normals(scene)
        # Whether the positions before a step are needed in the step.
        self._needs_positions = bool(self._pocketing or self._corners or self._along != 1.0)
        # The motion just after the last contacts, and the balls whose velocities they changed.
        self._parted, self._kicked = self._cloth, np.zeros(len(scene.balls), dtype=np.bool_)

    @property
    def at_rest(self) -> bool:
        """Whether no ball moves or spins."""
        if self._rests is None:
            self._rests = self._cloth.at_rest
        return self._rests

    @property
    def _positions(self) -> FloatArray:
        """The present centres, (n, 2) float64 [m]."""
        if self._known_positions is None:
            self._known_positions, _ = self._world.positions_and_velocities()
        return self._known_positions

    def state(self) -> Samples:
        """Return the present state, arrays (1, n, 3)."""
        return self._cloth.state(self._positions)

    def step(self) -> None:
        """Advance by one step."""
        dt, t, self.keep_frame = self._ends.next(self.t, self._motion)
        self._advance(dt, t)

    def _motion(self) -> BallMotion:
        """Return the present motion of the balls on the table."""
        cloth, here = self._cloth, self._pocketing.here
        return BallMotion(
            self._positions[here],
            cloth.velocities[here],
            cloth.accelerations()[here],
            self._radii[here],
            cloth.time_to_change(),
        )

    def _advance(self, dt: float, t: float) -> None:
        """Advance by `dt` [s], to the time `t` [s]."""
        world = self._world
        start = self._cloth.copy() if world.collides_first else None
        before = self._positions if self._needs_positions else None
        at_start = self._positions if self.recorded and start is not None else None
        displacements, changes = self._cloth.advance(dt)
        self.changes = list(changes)
        if before is not None and self._pocketing and not world.collides_first:
            # The balls move before they can collide, so a fallen ball has no further collisions.
            self._let_fall(before, before + displacements)
            displacements[self._pocketing.gone] = 0.0
        spins = self._cloth.angular_velocities if world.rubs else None
        given = world.start(displacements / dt, spins)
        self._step_world(world, dt)
        self._kicked[:] = False
        if world.touched or before is not None:
            if at_start is not None and start is not None and world.collisions:
                self.before = start.state(at_start)
            self._known_positions, velocities = world.positions_and_velocities()
            self._meet(dt, before, given, velocities, start)
        else:
            self._known_positions, self.collisions = None, world.collisions
            self._cloth.keep(rubs=world.rubs)
        # The end of a spin at rest is no event.
        if self._cloth.stopped or self.falls:
            self._rests = None
        self.seen_at = self.t if world.collides_first else t
        self.t = t

    def _meet(
        self,
        dt: float,
        before: FloatArray | None,
        given: FloatArray,
        velocities: FloatArray,
        start: ClosedFormCloth | None,
    ) -> None:
        """Add the effect of contacts on the motion after a step of `dt` [s].

        `before`: (n, 2) [m], the centres at the start of the step; None if nothing needs them.
        `given`, `velocities`: (n, 2) [m/s], in the engine, before and after the step.
        `start`: the motion at the start of the step, in an engine that collides first.
        """
        world = self._world
        met_at = self._positions if before is None or start is None else before
        self._take_collisions(world.collisions, met_at)
        if self._along != 1.0:
            scale_along_cushions(velocities, met_at, self.collisions, self._normals, self._along)
        kicks, turns = velocities - given, world.turns() if world.rubs else None
        if turns is not None or kicks.any():
            self._rests = None
        if start is not None and kicks.any():
            # The cloth friction of half a step acts on the motion after the contacts.
            self._cloth = start
            _, first = start.advance(0.5 * dt)
            start.kick(kicks, turns, dt)
            self._parted, self._kicked = start.copy(), np.any(kicks != 0.0, axis=1)
            _, second = start.advance(0.5 * dt)
            self.changes = [*first, *second]
        else:
            self._cloth.kick(kicks, turns, dt)
        if before is not None and self._pocketing:
            if start is not None:
                self._let_fall(before, self._positions)
            self._pocketing.keep(self._positions)

    def _just_after(self, before: Samples) -> Samples:
        if self.moving is not None:
            return self.moving
        parted = self._parted.state(self._positions)
        velocities, spins = before.velocities.copy(), before.angular_velocities.copy()
        velocities[0, self._kicked] = parted.velocities[0, self._kicked]
        spins[0, self._kicked] = parted.angular_velocities[0, self._kicked]
        return Samples(before.positions, velocities, spins)

    def _let_fall(self, before: FloatArray, after: FloatArray) -> None:
        """Remove the balls that fall on their paths in this step, (n, 2) [m] each."""
        self.falls = self._pocketing.take(before, after)
        self._note_falls(before, self._cloth.state(after) if self.falls else None)
        fallen = {fall.ball for fall in self.falls}
        for ball in fallen:
            self._world.remove(ball)
            self._cloth.stop(ball)
        self.changes = [change for change in self.changes if change[1] not in fallen]


def scale_along_cushions(
    velocities: FloatArray,
    positions: FloatArray,
    collisions: list[Collision],
    normals: Normals,
    factor: float,
) -> None:
    """Multiply the velocities along a cushion, (n, 2) [m/s], of balls that met it by a factor.

    `positions`: (n, 2) [m], positions at the contact.
    """
    for contact in collisions:
        if contact.cushion:
            nx, ny = normals.at(contact.b, positions[contact.a])
            if nx == 0.0 or ny == 0.0:
                velocities[contact.a, 0 if nx == 0.0 else 1] *= factor
                continue
            vx, vy = velocities[contact.a]
            loss = (1.0 - factor) * (nx * vy - ny * vx)
            velocities[contact.a] += loss * ny, -loss * nx
