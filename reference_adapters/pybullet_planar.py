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
from numpy.typing import NDArray

from engine import EventKind, Samples, Scene
from engine.scene import rolling_angular_velocity
from reference_adapters.landing import rolling_accelerations, time_to_contact, time_to_rest
from reference_adapters.pybullet_world import SHORTEST_STEP, Contact, World, native_steps
from reference_adapters.recording import Recorder

EPS = float(np.finfo(np.float64).eps)

FloatArray = NDArray[np.float64]


class PlanarRun:
    """The run of one scene whose balls roll.

    Attributes
    ----------
    t : float
        Time reached [s].
    rest_time : float
        When the last ball stopped so far [s].
    work : dict of str to int
        "steps" of Bullet, "contacts" that pushed in a step, summed over the steps.
    """

    def __init__(self, world: World, scene: Scene, recorder: Recorder) -> None:
        self._world = world
        self._scene = scene
        self._recorder = recorder
        self._radii = scene.radii
        self._decelerations = scene.rolling_frictions * scene.physics.gravity
        self._velocities = scene.velocities[:, :2]
        self._in_bullet = np.zeros_like(self._velocities)  # what each body has at present
        self.t = 0.0
        self.rest_time = 0.0
        self.work = {"steps": 0, "contacts": 0}
        recorder.frame(0.0, self.state())

    @property
    def at_rest(self) -> bool:
        """Whether every ball's velocity is exactly 0."""
        return not np.any(self._velocities)

    def state(self) -> Samples:
        """Return the state now, arrays (1, n, 3); z is the radius, spin that of rolling."""
        return self._samples(self._world.positions()[:, :2], self._velocities)

    def run(
        self, mode: Literal["native", "landed"], dt: float, t_end: float, max_steps: int
    ) -> None:
        """Run until every ball rests, or to `t_end` exactly, in steps of at most `dt` [s]."""
        if mode == "landed":
            self._landed(dt, t_end, max_steps)
        else:
            self._native(dt, t_end, max_steps)

    def _native(self, dt: float, t_end: float, max_steps: int) -> None:
        for duration, t in native_steps(dt, t_end, max_steps):
            if self.at_rest:
                return
            self._advance(duration, t)

    def _landed(self, dt: float, t_end: float, max_steps: int) -> None:
        """Step to each contact: one step lands, one overlaps, one lets Bullet resolve.

        Bullet sees spheres from the first step that starts with an overlap; `time_to_contact` asks
        for one as large as its landing gap.
        """
        while not self.at_rest and self.t < t_end and self.work["steps"] < max_steps:
            stops = time_to_rest(self._velocities, self._decelerations)
            # Up to the next stop, and by a few roundings past it, so that the ball does stop.
            horizon = min(dt, float(np.min(stops[stops > 0.0])) * (1.0 + 4.0 * EPS))
            to_contact = time_to_contact(
                self._world.positions()[:, :2],
                self._velocities,
                rolling_accelerations(self._velocities, self._decelerations),
                self._radii,
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
        speeds = np.hypot(before[:, 0], before[:, 1])
        self._send(before * self._mean_factor(speeds, dt)[:, np.newaxis])
        self._world.step(dt)
        self.work["steps"] += 1
        contacts, new = self._world.contacts()
        self.work["contacts"] += len(contacts)
        touched = sorted({ball for contact in contacts for ball in contact.balls})
        self._receive(sorted({*touched, *np.flatnonzero(speeds).tolist()}))
        if new:
            self._note_collisions(new, touched, before, dt)
        self._velocities = self._second_half_kick(dt)
        stopped = (speeds > 0.0) & ~np.any(self._velocities, axis=1)
        for i in np.flatnonzero(stopped).tolist():
            # One that Bullet left alone stops where the closed form says, within the step.
            rolled = dt if i in touched else min(dt, float(speeds[i] / self._decelerations[i]))
            self._recorder.event(self.t + rolled, EventKind.ROLL_TO_REST, i)
            self.rest_time = max(self.rest_time, self.t + rolled)
        self.t = t
        if self._recorder.wants_frame(t):
            self._recorder.frame(t, self.state())

    def _mean_factor(self, speeds: FloatArray, dt: float) -> FloatArray:
        """Return mean over present velocity of each ball in the coming step, (n,) [1]."""
        loss = self._decelerations * dt
        mean = speeds - 0.5 * loss
        stopping = speeds < loss
        mean[stopping] = speeds[stopping] ** 2 / (2.0 * loss[stopping])
        return np.divide(mean, speeds, out=np.zeros_like(speeds), where=speeds > 0.0)

    def _send(self, velocities: FloatArray) -> None:
        changed = np.any(velocities != self._in_bullet, axis=1)
        for i in np.flatnonzero(changed).tolist():
            self._world.set_velocity(i, [*velocities[i].tolist(), 0.0], [0.0, 0.0, 0.0])
        self._in_bullet = velocities

    def _receive(self, balls: list[int]) -> None:
        """Read velocities back; of the others nothing but `_send` can have changed them."""
        for i in balls:
            self._in_bullet[i] = self._world.velocity(i)[0][:2]

    def _second_half_kick(self, dt: float) -> FloatArray:
        """Return the velocities at the end of the step, (n, 2) [m/s].

        A ball that stopped in it had at most mu g dt/2 of mean velocity, so it gets exactly 0.
        """
        speeds = np.hypot(self._in_bullet[:, 0], self._in_bullet[:, 1])
        left = np.maximum(speeds - 0.5 * self._decelerations * dt, 0.0)
        factor = np.divide(left, speeds, out=np.zeros_like(speeds), where=speeds > 0.0)
        return self._in_bullet * factor[:, np.newaxis]

    def _note_collisions(
        self, new: list[Contact], touched: list[int], before: FloatArray, dt: float
    ) -> None:
        """Record collisions, at the step's start: there Bullet saw them and changed velocities."""
        for contact in new:
            self._recorder.event(self.t, contact.kind, contact.a, contact.b)
        if self._recorder.record == "trajectory":
            positions = self._world.positions()[:, :2] - self._in_bullet * dt
            after = before.copy()
            after[touched] = self._in_bullet[touched]
            for velocities in (before, after):
                self._recorder.frame(self.t, self._samples(positions, velocities), force=True)

    def _samples(self, positions: FloatArray, velocities: FloatArray) -> Samples:
        centres = np.column_stack((positions, self._radii))
        spatial = np.column_stack((velocities, np.zeros_like(self._radii)))
        spin = rolling_angular_velocity(spatial, self._radii)
        return Samples(centres[np.newaxis], spatial[np.newaxis], spin[np.newaxis])
