"""Small changes of a shot in air or in flight, followed by central differences.

The shot is cut at instants soon after its events. From each instant to the next one, the balls are
simulated twice: once from their recorded states plus the changes, once from these states minus the
changes. The changes are scaled down first, until the motion's response is proportional to them;
then half the difference between the two final states is the change at the next instant. If the
recorded final state isn't midway between the two, the response isn't proportional: no derivative
exists, and the changes of the ball are unknown from that instant on.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core import state as st
from ghostball.engine.core.state import FloatArray
from ghostball.engine.event_loop import play
from ghostball.engine.running.from_scene import layout_of
from ghostball.engine.sensitivity.passages import collisions_at_once
from ghostball.engine.sensitivity.replay import ReplayedMotion, motion_after, states_after
from ghostball.engine.sensitivity.rounding import LANES
from ghostball.model import ExactTrajectory, Scene
from ghostball.model.events import EventKind, Events
from ghostball.model.trajectory.polynomial import OF_X, OF_Y, PER_POWER

STATE = 9
"""Numbers in a ball's state: three each for position, velocity and angular velocity."""

_KNOWN = [0, 1, 3, 4, 6, 7, 8]
"""Numbers of a state whose changes are arguments and results: all except height and vertical
velocity, which don't change on the cloth.
"""

_STEP = 2.0**-20
"""Size of the changes that are simulated, in units of `_scales`. The neglected terms grow with its
square; the rounding errors of the result are divided by it."""

_STILL = 2.0**-20
"""Fraction of the largest speed below which a ball counts as at rest.

A ball that stops keeps a small speed by rounding. Changes in proportion to that speed would be
smaller than their rounding errors.
"""

_MARGIN = 2.0**-16
"""Duration before and after an event within which no simulation ends [s].

Within this duration, some changed balls have passed the event already, and the other changed balls
haven't. The simulation ends outside of this duration, and the result is extrapolated to the
requested time with the changes of velocity.
"""

_SOON, _LEAST_GAP = 2.0**-10, 2.0**-14
"""Delay from an event to the instant at which the changes are measured [s], and the least time
between two events for which changes are measured between them [s]."""

_CURVED = 0.1
"""Largest distance of the mean of both simulations from the recorded state, over the change."""

_PUSHED = 2.0**-20
"""Largest relative difference between the recorded acceleration of a ball and the acceleration by
cloth and air alone, for a ball that touches nothing else."""

_MOST_REPLAYED = 64
"""Number of events since an instant beyond which the motion of the changed states is recorded once
and then read at all times, because simulating it anew for each time would take too long."""

_ROUNDING = 2.0**-40
"""Addition to the limit `_CURVED`, in radii: the rounding error of the mean."""


