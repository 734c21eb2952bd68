"""Bullet in the plane: balls that roll, without gravity or a table, as in the paper's model.

Bullet finds and resolves the collisions and moves the balls. Rolling resistance isn't a law of its
planar bodies, so it is applied here, as two half kicks around each step of Bullet:

    v_mean = v - mu g dt/2;   Bullet: collide, then x += v_mean dt;   v = v_mean - mu g dt/2

which between collisions is the closed form v t - mu g t^2/2 at any `dt`; a single kick a step
leaves a bias of v dt/2 in the distance. A ball that stops within the step gets the mean velocity
that takes it to where it stops.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from ghostball.model import EventKind, Samples, Scene
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.pybullet.world import SHORTEST_STEP, Contact, World
from ghostball.reference_adapters.recording import Recorder, rolling_state
from ghostball.reference_adapters.stepping.clock import Clock
from ghostball.reference_adapters.stepping.contact_time import (
    rolling_accelerations,
    time_to_contact,
    time_to_rest,
)
from ghostball.reference_adapters.stepping.pocketing import (
    Pocketing,
    instant_of,
    states_at_falls,
)

EPS = float(np.finfo(np.float64).eps)


Vectors = list[list[float]]
"""One of two components for each ball: with so few, numpy would cost its calls at every step."""


class PlanarRun:
    """The run of one scene whose balls roll.

    `t`: time reached [s].
    `rest_time`: when the last ball stopped so far [s].
    `work`: "steps" of Bullet, "contacts" that pushed in a step, summed over the steps.
    """

    def __init__(self, world: World, scene: Scene, recorder: Recorder) -> None:
        self._world = world
        self._scene = scene
        self._recorder = recorder
        self._radii = scene.radii
        self._decelerations = scene.rolling_frictions * scene.physics.gravity
        self._slowed_by: list[float] = self._decelerations.tolist()
        self._velocities: Vectors = scene.velocities[:, :2].tolist()
        self._in_bullet: Vectors = [[0.0, 0.0] for _ in self._velocities]  # what each body has now
        self._pocketing = Pocketing(scene)
        self.t = 0.0
        self.rest_time = 0.0
        self.work = {"steps": 0, "contacts": 0}
        recorder.rolling_frame(0.0, self._positions(), np.array(self._velocities))

    @property
    def at_rest(self) -> bool:
        """Whether every ball's velocity is exactly 0."""
        return not any(x or y for x, y in self._velocities)

    def state(self) -> Samples:
        """Return the state now, arrays (1, n, 3); z is the radius, spin that of rolling."""
        velocities = np.array(self._velocities)
        return rolling_state(self._positions()[np.newaxis], velocities[np.newaxis], self._radii)

    def run(
        self, contact_steps: Literal["fixed", "exact"], dt: float, t_end: float, max_steps: int
    ) -> None:
        """Run until every ball rests, or to `t_end` exactly, in steps of at most `dt` [s]."""
        if contact_steps == "exact":
            self._run_to_contacts(dt, t_end, max_steps)
        else:
            self._run_in_fixed_steps(dt, t_end, max_steps)

    def _run_in_fixed_steps(self, dt: float, t_end: float, max_steps: int) -> None:
        clock = Clock(dt, t_end)
        while not self.at_rest and clock.t < t_end and self.work["steps"] < max_steps:
            self._advance(clock.dt, clock.tick())

    def _run_to_contacts(self, dt: float, t_end: float, max_steps: int) -> None:
        """Step to each contact: one step gets there, one overlaps, one lets Bullet resolve.

        Bullet sees spheres from the first step that starts with an overlap; `time_to_contact` asks
        for one as large as its gap.
        """
        while not self.at_rest and self.t < t_end and self.work["steps"] < max_steps:
            velocities = np.array(self._velocities)
            stops = time_to_rest(velocities, self._decelerations)
            # Up to the next stop, and by a few roundings past it, so that the ball does stop.
            horizon = min(dt, float(np.min(stops[stops > 0.0])) * (1.0 + 4.0 * EPS))
            here = self._pocketing.here
            to_contact = time_to_contact(
                self._positions()[here],
                velocities[here],
                rolling_accelerations(velocities, self._decelerations)[here],
                self._radii[here],
                self._scene.table,
                horizon=horizon,
            )
            step = max(min(horizon, to_contact), SHORTEST_STEP)
            if step < t_end - self.t:
                self._advance(step, self.t + step)
            else:
                self._advance(t_end - self.t, t_end)

    def _advance(self, dt: float, t: float) -> None:
        """Let Bullet make one step of `dt`, to time `t` [s]; note what happened.

        `dt` is given too because a short one would lose its digits in the difference of two times.
        """
        before = self._velocities
        started_at = self._positions() if self._pocketing else None
        speeds = _speeds(before)
        self._send(before, speeds, dt)
        self._world.step(dt)
        self.work["steps"] += 1
        contacts, new = self._world.contacts()
        self.work["contacts"] += len(contacts)
        touched = {ball for contact in contacts for ball in contact.balls}
        # Of the other balls nothing but `_send` can have changed the velocities.
        for i, speed in enumerate(speeds):
            if speed or i in touched:
                x, y, _ = self._world.velocity(i)[0]
                self._in_bullet[i] = [x, y]
        if new:
            self._note_collisions(new, touched, before, dt)
        self._velocities = self._second_half_kick(dt)
        if started_at is not None:
            self._let_fall(started_at, t)
        for i, (speed, (x, y)) in enumerate(zip(speeds, self._velocities, strict=True)):
            if speed > 0.0 and not (x or y) and not self._pocketing.gone[i]:
                # One that Bullet left alone stops where the closed form says, within the step.
                slowed_by = 0.0 if i in touched else self._slowed_by[i]
                rolled = min(dt, speed / slowed_by) if slowed_by else dt
                self._recorder.event(self.t + rolled, EventKind.ROLL_TO_REST, i)
                self.rest_time = max(self.rest_time, self.t + rolled)
        self.t = t
        # The last ball may have come to rest within the step: then the end is before `t`, and the
        # recorder's last frame is of there.
        if not self.at_rest and self._recorder.wants_frame(t):
            self._recorder.rolling_frame(t, self._positions(), np.array(self._velocities))

    def _let_fall(self, before: FloatArray, t: float) -> None:
        """Take out the balls that fell on the way from `before`, (n, 2) [m], until `t` [s]."""
        after = self._positions()
        falls = self._pocketing.take(before, after)
        if not falls:
            return
        moving = rolling_state(
            after[np.newaxis], np.array(self._velocities)[np.newaxis], self._radii
        )
        for fall, state in states_at_falls(before, moving, falls):
            places, velocities = state.positions[0, :, :2], state.velocities[0, :, :2]
            self._recorder.rolling_frame(
                instant_of(fall, self.t, t), places, velocities, force=True
            )
        for fall in falls:
            at = instant_of(fall, self.t, t)
            self._recorder.event(at, EventKind.POCKETED, fall.ball, fall.pocket)
            self.rest_time = max(self.rest_time, at)
            self._world.remove(fall.ball)
            self._velocities[fall.ball] = [0.0, 0.0]
            self._in_bullet[fall.ball] = [0.0, 0.0]

    def _positions(self) -> FloatArray:
        positions = self._world.positions()[:, :2]
        self._pocketing.keep(positions)
        return positions

    def _send(self, velocities: Vectors, speeds: list[float], dt: float) -> None:
        """Give every ball its mean velocity over the coming step: v (|v| - mu g dt/2) / |v|."""
        for i, (speed, (x, y)) in enumerate(zip(speeds, velocities, strict=True)):
            factor = 0.0
            if speed > 0.0:
                loss = self._slowed_by[i] * dt
                mean = speed * speed / (2.0 * loss) if speed < loss else speed - 0.5 * loss
                factor = mean / speed
            sent = [x * factor, y * factor]
            if sent != self._in_bullet[i]:
                self._world.set_velocity(i, [*sent, 0.0], [0.0, 0.0, 0.0])
            self._in_bullet[i] = sent

    def _second_half_kick(self, dt: float) -> Vectors:
        """Return the velocities at the end of the step [m/s].

        A ball that stopped in it had at most mu g dt/2 of mean velocity, so it gets exactly 0.
        """
        kicked = []
        for i, (speed, (x, y)) in enumerate(
            zip(_speeds(self._in_bullet), self._in_bullet, strict=True)
        ):
            factor = 0.0
            if speed > 0.0:
                factor = max(speed - 0.5 * self._slowed_by[i] * dt, 0.0) / speed
            kicked.append([x * factor, y * factor])
        return kicked

    def _note_collisions(
        self, new: list[Contact], touched: set[int], before: Vectors, dt: float
    ) -> None:
        """Record collisions, at the step's start: there Bullet saw them and changed velocities."""
        for contact in new:
            self._recorder.event(self.t, contact.kind, contact.a, contact.b)
        if self._recorder.record == "trajectory":
            positions = self._positions() - np.array(self._in_bullet) * dt
            after = [self._in_bullet[i] if i in touched else v for i, v in enumerate(before)]
            for velocities in (before, after):
                self._recorder.rolling_frame(self.t, positions, np.array(velocities), force=True)


def _speeds(velocities: Vectors) -> list[float]:
    """Return the lengths of vectors; by numpy, whose last bit `math.hypot` doesn't always share."""
    x, y = np.array(velocities).T
    speeds: list[float] = np.hypot(x, y).tolist()
    return speeds
