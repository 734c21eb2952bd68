"""Runs one shot: gives the kernel its arrays, lets it work in chunks, reads what it left behind."""

from __future__ import annotations

import math
import time
from functools import cache
from threading import Event

import numpy as np

from ghostball.engine.core import state as s
from ghostball.engine.core.events import EVENT_DTYPE, EventKind, Events, Status
from ghostball.engine.core.kernel import compiling
from ghostball.engine.core.tolerances import position_rounding
from ghostball.engine.event_loop.entry import enter
from ghostball.engine.running.from_scene import layout_of, log_of, room_for_contacts
from ghostball.engine.running.skips import Skip
from ghostball.engine.running.variants import Variant, still_scene
from ghostball.engine.scene import Scene
from ghostball.engine.trajectory import ExactTrajectory, Samples

_CHUNK = 65_536
"""Events between two returns from the kernel, without contacts."""

_FIRST_LOG = 1_024
"""Events that the first log holds; a full one is followed by one twice as large."""


_BALL_BALL, _BALL_CUSHION = EventKind.BALL_BALL.label, EventKind.BALL_CUSHION.label


_MOTION = {
    "position": slice(s.X, s.Y + 1),
    "velocity": slice(s.VX, s.VY + 1),
    "acceleration": slice(s.AX, s.AY + 1),
    "angular velocity": slice(s.WX, s.WZ + 1),
    "angular acceleration": slice(s.BX, s.BZ + 1),
}
"""What a message says of a ball's motion: name, and columns of its state."""


@cache
def warm_up(variant: Variant) -> None:
    """Compile a variant of the kernels, or load it, so that no run's `wall_time` includes that."""
    with compiling(variant.name("shots")):
        off = frozenset({Skip.INTEGRATED_LAWS}) if variant.integrated else frozenset[Skip]()
        run = Run(still_scene(variant), True, off)
        run.contacts = room_for_contacts(run.size) if variant.contacts else None
        run.go(1)
        if run.status is Status.INTERRUPTED:
            raise KeyboardInterrupt


