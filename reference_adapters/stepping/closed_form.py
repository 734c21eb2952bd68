"""Balls of an external engine in the plane of the table; the cloth acts between the steps.

The engine finds and resolves the contacts and moves the balls; the cloth friction is the closed
form in `stepping.cloth`. Each ball gets its mean velocity over the coming step, so that the engine
moves it as the cloth would. The change of this velocity by the engine is the effect of contacts.
Any engine that accepts velocities can thus simulate rolling and sliding balls. The ends of the
steps are determined in `stepping.step_ends`.

While no bodies touch, the motion doesn't depend on the engine. The stepper therefore plans many
equal steps at once. A plan ends before a phase ends, or at a contact. A planned step takes little
more time than the engine's own step.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ghostball.model import Samples, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.stepping.cloth import ClosedFormCloth, Steps, warm_up
from ghostball.reference_adapters.stepping.laws import tangential_restitution
from ghostball.reference_adapters.stepping.plane import (
    PlaneWorld,
    Planned,
    WorldStepper,
    scale_along_cushions,
)
from ghostball.reference_adapters.stepping.sides import Normals
from ghostball.reference_adapters.stepping.step_ends import BallMotion, Clock, StepEnds

FIRST_PLAN, LONGEST_PLAN = 4, 128
"""Numbers of steps of the first plan after a contact, and of the longest plan; plans double."""


class _Plan:
    """Coming steps in which nothing may touch.

    `clock`: the ends of all steps.
    `taken`: number of steps that have been taken since the plan was last extended.
    """

    def __init__(self, world: PlaneWorld, clock: Clock) -> None:
        self.clock, self.taken = clock, 0
        self._world = world
        self._size = FIRST_PLAN
        self._steps: Steps | None = None
        self._planned: Sequence[Planned] = ()

    def extend(self, cloth: ClosedFormCloth) -> bool:
        """Plan the next steps if none is left, and return whether a planned step exists.

        No step is planned after a step with a contact, or if a phase ends in the next step.
        """
        if self.taken < len(self._planned):
            return True
        self.set_motion(cloth)
        self._clear()
        if self._world.touched:
            self._size = FIRST_PLAN
            return False
        steps = cloth.steps(self.clock.dt, min(self._size, self.clock.left))
        if len(steps.means) == 0:
            return False
        self._size = min(2 * self._size, LONGEST_PLAN)
        self._steps, self._planned = steps, self._world.planned(steps.means)
        return True

    def take(self, most: int) -> Sequence[Planned]:
        """Return the velocities for the next steps, at most `most`."""
        return self._planned[self.taken : self.taken + most]

    def set_motion(self, cloth: ClosedFormCloth) -> None:
        """Set the motion after the steps that have been taken."""
        if self._steps is not None:
            cloth.set_motion(self._steps, self.taken)

    def give_up(self, cloth: ClosedFormCloth) -> None:
        """End the plan, and set the motion at the start of the step that was taken last."""
        self.taken -= 1
        self.set_motion(cloth)
        self._clear()

    def _clear(self) -> None:
        self._steps, self._planned, self.taken = None, (), 0


class ClosedFormStepper(WorldStepper):
    """Steps in which the engine moves the balls by the closed form; see this module.

    `ends` determines the ends of the steps.
    """

    def __init__(self, scene: Scene, world: PlaneWorld, ends: StepEnds) -> None:
        super().__init__(scene)
        warm_up()
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
        self._plan: _Plan | None = None
        if isinstance(ends, Clock) and not world.rubs and not self._pocketing:
            self._plan = _Plan(world, ends)

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
        if self._plan is not None:
            self._plan.set_motion(self._cloth)
        return self._cloth.state(self._positions)

    def step(self) -> None:
        """Advance by one step."""
        self.steps(1)

    def steps(self, most: int) -> int:
        """Advance by a step, or by up to `most` planned steps; return their number."""
        plan = self._plan
        if plan is not None and plan.extend(self._cloth):
            return self._follow(plan, most)
        dt, t, self.keep_frame = self._ends.next(self.t, self._motion)
        self._advance(dt)
        self.seen_at = self.t if self._world.collides_first else t
        self.t = t
        return 1

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

    def _advance(self, dt: float) -> None:
        """Advance by `dt` [s]."""
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
        if world.touched or before is not None:
            if at_start is not None and start is not None and world.collisions:
                self.before = start.state(at_start)
            self._meet(dt, before, given, start)
        else:
            self._known_positions, self.collisions = None, world.collisions
            self._cloth.keep(rubs=world.rubs)
        # The end of a spin at rest is no event.
        if self._cloth.stopped or self.falls:
            self._rests = None

    def _follow(self, plan: _Plan, most: int) -> int:
        """Take up to `most` steps of a plan, which ends if something touches; return how many."""
        world, dt, first = self._world, plan.clock.dt, self._world.collides_first
        records = self.recorded and first
        before = None
        if records or self._needs_positions:
            before, most = self._positions, 1
        start_planned, step_world = world.start_planned, self._step_world
        taken = 0
        for planned in plan.take(most):
            start_planned(planned)
            step_world(world, dt)
            taken += 1
            if world.touched:
                break
        self.seen_at = plan.clock.tick(taken - 1)
        self.t = plan.clock.tick()
        if not first:
            self.seen_at = self.t
        self.changes = []
        plan.taken += taken
        if not world.touched:
            self._known_positions, self.collisions = None, world.collisions
            return taken
        plan.give_up(self._cloth)
        start = self._cloth.copy() if first else None
        self._cloth.advance(dt)  # no phase ends in a planned step
        if records and start is not None and before is not None and world.collisions:
            self.before = start.state(before)
        self._meet(dt, before if self._needs_positions else None, planned[0], start)
        return taken

    def _meet(
        self,
        dt: float,
        before: FloatArray | None,
        given: FloatArray,
        start: ClosedFormCloth | None,
    ) -> None:
        """Add the effect of contacts on the motion after a step of `dt` [s].

        `before`: (n, 2) [m], the centres at the start of the step; None if nothing needs them.
        `given`: (n, 2) [m/s], the velocities in the engine before the step.
        `start`: the motion at the start of the step, in an engine that collides first.
        """
        world = self._world
        self._kicked[:] = False
        self._known_positions, velocities = world.positions_and_velocities()
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
