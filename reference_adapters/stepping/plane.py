"""Balls of a foreign engine in the plane of the table, with the cloth applied between its steps.

The engine finds and resolves the contacts and moves the balls; what the cloth does to them is the
closed form of `stepping.cloth`. Each ball is given its mean velocity over the coming step, so that
the engine takes it where the cloth would; what the engine changes of that velocity is what contacts
did. So any engine that can be given velocities plays rolling and sliding balls, in steps that know
nothing of contacts (`FixedSteps`) or that end where something touches (`StepsToContacts`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Set
from typing import Any, NamedTuple, Protocol

import numpy as np

from ghostball.model import (
    EventKind,
    Record,
    Result,
    Samples,
    Scene,
)
from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters.stepping import cloth, contact_time
from ghostball.reference_adapters.stepping.clock import Clock
from ghostball.reference_adapters.stepping.cloth import ClosedFormCloth
from ghostball.reference_adapters.stepping.contact_time import time_to_contact
from ghostball.reference_adapters.stepping.ending import end_of, ending_of
from ghostball.reference_adapters.stepping.laws import tangential_restitution
from ghostball.reference_adapters.stepping.pocketing import (
    Fall,
    Pocketing,
    instant_of,
    states_at_falls,
)
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.sides import CornerNames, Normals


class Collision(NamedTuple):
    """A collision of the last step.

    `a`: a ball.
    `b`: the other ball, or the index of the cushion.
    `cushion`: which of the two `b` is.
    """

    a: int
    b: int
    cushion: bool


class ExactSteps(NamedTuple):
    """How near to contacts an engine's steps can end.

    `gap` [m]: gap at which a step ends; larger than what rounding leaves of the engine's
        coordinates.
    `shortest` [s]: shortest step: an engine may work with accelerations, and bound them.
    """

    gap: float = contact_time.CONTACT_GAP
    shortest: float = 0.0


IN_SINGLE_PRECISION = ExactSteps(gap=1e-6)
"""Of an engine in single precision, which has 2e-7 m on a table."""


class PlaneWorld(Protocol):
    """A foreign engine's world, as far as a stepper needs it.

    `collisions`: of the last step.
    `contacts_solved`: how many contacts the solver has worked on, one for each step that a contact
        lasts.
    """

    collisions: list[Collision]
    contacts_solved: int

    @property
    def iterations(self) -> int:
        """Iterations of the contact solver in each step."""
        ...

    @property
    def rubs(self) -> bool:
        """Whether contacts may turn balls: then it is given the spins and asked for `turns`."""
        ...

    @property
    def collides_first(self) -> bool:
        """Whether a step finds contacts at its start and then moves the balls, or the reverse.

        So events get the instant at which the engine saw them.
        """
        ...

    def start(self, velocities: FloatArray, spins: FloatArray | None) -> FloatArray:
        """Give the balls velocities, (n, 2) [m/s], and spins, (n, 3) [rad/s], for a step.

        Returns (n, 2) float64 [m/s]: the velocities as the engine has them, rounded where it works
        in single precision.
        """
        ...

    def step(self, dt: float) -> None:
        """Let the engine step by `dt` [s]."""
        ...

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        ...

    def turns(self) -> FloatArray:
        """Return what the step's contacts added to the spins, (n, 3) [rad/s]; asked if `rubs`."""
        ...

    def remove(self, ball: int) -> None:
        """Take a ball out, whatever it does: nothing can meet it any more.

        It is still given velocities, of 0, and listed; what is said of it then doesn't matter.
        """
        ...


def untouched(n: int, pushing: Set[Collision]) -> BoolArray:
    """Return which of n balls none of the contacts that pushed is of, (n,) bool.

    What an engine's own frames of reference leave of their velocities is rounding, and no
    collision.
    """
    free = np.ones(n, dtype=bool)
    for a, b, cushion in pushing:
        free[[a] if cushion else [a, b]] = False
    return free


