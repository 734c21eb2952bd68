"""Base class of the steppers, and the interface of an engine's world."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from statistics import fmean
from time import perf_counter
from typing import Any, NamedTuple, Protocol

from ghostball.model import (
    EventKind,
    Samples,
    Scene,
)
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.recording import Recorder
from ghostball.reference_adapters.stepping.pocketing import (
    Fall,
    Pocketing,
    instant_of,
    states_at_falls,
)
from ghostball.reference_adapters.stepping.sides import CornerNames, Normals

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


Planned = tuple[FloatArray, Any]
"""The velocities of the balls in a step: rounded as `start` returns them, (n, 2) [m/s], and in the
form that the engine takes.
"""


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

    def planned(self, velocities: FloatArray) -> Sequence[Planned]:
        """Return the velocities of coming steps, (k, n, 2) [m/s], in the form of `start_planned`.

        Only called if contacts don't change spins.
        """
        ...

    def start_planned(self, planned: Planned) -> None:
        """Set the velocities for a step as `start` does, in less time; `planned` is one step."""
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
        self._until_timed = 2  # an engine may prepare in its first step
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

    def steps(self, most: int) -> int:  # noqa: ARG002
        """Advance by a step, or by up to `most` steps; return their number.

        Only the last of these steps has events.
        """
        self.step()
        return 1

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
        if not (self.collisions or self.changes or self.falls):  # most steps
            self.record(recorder, force=self.keep_frame)
            return
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
