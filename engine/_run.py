"""Drives the kernel: gives it arrays, lets it work in chunks, reads what it left behind."""

from __future__ import annotations

import time
from functools import cache

import numpy as np

from engine import _state as s
from engine._jit import announce_compilation
from engine._loop import finish, run
from engine._tolerances import position_rounding
from engine.result import EVENT_DTYPE, EventKind, Events, Status
from engine.scene import Ball, Scene, rolling_angular_velocity
from engine.trajectory import ExactTrajectory, Samples

_CHUNK = 65_536
"""Events between two returns from the kernel, where an interrupt is seen: about 30 ms."""

_FIRST_LOG = 1_024
"""Events that the first log holds; a full one is followed by one twice as large."""


@cache
def warm_up() -> None:
    """Compile the kernels, or load them, so that no run's `wall_time` includes that."""
    announce_compilation()
    still = Run(Scene(name="warm-up", balls=(Ball(id="still", position=(0.0, 0.0)),)), True)
    still.go(1)


class Run:
    """One run of the kernel on one scene.

    Attributes
    ----------
    status : Status
    t_end : float [s]
        When the last ball came to rest, or the run stopped.
    wall_time : float [s]
        Of the kernels.
    reason : str
    """

    def __init__(self, scene: Scene, keep_log: bool) -> None:
        self.status = Status.FAILED
        self.reason = ""
        self.t_end = 0.0
        self.wall_time = 0.0
        self._scene = scene
        self._keep_log = keep_log
        self._balls, self._laws = s.balls_of(scene), s.laws_of(scene)
        self._pairs = s.pairs_of(len(scene.balls))
        self._contacts: s.Contacts | None = None  # most scenes need none
        self._log = s.log_of(_FIRST_LOG if keep_log else 0, len(scene.balls))
        self._clock, self._counters = self._log.clock, self._log.counters
        self._logs: list[s.Log] = []

    def go(self, max_events: int) -> None:
        """Run to the end, to `max_events` events, or to an interrupt."""
        started = time.perf_counter()
        try:
            code = self._go(max_events)
            interrupted = False
        except KeyboardInterrupt:
            # The kernel had returned: its arrays are as they were after its last whole event.
            code = s.RUN_EVENT_LIMIT
            interrupted = True
        code = finish(self._balls, self._laws, self._log, code)
        self.wall_time += time.perf_counter() - started
        self.t_end = float(self._clock[s.END])
        self.status = Status.INTERRUPTED if interrupted else _STATUS[code]
        now = float(self._clock[s.NOW])
        if self.status is Status.EVENT_LIMIT:
            events, steps = self._counters[s.EVENTS], self._counters[s.CONTACT_STEPS]
            self.reason = f"{events} events and {steps} contact steps by t = {now:.9g} s"
        elif self.status is Status.FAILED:
            self.reason = f"a time became NaN after t = {now:.9g} s"
        self._check_resolved()

    def _check_resolved(self) -> None:
        """Fail where a ball went so far that doubles no longer resolve a collision there."""
        if self.status is Status.FAILED:
            return
        state = self._balls.state
        farthest = float(np.max(np.abs(state[:, s.X : s.Y + 1])))
        smallest = float(np.min(state[:, s.RADIUS]))
        if not position_rounding(farthest) < smallest:
            self.status = Status.FAILED
            self.reason = (
                f"a ball went {farthest:.3g} m away, where double precision can't tell positions "
                f"apart by a radius of {smallest:.3g} m. Set `t_max` sooner, or slow the balls"
            )

    def _go(self, max_events: int) -> int:
        counters = self._counters
        while True:
            done = int(counters[s.EVENTS] + counters[s.CONTACT_STEPS])
            limit = min(done + _CHUNK, max_events)
            code = run(self._balls, self._laws, self._pairs, self._contacts, self._log, limit)
            if code == s.RUN_LOG_FULL:
                self._start_new_log()
            elif code == s.RUN_CONTACTS:
                self._contacts = s.contacts_of(len(self._scene.balls))
            elif code != s.RUN_EVENT_LIMIT or limit == max_events:
                return code

    def _start_new_log(self) -> None:
        """Keep the full log and go on in one twice as large."""
        full = self._trimmed_log()
        larger = s.log_of(2 * len(self._log.time), len(self._balls.own_kind))
        larger = larger._replace(clock=self._clock, counters=self._counters)
        # In this order an interrupt in between loses nothing and repeats nothing: an empty new log
        # first, then the full one is kept.
        self._log = larger
        self._counters[[s.LOGGED_EVENTS, s.LOGGED_MOTIONS]] = 0
        self._logs.append(full)

    def final_state(self) -> Samples:
        """State of every ball at `t_end`, arrays (1, n, 3)."""
        state, radii = self._balls.state, self._scene.radii
        positions = np.column_stack((state[:, s.X], state[:, s.Y], radii))
        velocities = np.column_stack((state[:, s.VX], state[:, s.VY], np.zeros(len(radii))))
        spins = rolling_angular_velocity(velocities, radii)
        sliding = state[:, s.PHASE] == s.SLIDING
        spins[sliding, 0] = state[sliding, s.WX]
        spins[sliding, 1] = state[sliding, s.WY]
        spins[:, 2] = state[:, s.WZ]
        return Samples(positions[np.newaxis], velocities[np.newaxis], spins[np.newaxis])

    def collision_counts(self) -> dict[str, int]:
        """Collisions by kind."""
        return {
            EventKind.BALL_BALL.label: int(self._counters[s.BALL_BALL]),
            EventKind.BALL_CUSHION.label: int(self._counters[s.BALL_CUSHION]),
        }

    def work(self) -> dict[str, int]:
        """Machine-independent counters of what the run did."""
        return {
            "events": int(self._counters[s.EVENTS]),
            "bounds": int(self._counters[s.BOUNDS]),
            "advancement_steps": int(self._counters[s.ADVANCEMENTS]),
            "joint_impacts": int(self._counters[s.JOINT_IMPACTS]),
            "unsolved_joint_impacts": int(self._counters[s.UNSOLVED_JOINT_IMPACTS]),
            "contact_steps": int(self._counters[s.CONTACT_STEPS]),
            "unsolved_contact_steps": int(self._counters[s.UNSOLVED_STEPS]),
        }

    def events(self) -> Events | None:
        """Return the event log, or None where none was kept."""
        if not self._keep_log:
            return None
        log = self._whole_log()
        events = np.empty(len(log.time), dtype=EVENT_DTYPE)
        events["t"] = log.time
        events["kind"], events["a"], events["b"] = log.what
        return events

    def trajectory(self) -> ExactTrajectory | None:
        """Return the motion between events, or None where no log was kept."""
        if not self._keep_log:
            return None
        log = self._whole_log()
        knots = [log.motion[log.ball == i] for i in range(len(self._balls.own_kind))]
        spin_decelerations = self._balls.state[:, s.SPIN].copy()
        return ExactTrajectory(self._scene.radii, tuple(knots), self.t_end, spin_decelerations)

    def _trimmed_log(self) -> s.Log:
        events, motions = self._counters[s.LOGGED_EVENTS], self._counters[s.LOGGED_MOTIONS]
        log = self._log
        return log._replace(
            time=log.time[:events],
            what=log.what[:, :events],
            ball=log.ball[:motions],
            motion=log.motion[:motions],
        )

    def _whole_log(self) -> s.Log:
        logs = (*self._logs, self._trimmed_log())
        return self._log._replace(
            time=np.concatenate([log.time for log in logs]),
            what=np.concatenate([log.what for log in logs], axis=1),
            ball=np.concatenate([log.ball for log in logs]),
            motion=np.concatenate([log.motion for log in logs]),
        )


_STATUS = {
    s.RUN_RESTED: Status.REST,
    s.RUN_T_MAX: Status.T_MAX,
    s.RUN_EVENT_LIMIT: Status.EVENT_LIMIT,
    s.RUN_NOT_FINITE: Status.FAILED,
}