class Stepper(ABC):
    """Moves the balls of a world, a step at a time.

    `t`: now [s].
    `seen_at`: when the engine saw the collisions of the last step [s].
    `collisions`: of the last step, a corner once, by the name of the side that ends there.
    `changes`: which balls began to roll or came to rest in the last step.
    `falls`: which balls fell into pockets in the last step, in order of time.
    `moving`: the state as that step would have ended without these, arrays (1, n, 3); else None.
    `states_at_falls`: the states just before and just after each of these.
    `keep_frame`: whether the state now belongs in a recorded trajectory whatever its spacing.
    """

    def __init__(self, scene: Scene, world: PlaneWorld) -> None:
        self.t = 0.0
        self.seen_at = 0.0
        self.collisions: list[Collision] = []
        self.changes: list[tuple[EventKind, int]] = []
        self.falls: list[Fall] = []
        self.moving: Samples | None = None
        self.states_at_falls: list[tuple[Fall, Samples]] = []
        self.keep_frame = False
        self._radii = scene.radii
        self._pocketing = Pocketing(scene)
        self._corners = CornerNames(scene)
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

    def _take_collisions(self, found: list[Collision], positions: FloatArray) -> None:
        """Take over the collisions that the world found with the balls there, (n, 2) [m]."""
        if self._corners:
            named = (
                one._replace(b=self._corners.name(one.b, positions[one.a])) if one.cushion else one
                for one in found
            )
            found = list(dict.fromkeys(named))
        self.collisions = found

    def _note_falls(self, before: FloatArray, moving: Samples | None) -> None:
        """Keep what is asked of the falls of a step.

        `before` (n, 2) float64 [m]: the centres as it begins.
        """
        self.moving = moving
        if moving is not None:
            self.states_at_falls = list(states_at_falls(before, moving, self.falls))

    def keep(self, recorder: Recorder, t: float, state: Samples) -> None:
        """Hand a state at the instant t [s] within the last step to a recorder."""
        recorder.frame(t, state, force=True)


class _ClosedForm(Stepper):
    """Steps in which the engine moves the balls as the closed form says; see the module."""

    def __init__(self, scene: Scene, world: PlaneWorld) -> None:
        super().__init__(scene, world)
        cloth.warm_up()
        self._world = world
        self._cloth = ClosedFormCloth(scene)
        self._along = tangential_restitution(scene.physics)
        self._normals = Normals(scene)

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

    def _advance(self, dt: float, t: float) -> None:
        world, before = self._world, self._positions
        displacements, self.changes = self._cloth.advance(dt)
        if self._pocketing and not world.collides_first:
            # It goes that way before it can collide: so what has fallen collides no more.
            self._let_fall(before, before + displacements)
            displacements[self._pocketing.gone] = 0.0
        spins = self._cloth.angular_velocities if world.rubs else None
        given = world.start(displacements / dt, spins)
        world.step(dt)
        self._positions, velocities = world.positions_and_velocities()
        met_at = before if world.collides_first else self._positions
        self._take_collisions(world.collisions, met_at)
        if self._along != 1.0:
            scale_along_cushions(velocities, met_at, self.collisions, self._normals, self._along)
        self._cloth.kick(velocities - given, world.turns() if world.rubs else None, dt)
        if self._pocketing:
            if world.collides_first:
                self._let_fall(before, self._positions)
            self._pocketing.keep(self._positions)
        self.seen_at = self.t if world.collides_first else t
        self.t = t

    def _let_fall(self, before: FloatArray, after: FloatArray) -> None:
        """Take out the balls that fall on their way in this step, (n, 2) [m] each."""
        self.falls = self._pocketing.take(before, after)
        self._note_falls(before, self._cloth.state(after) if self.falls else None)
        fallen = {fall.ball for fall in self.falls}
        for ball in fallen:
            self._world.remove(ball)
            self._cloth.stop(ball)
        self.changes = [(kind, ball) for kind, ball in self.changes if ball not in fallen]


class FixedSteps(_ClosedForm):
    """Fixed steps that know nothing of contacts: the engine sees them where it does."""

    def __init__(self, scene: Scene, world: PlaneWorld, dt: float, t_end: float) -> None:
        super().__init__(scene, world)
        self._clock = Clock(dt, t_end)

    def step(self) -> None:
        """Step by dt."""
        self._advance(self._clock.dt, self._clock.tick())