def events_at_once(n: int, with_contacts: bool) -> int:
    """Return how many events and contact steps of n balls a kernel does between two returns.

    Some 20 ms, so that an interrupt is seen. With contacts fewer, and the fewer the more balls
    there are, for a step of hundreds takes long.
    """
    return min(max(_CHUNK // 16 // n, 16), _CHUNK) if with_contacts else _CHUNK


class Run:
    """One run of the kernel on one scene.

    Attributes
    ----------
    status : Status
    t_end : float [s]
        When the last ball came to rest, or the run stopped.
    wall_time : float [s]
        Of the kernel.
    reason : str
    size : int
        Number of balls.
    variant : Variant
        Of the kernels that it begins with.
    contacts : tuple of three arrays, or None
        Room for contacts; None until the run turns out to need them; most don't.
    """

    def __init__(self, scene: Scene, keep_log: bool, off: frozenset[Skip] = frozenset()) -> None:
        self.status = Status.FAILED
        self.reason = ""
        self.t_end = 0.0
        self.wall_time = 0.0
        self._keep_log = keep_log
        self._scene = scene
        self._layout = layout = layout_of(scene, off)
        self.size = n = len(layout.radii)
        self.variant = layout.variant
        balls, pairs = layout.balls, layout.pairs
        self._state = balls.state.copy()
        self._begin = (
            self._state,
            balls.own_kind.copy(),
            balls.changed.copy(),
            balls.touched.copy(),
            np.empty_like(balls.hits),
            np.empty_like(balls.near),
            None if balls.higher is None else balls.higher.copy(),
            balls.air and s.Air._make(array.copy() for array in balls.air),
            None if balls.height is None else balls.height.copy(),
            layout.laws,
            layout.obstacles,
            layout.integrated,
            pairs.bound.copy(),
            pairs.least.copy(),
            pairs.next.copy(),
            np.empty_like(pairs.track),
            layout.cells and s.Cells._make(array.copy() for array in layout.cells),
        )
        self.contacts = room_for_contacts(n) if self.variant.contacts else None
        knot = s.KNOT if balls.higher is None else s.KNOT + balls.higher.shape[1] - s.HIGHER
        knot += 0 if balls.height is None else 3
        knot += 0 if balls.air is None else balls.air.turning.shape[1]
        self._log = log_of(_FIRST_LOG if keep_log else 0, n, knot)
        self._clock, self._counters = self._log.clock, self._log.counters
        self._logs: list[s.Log] = []
        self._end = np.empty((3, n, 3))

    @property
    def nbytes(self) -> int:
        """Memory of all arrays that the kernels work on [B]."""
        air, cells = self._layout.balls.air or (), self._begin[-1] or ()
        parts = (*self._begin, *air, *cells, *(self.contacts or ()), *self._log)
        arrays = [part for part in parts if isinstance(part, np.ndarray)]
        return sum(array.nbytes for array in arrays) + self._end.nbytes

    def go(self, max_events: int, stop: Event | None = None) -> None:
        """Run to the end, to `max_events` events, to an interrupt, or until `stop` is set."""
        try:
            code = self._go(max_events, stop)
            self.status = STATUS[code]
        except KeyboardInterrupt:
            # The kernel had returned: its arrays are as they were after its last whole event.
            code = self._enter(0, True)
            self.status = Status.INTERRUPTED
        self.t_end = float(self._clock[s.END])
        now = float(self._clock[s.NOW])
        if self.status is Status.EVENT_LIMIT:
            events, steps = self._counters[s.EVENTS], self._counters[s.CONTACT_STEPS]
            self.reason = f"{events} events and {steps} contact steps by t = {now:.9g} s"
        elif self.status is Status.FAILED:
            self.reason = f"{self._unsound(code)} at t = {now:.9g} s"
        self._check_resolved()

    def _unsound(self, code: int) -> str:
        """Say what isn't finite where a run failed, or what it had no room for."""
        if code == s.RUN_NO_ROOM:
            return (
                "more balls touch than can lie side by side: they are hardly larger than the "
                "rounding of their coordinates. Move the scene to the origin. It stopped"
            )
        k = int(self._counters[s.UNSOUND])
        if k == s.FREE:
            return "the time of the next event became NaN"
        ball = f'`balls[{k}]` ("{self._scene.balls[k].id}")'
        state = self._state[k]
        wrong = [
            f"{name} {tuple(state[columns].tolist())}"
            for name, columns in _MOTION.items()
            if not np.all(np.isfinite(state[columns]))
        ]
        if not math.isfinite(state[s.RADIUS]):
            wrong.append(f"radius of {state[s.RADIUS]}")
        if not wrong and state[s.OWN_TIME] >= self._clock[s.NOW]:
            return f"contacts of {ball} are looked for without end"
        if not wrong:
            return f"{ball} has its next event at {state[s.OWN_TIME]:.9g} s, not later than now"
        return f"{ball} has no finite motion ({', '.join(wrong)})"

    def _go(self, max_events: int, stop: Event | None) -> int:
        counters = self._counters
        while True:
            if stop is not None and stop.is_set():
                raise KeyboardInterrupt
            done = int(counters[s.EVENTS] + counters[s.CONTACT_STEPS])
            limit = min(done + events_at_once(self.size, self.contacts is not None), max_events)
            code = self._enter(limit, limit == max_events)
            if code == s.RUN_LOG_FULL:
                self._start_new_log()
            elif code == s.RUN_CONTACTS:
                warm_up(self.variant._replace(contacts=True))
                self.contacts = room_for_contacts(self.size)
            elif code != s.RUN_EVENT_LIMIT or limit == max_events:
                return code

    def _enter(self, limit: int, last: bool) -> int:
        started = time.perf_counter()
        try:
            return enter(*self._begin, self.contacts, *self._log, self._end, limit, last)
        finally:
            self.wall_time += time.perf_counter() - started

    def _check_resolved(self) -> None:
        """Fail where a ball went so far that doubles no longer resolve a collision there."""
        farthest, smallest = float(self._clock[s.FARTHEST]), self._layout.smallest_radius
        if self.status is not Status.FAILED and not position_rounding(farthest) < smallest:
            self.status = Status.FAILED
            self.reason = (
                f"a ball went {farthest:.3g} m away, where double precision can't tell positions "
                f"apart by a radius of {smallest:.3g} m. Set `t_max` sooner, or slow the balls"
            )

    def _start_new_log(self) -> None:
        """Keep the full log and go on in one twice as large."""
        full = self._trimmed_log()
        knot = self._log.motion.shape[1]
        larger = log_of(2 * len(self._log.time), len(self._state), knot)
        larger = larger._replace(clock=self._clock, counters=self._counters)
        # In this order an interrupt in between loses nothing and repeats nothing: an empty new log
        # first, then the full one is kept.
        self._log = larger
        self._counters[[s.LOGGED_EVENTS, s.LOGGED_MOTIONS]] = 0
        self._logs.append(full)

    def final_state(self) -> Samples:
        """State of every ball at `t_end`, arrays (1, n, 3)."""
        end = self._end
        return Samples(end[0:1], end[1:2], end[2:3])

    def collision_counts(self) -> dict[str, int]:
        """Collisions by kind."""
        return {
            _BALL_BALL: int(self._counters[s.BALL_BALL]),
            _BALL_CUSHION: int(self._counters[s.BALL_CUSHION]),
        }

    def work(self) -> dict[str, int]:
        """Machine-independent counters of what the run did; some only where there is any."""
        counters = self._counters.tolist()
        work = {
            "events": counters[s.EVENTS],
            "bounds": counters[s.BOUNDS],
            "advancement_steps": counters[s.ADVANCEMENTS],
            "cell_moves": counters[s.CELL_MOVES],
            "joint_impacts": counters[s.JOINT_IMPACTS],
            "unsolved_joint_impacts": counters[s.UNSOLVED_JOINT_IMPACTS],
            "contact_steps": counters[s.CONTACT_STEPS],
            "unsolved_contact_steps": counters[s.UNSOLVED_STEPS],
        }
        for name, place in (("contact_pieces", s.CONTACT_PIECES), ("balls_gone", s.BALLS_GONE)):
            if counters[place]:
                work[name] = counters[place]
        return work

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
        order = np.argsort(log.ball, kind="stable")
        ends = np.cumsum(np.bincount(log.ball, minlength=len(self._state)))
        knots = np.split(log.motion[order], ends[:-1])
        spin_decelerations = self._state[:, s.SPIN_SLOWING].copy()
        balls = self._layout.balls
        return ExactTrajectory(
            self._layout.radii,
            tuple(knots),
            self.t_end,
            spin_decelerations,
            turns=balls.air is not None,
            lifts=balls.height is not None,
        )

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


STATUS = {
    s.RUN_RESTED: Status.REST,
    s.RUN_T_MAX: Status.T_MAX,
    s.RUN_EVENT_LIMIT: Status.EVENT_LIMIT,
    s.RUN_NOT_FINITE: Status.FAILED,
    s.RUN_NO_ROOM: Status.FAILED,
}
"""What a run's return means."""