class Replayed:
    """The changes of a shot's states that follow from m changes of its first state.

    `at` (c,) float64 [s]: the instants between which the changes are simulated.
    """

    def __init__(
        self,
        scene: Scene,
        trajectory: ExactTrajectory,
        events: Events,
        given: FloatArray | None,
        runs: int = 0,
    ) -> None:
        """Follow changes to the end of the shot.

        `given` (n, 7, m): the changes of the first state; None: rounding errors of the first state
            and of the state after each event.
        `runs`: without `given`, the number of samples of rounding errors is LANES times this.
        """
        n, rounds = len(scene.balls), given is None
        changes = np.zeros((n, STATE, LANES * runs if given is None else given.shape[2]))
        if given is not None:
            changes[:, _KNOWN] = given
            rolls = scene.rolls
            changes[rolls, 6:8] = (
                changes[rolls, 4:2:-1] / scene.radii[rolls, np.newaxis, np.newaxis]
            )
            changes[rolls, 6] *= -1.0
        self._scene, self._trajectory, self._events = scene, trajectory, events
        self._layout = layout_of(scene)
        self._long: tuple[int, list[ReplayedMotion]] = -1, []  # an instant, and what follows it
        self._instants = np.unique(events["t"])
        self.at = np.array([0.0, *self._measured()])
        self._states, self._phases = _states(trajectory, self.at), trajectory.phases(self.at)
        # The recorded first state is that after the impacts of balls that touch at the start.
        vectors = (scene.positions, scene.velocities, scene.angular_velocities)
        self._states[0] = np.concatenate(vectors, axis=1)
        self._phases[0] = self._layout.state[:, st.PHASE]
        moves = np.any(scene.velocities != 0.0, axis=1)
        self._phases[0, (self._phases[0] == st.ROLLING) & ~moves] = st.RESTING
        self._kept = np.full((len(self.at), *changes.shape), np.nan)
        self._rank = np.argsort(np.lexsort((scene.positions[:, 1], scene.positions[:, 0])))
        self._rounded = np.zeros(n, dtype=np.int64)
        self._free_until = np.array([self._free_until_of(i) for i in range(n)])
        lost = np.zeros(n, dtype=np.bool_)
        if rounds:
            changes = self._noise(0, np.arange(n), changes)
        for j in range(len(self.at)):
            if j > 0:
                ((changes,), (curved,)) = self._played(
                    j - 1, self.at[j : j + 1], self._states[j : j + 1]
                )
                its = events[(events["t"] > self.at[j - 1]) & (events["t"] <= self.at[j])]
                lost |= curved | (self._free_until <= self.at[j])
                if j == 1:
                    its = events[events["t"] <= self.at[j]]
                _lose(its, lost)
                if rounds:
                    pairs = its["kind"] == EventKind.BALL_BALL
                    balls = np.unique(np.append(its["a"], its["b"][pairs]))
                    changes = self._noise(j, balls, changes)
            still = (self._phases[j] == st.RESTING) & (scene.rolling_frictions > 0.0)
            still |= self._phases[j] == st.GONE
            changes[still, 3:6] = 0.0
            changes[lost] = np.nan
            self._kept[j] = changes

    def sample(self, times: FloatArray) -> FloatArray:
        """Return the changes at k instants, (k, n, STATE, m); NaN if no derivative exists."""
        found = np.empty((len(times), *self._kept.shape[1:]))
        after = np.searchsorted(self.at, times, side="right") - 1
        for j in np.unique(after).tolist():
            its = np.flatnonzero(after == j)
            sides = np.array([self._side(j, t) for t in times[its].tolist()])
            found[its] = self._beside(j, times[its], sides)
        return found

    def known(self, times: FloatArray) -> FloatArray:
        """Return the changes at k instants, (k, n, 7, m), of the numbers in `given`."""
        return self.sample(times)[:, :, _KNOWN]

    def moved(self, times: FloatArray) -> Iterator[FloatArray]:
        """Yield the changes of the positions at k instants, (3, k, n, m) [m]."""
        yield np.moveaxis(self.sample(times)[:, :, :3], 2, 0)

    @property
    def event_shifts(self) -> FloatArray:
        """The delay of each event [s], (events, m), from the changes just before and after it.

        The change of the position jumps by the delay times the jump of the velocity. Where the
        velocity doesn't jump, the change of the velocity jumps by the delay times the jump of the
        acceleration. The result is NaN if a ball has another event soon.
        """
        shifts = np.full((len(self._events), self._kept.shape[3]), np.nan)
        for k, (t, kind, a, b) in enumerate(self._events.tolist()):
            balls = [a, b] if kind == EventKind.BALL_BALL else [a]
            j = int(np.searchsorted(self.at, t, side="left")) - 1
            near = self._events[np.abs(self._events["t"] - t) < 3.0 * _MARGIN]
            alone = np.count_nonzero(_has(near, balls)) == 1
            if j < 0 or not alone:
                continue
            changes = self._beside(j, np.array([t, t]), t + _MARGIN * np.array([-1.0, 1.0]))
            before, after = changes[:, balls]
            sides = _states(self._trajectory, t + _MARGIN * np.array([-2.0, -1.0, 1.0, 2.0]))
            slower = (sides[1] - sides[2])[balls, 3:6]
            jump = (after - before)[:, :3]
            rates = (sides[1::2] - sides[::2])[:, balls, 3:6] / _MARGIN
            if np.max(np.abs(slower)) < 4.0 * _MARGIN * np.max(np.abs(rates)):
                slower, jump = rates[0] - rates[1], (after - before)[:, 3:6]
            square = float(np.sum(slower * slower))
            if square > 0.0:
                shifts[k] = np.einsum("ij,ijm->m", slower, jump) / square
        return shifts

    def _measured(self) -> Iterator[float]:
        """Yield the instants at which changes are measured: soon after events.

        An instant is left out while a ball makes low bounces, when its state isn't known.
        """
        ends = np.append(self._instants, self._trajectory.t_end)[1:]
        unknown = self._low_bounces()
        for t, end in zip(self._instants.tolist(), ends.tolist(), strict=True):
            at = t + min(0.5 * (end - t), _SOON)
            if end - t > _LEAST_GAP and not np.any((unknown[:, 0] < at) & (at < unknown[:, 1])):
                yield at

    def _low_bounces(self) -> FloatArray:
        """Return the intervals of bounces that the engine doesn't follow one by one, (k, 2) [s].

        Each interval ends with an event on the cloth, before which the ball isn't in flight.
        """
        found = [(0.0, 0.0)]
        for event in self._events[self._events["kind"] == EventKind.BALL_CLOTH]:
            rows = self._trajectory.segments[event["a"]]
            row = int(np.searchsorted(rows[:, st.EPOCH], event["t"], side="left")) - 1
            if row >= 0 and rows[row, st.PHASE] != st.FLYING:
                found.append((float(rows[row, st.EPOCH]), float(event["t"])))
        return np.array(found)

    def _free_until_of(self, i: int) -> float:
        """Return the start of the first resting contact of ball i [s]; inf if it has none.

        The contact shows in the acceleration, which differs from that by cloth and air alone. After
        this contact no derivative exists: if the contact opens to a gap h, the ball bounces at
        speeds of the order of sqrt(h).
        """
        scene, rows = self._scene, self._trajectory.segments[i]
        physics, radius = scene.physics, float(scene.radii[i])
        slides, rolls = (rows[:, st.PHASE] == phase for phase in (st.SLIDING, st.ROLLING))
        velocity = rows[:, st.VX : st.VY + 1]
        turning = radius * rows[:, [st.WY, st.WX]] * (-1.0, 1.0)
        slip = velocity + np.where(slides[:, np.newaxis], turning, 0.0)
        speed, slipping = np.linalg.norm(velocity, axis=1), np.linalg.norm(slip, axis=1)
        # If balls may slide, friction of the cloth cancels 2/7 of the drag.
        felt = physics.air_drag * (5.0 / 7.0 if physics.motion == "sliding" else 1.0)
        rolling = scene.rolling_frictions[i] * physics.gravity
        rolling += (felt + physics.rolling_friction_quadratic) * speed * speed
        slow = np.where(rolls, rolling, scene.sliding_frictions[i] * physics.gravity)
        free = -(slow / np.where(slipping > 0.0, slipping, 1.0))[:, np.newaxis] * slip
        free -= np.where(slides, physics.air_drag * speed, 0.0)[:, np.newaxis] * velocity
        off = np.linalg.norm(rows[:, st.AX : st.AY + 1] - free, axis=1)
        # The last piece of a slide in air is a parabola, which neglects the turning of the slip by
        # drag.
        drag = physics.air_drag * speed * speed
        powers = self._trajectory.powers(rows)
        bent = np.any(powers[OF_X::PER_POWER], axis=0) | np.any(powers[OF_Y::PER_POWER], axis=0)
        straight = slides & ~bent & (len(powers) > 0)
        pushed = (slides | rolls) & ~(off <= _PUSHED * (slow + drag) + straight * drag)
        starts, bounces = rows[:, st.EPOCH], self._low_bounces()[:, 0]
        pushed &= ~np.isin(starts, bounces)
        return float(np.min(starts[pushed], initial=math.inf))

    def _side(self, j: int, t: float) -> float:
        """Return the instant at which the simulation for an instant t ends, away from events."""
        k = int(np.searchsorted(self._instants, t, side="right"))
        if k > 0 and t - self._instants[k - 1] < _MARGIN:
            return float(self._instants[k - 1] + _MARGIN)
        if k < len(self._instants) and self._instants[k] - t < _MARGIN:
            return float(max(self._instants[k] - _MARGIN, self.at[j]))
        return t

    def _beside(self, j: int, times: FloatArray, sides: FloatArray) -> FloatArray:
        """Return the changes at k times after instant j, (k, n, STATE, m).

        They are extrapolated from the changes at `sides` (k,) [s], near the times.
        """
        sides = np.maximum(sides, self.at[j])
        later = sides > self.at[j]
        changes = np.repeat(self._kept[j : j + 1], len(times), axis=0)
        if np.any(later):
            ends = _states(self._trajectory, sides[later])
            played, curved = self._played(j, sides[later], ends)
            played[curved] = np.nan
            changes[later] = played
        changes[self._free_until <= times[:, np.newaxis]] = np.nan
        gone = (times - sides)[:, np.newaxis, np.newaxis, np.newaxis]
        changes[:, :, :3] += gone * changes[:, :, 3:6]
        return changes

    def _played(
        self, j: int, times: FloatArray, recorded: FloatArray
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Return the changes at k times after instant j, and for which balls they are unknown.

        `recorded` (k, n, STATE): the recorded states at `times` (k,) [s].

        Returns (k, n, STATE, m) float64 and (k, n) bool.
        """
        kept = self._kept[j]
        lost = ~np.all(np.isfinite(kept), axis=(1, 2))
        if np.all(lost):
            return np.repeat(kept[np.newaxis], len(times), axis=0), np.tile(lost, (len(times), 1))
        changes = np.where(lost[:, np.newaxis, np.newaxis], 0.0, kept)
        largest = np.max(np.abs(changes) / self._scales(j)[:, :, np.newaxis], axis=(0, 1))
        sizes = _STEP / np.where(largest > 0.0, largest, 1.0)
        by = np.moveaxis(changes * sizes, 2, 0)
        ends = self._ends(j, by, times - self.at[j])
        half, middle = 0.5 * (ends[:, 0] - ends[:, 1]), 0.5 * (ends[:, 0] + ends[:, 1])
        size = np.max(np.abs(half[..., :3]), axis=(2, 3))[..., np.newaxis]
        off = np.max(np.abs(middle - recorded[:, np.newaxis])[..., :3], axis=3)
        allowed = _CURVED * size + _ROUNDING * self._scene.radii
        curved: NDArray[np.bool_] = lost | np.any(~(off <= allowed), axis=1)
        changes = np.moveaxis(half, 1, 3) / sizes
        return changes, curved

    def _ends(self, j: int, by: FloatArray, durations: FloatArray) -> FloatArray:
        """Return the simulated states some durations after instant j, (k, 2, m, n, STATE).

        They start from the recorded states plus the changes `by` (m, n, STATE), and minus them.
        """
        state = self._states[j]
        starts = np.zeros((2, *by.shape[:2], play.START_COLUMNS))
        starts[..., :STATE] = state
        starts[..., play.START_RISE] -= self._scene.radii
        starts[0, ..., :STATE] += by
        starts[1, ..., :STATE] -= by
        phase = self._phases[j].astype(np.float64)
        starts[..., play.START_PHASE] = np.where(phase == st.RESTING, st.ROLLING, phase)
        each = starts.reshape(-1, *starts.shape[2:])
        since = self._events["t"] - self.at[j]
        met = np.count_nonzero((since > 0.0) & (since <= np.max(durations)))
        if met <= _MOST_REPLAYED:
            ends = np.array([states_after(self._layout, each, s) for s in durations.tolist()])
        else:
            if self._long[0] != j:
                end = float(np.append(self.at, self._trajectory.t_end)[j + 1]) + _MARGIN
                lasts = end - self.at[j]
                self._long = j, [motion_after(self._scene, one, lasts) for one in each]
            ends = np.stack([motion.states(durations) for motion in self._long[1]], axis=1)
        ends = ends.transpose(0, 1, 3, 2, 4)
        return ends.reshape(len(durations), *starts.shape[:3], STATE)

    def _scales(self, j: int) -> FloatArray:
        """Return the scale of each number at instant j, (n, STATE).

        Changes must be small compared to it. The scale of a velocity is the speed that gives
        friction its direction: the slip of a ball that slides, the speed of a ball that rolls.
        """
        state, phase, radius = self._states[j], self._phases[j], self._scene.radii
        speed = np.linalg.norm(state[:, 3:6], axis=1)
        fastest = np.max(np.maximum(speed, radius * np.linalg.norm(state[:, 6:], axis=1)))
        fastest = fastest if fastest > 0.0 else 1.0
        slip = np.hypot(state[:, 3] - radius * state[:, 7], state[:, 4] + radius * state[:, 6])
        turns = np.where(phase == st.SLIDING, slip, np.where(phase == st.ROLLING, speed, fastest))
        turns = np.where(turns > _STILL * fastest, turns, fastest)
        scales: FloatArray = np.empty_like(state)
        scales[:, :3] = radius[:, np.newaxis]
        scales[:, 3:6] = turns[:, np.newaxis]
        scales[:, 6:8] = (turns / radius)[:, np.newaxis]
        spin = np.abs(state[:, 8])
        scales[:, 8] = np.where(radius * spin > _STILL * fastest, spin, fastest / radius)
        return scales

    def _noise(self, j: int, balls: NDArray[np.intp], changes: FloatArray) -> FloatArray:
        """Return the changes plus random rounding errors of the states of balls at instant j."""
        state, radius = self._states[j, balls], self._scene.radii[balls]
        size = np.abs(state)
        place = size[:, :3] + radius[:, np.newaxis] + self.at[j] * size[:, 3:6]
        size[:, :3] = np.where(size[:, 3:6] > 0.0, place, 0.0)
        turns = np.isin(self._phases[j, balls], (st.SLIDING, st.FLYING))
        size[~turns, 6:8] = 0.0
        added = changes.copy()
        for ball, its in zip(balls.tolist(), size, strict=True):
            seed = (int(self._rank[ball]), int(self._rounded[ball]))
            signs = np.random.default_rng(seed).integers(0, 2, added.shape[1:])
            added[ball] += its[:, np.newaxis] * (1.0 - 2.0 * signs)
            self._rounded[ball] += 1
        return added


def _has(events: Events, balls: Sequence[int]) -> NDArray[np.bool_]:
    """Return which events involve at least one of the balls, (events,) bool."""
    pairs = events["kind"] == EventKind.BALL_BALL
    found: NDArray[np.bool_] = np.isin(events["a"], balls) | (pairs & np.isin(events["b"], balls))
    return found


def _states(trajectory: ExactTrajectory, times: FloatArray) -> FloatArray:
    """Return the recorded states at k instants, (k, n, STATE)."""
    sampled = trajectory.sample(np.clip(times, 0.0, trajectory.t_end))
    states: FloatArray = np.concatenate(sampled, axis=2)
    return states


def _lose(events: Events, lost: NDArray[np.bool_]) -> None:
    """Mark the balls whose changes are unknown after some events, in `lost`.

    These are the balls with two collisions at one instant, whose order any change decides, and the
    balls that collide with a marked ball.
    """
    counts = collisions_at_once(events)
    for t, kind, a, b in events.tolist():
        balls = [a, b] if kind == EventKind.BALL_BALL else [a]
        if any(lost[ball] or counts.get((t, ball), 0) > 1 for ball in balls):
            lost[balls] = True