class StepsToContacts(_ClosedForm):
    """Steps that end where something touches, or a ball stops sliding, rolling or spinning.

    A contact takes two: to a gap of 1e-10 m, and to as much overlap, which the engine resolves; or
    one more, where it sees in a step only what overlaps as that begins.
    """

    def __init__(
        self, scene: Scene, world: PlaneWorld, ends: ExactSteps, dt: float, t_end: float
    ) -> None:
        super().__init__(scene, world)
        contact_time.warm_up()
        self._longest = dt
        self._t_end = t_end
        self._table = scene.table
        self._gap, self._shortest = ends

    def step(self) -> None:
        """Step to the next contact, the next change of motion, `dt` or the end."""
        left = self._t_end - self.t
        horizon = min(self._longest, left, self._cloth.time_to_change())
        here = self._pocketing.here
        to_contact = time_to_contact(
            self._positions[here],
            self._cloth.velocities[here],
            self._cloth.accelerations()[here],
            self._radii[here],
            self._table,
            gap=self._gap,
            horizon=horizon,
        )
        dt = max(min(horizon, to_contact), self._shortest)
        if left - dt < self._shortest:
            dt = left
        self._advance(dt, self._t_end if dt == left else self.t + dt)
        self.keep_frame = to_contact <= horizon


def run(
    scene: Scene,
    record: Record,
    engine: str,
    settings: SteppingSettings,
    world: PlaneWorld,
    stepper: Stepper,
) -> Result:
    """Step until every ball rests, to `t_max`, or to a limit of the settings; return the result.

    `engine`: the name that the result gets.
    """
    t_end = end_of(scene, settings)
    recorder = Recorder(scene, record)
    steps = 0
    # Else a recorded motion would turn a ball within the step after the one in which it turned.
    jumps = record == "trajectory" and world.collides_first

    recorder.start()
    stepper.record(recorder)
    while not stepper.resting.all() and stepper.t < t_end and steps < settings.max_steps:
        before = stepper.state() if jumps else None
        started = stepper.t
        stepper.step()
        steps += 1
        if before is not None and stepper.collisions:
            after = stepper.state() if stepper.moving is None else stepper.moving
            recorder.frame(stepper.seen_at, before, force=True)
            jumped = after._replace(positions=before.positions)
            recorder.frame(stepper.seen_at, jumped, force=True)
        for fall, state in stepper.states_at_falls if stepper.falls else ():
            stepper.keep(recorder, instant_of(fall, started, stepper.t), state)
        for fall in stepper.falls:
            t = instant_of(fall, started, stepper.t)
            recorder.event(t, EventKind.POCKETED, fall.ball, fall.pocket)
        for contact in stepper.collisions:
            kind = EventKind.BALL_CUSHION if contact.cushion else EventKind.BALL_BALL
            recorder.event(stepper.seen_at, kind, contact.a, contact.b)
        for changed, ball in stepper.changes:
            recorder.event(stepper.t, changed, ball)
        if stepper.keep_frame or recorder.wants_frame(stepper.t):
            stepper.record(recorder, force=stepper.keep_frame)
    state = stepper.state()
    at_rest = bool(stepper.resting.all())
    status, reason = ending_of(scene, settings, stepper.t, state, at_rest=at_rest)
    return recorder.result(
        engine=engine,
        settings=settings_as_used(settings, world),
        status=status,
        final_state=state,
        rest_time=stepper.t,
        work={"steps": steps, "contacts_solved": world.contacts_solved},
        reason=reason,
    )


def settings_as_used(settings: SteppingSettings, world: PlaneWorld) -> dict[str, Any]:
    """Return the settings with what None stood for."""
    return settings.model_dump() | {"dt": settings.step, "iterations": world.iterations}


def scale_along_cushions(
    velocities: FloatArray,
    positions: FloatArray,
    collisions: list[Collision],
    normals: Normals,
    factor: float,
) -> None:
    """Multiply the velocities, (n, 2) [m/s], of balls that met a cushion along it by a factor.

    `positions` (n, 2) [m]: where they met it.
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
