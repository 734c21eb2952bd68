"""Run one shot: pass the arrays to the kernel, let it work in chunks, and read the results."""

from __future__ import annotations

import math
import time
from functools import cache

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.rows import STATE_COLUMNS
from ghostball.engine.library.entry import Needed
from ghostball.engine.running import calls
from ghostball.engine.running.calls import (
    NO_LOG,
    STATUS,
    WORK_AT_ONCE,
    Limits,
    Log,
    Workplace,
    workplace_for,
)
from ghostball.engine.running.from_scene import layout_of, log_of
from ghostball.engine.running.skips import Skip
from ghostball.engine.running.variants import Variant, still_scene
from ghostball.model import ExactTrajectory, Physics, Samples, Scene
from ghostball.model.events import EVENT_DTYPE, EventKind, Events, Status
from ghostball.model.rounding import position_rounding

_FIRST_LOG = 1_024
"""Number of events in the first log; each further log has twice as many."""


_BALL_BALL, _BALL_CUSHION = EventKind.BALL_BALL.label, EventKind.BALL_CUSHION.label


_MOTION = {
    "position": slice(st.X, st.Y + 1),
    "velocity": slice(st.VX, st.VY + 1),
    "acceleration": slice(st.AX, st.AY + 1),
    "angular velocity": slice(st.WX, st.WZ + 1),
    "angular acceleration": slice(st.BX, st.BZ + 1),
}
"""The parts of a ball's motion in messages: name, and columns of its state."""


@cache
def warm_up(variant: Variant) -> None:
    """Compile or load a variant of the kernels, so that no `wall_time` includes this time."""
    needed(variant).load()


@cache
def needed(variant: Variant) -> Needed:
    """Return a variant of the kernels, for compiling or loading."""
    return calls.needed(layout_of(still_scene(variant)), variant.value)


def _elastic_laws(physics: Physics) -> list[str]:
    """Return the laws with which impacts lose no energy, in words for a message."""
    found = []
    if physics.ball_restitution == 1.0:
        found.append("`ball_restitution` is 1")
    if physics.cushion == "mirror":
        found.append('`cushion` is "mirror"')
    elif physics.cushion_restitution == 1.0 and physics.cushion_restitution_loss == 0.0:
        found.append("`cushion_restitution` is 1")
    return found


_RARE_WORK = {
    "contact_pieces": st.CONTACT_PIECES,
    "balls_gone": st.BALLS_GONE,
    "compliant_impacts": st.CLUSTERS,
    "compliant_legs": st.CLUSTER_LEGS,
}
"""Counters that a result has only if they aren't 0."""


class KernelRun:
    """One run of the kernel on one scene, from its start or from another state.

    `start` (n, START_COLUMNS): the other state of each ball; see `event_loop.play`.
    `t_max` [s]: end of the run; None: that of the scene.

    `t_end` [s]: time when the last ball came to rest, or the run stopped.
    `wall_time` [s]: run time of the kernel.
    `size`: number of balls.
    `variant`: the variant of the kernels that the scene needs.
    """

    def __init__(
        self,
        scene: Scene,
        keep_log: bool,
        off: frozenset[Skip] = frozenset(),
        *,
        start: st.FloatArray | None = None,
        t_max: float | None = None,
    ) -> None:
        layout = layout_of(scene, off)
        self._layout = layout = layout if t_max is None else layout.ending(t_max)
        self._scene, self._keep_log = scene, keep_log
        self.variant, self.size = layout.variant, layout.count
        self.status, self.reason = Status.FAILED, ""
        self.t_end = self.wall_time = 0.0
        self._counts: list[int] = []
        self._log = log_of(_FIRST_LOG, self.size, layout.columns) if keep_log else NO_LOG
        self._logs: list[Log] = []
        self._place = workplace_for(layout) if start is None else Workplace(layout, start)
        self._clock, self._counters = self._place.clock, self._place.counters

    @property
    def _state(self) -> st.FloatArray:
        """`Balls.state` at the present time of the run."""
        return self._place.memory[: self.size * STATE_COLUMNS].reshape(self.size, STATE_COLUMNS)

    def go(self, limits: Limits) -> None:
        """Run to the end or to a limit."""
        while True:
            self.play(limits)
            code = self._counters.item(st.STATUS)
            if code == st.RUN_LOG_FULL:
                self._start_new_log()
            elif code != st.RUN_PAUSED:
                break
        self.status = STATUS[code]
        self.t_end = self._clock.item(st.END)
        self._counts = self._counters[: st.COUNTERS].tolist()
        if not self.status.complete:
            self._say_why(code)
        self._check_resolved()

    def _say_why(self, code: int) -> None:
        """Set `reason`: why the run stopped early."""
        now = float(self._clock[st.NOW])
        if self.status in (Status.EVENT_LIMIT, Status.WORK_LIMIT):
            self.reason = f"{self._done()} by t = {now:.9g} s"
        elif self.status is Status.ENDLESS:
            self.reason = f"{self._endless(code)}. The run had {self._done()} by t = {now:.9g} s"
        elif self.status is Status.FAILED:
            self.reason = f"{self._invalid(code)} at t = {now:.9g} s"

    def _endless(self, code: int) -> str:
        """Return what repeats endlessly, and how to avoid it, for a message."""
        if code == st.RUN_STANDSTILL:
            elastic = _elastic_laws(self._scene.physics)
            loss = f", or make impacts lose energy: now {' and '.join(elastic)}" if elastic else ""
            return (
                f"the clock stands still: {self._counters[st.AT_ONCE]} events at one instant, "
                f"probably of balls that bounce in too little room. Give them room{loss}"
            )
        k = int(self._counters[st.ENDLESS]) - 1
        return (
            f'`balls[{k}]` ("{self._scene.balls[k].id}") lies on balls or cushions and bounces '
            "there. Set a `t_max` that ends the shot earlier"
        )

    def _done(self) -> str:
        """Return what a run has done so far, for a message."""
        done = self._counters
        return (
            f"{done[st.EVENTS]} events, {done[st.CONTACT_STEPS]} contact steps, "
            f"{done[st.BOUNDS]} bounds and {done[st.ADVANCEMENTS]} steps towards contacts "
            f"(work {done[st.WORK]})"
        )

    def _invalid(self, code: int) -> str:
        """Return which number isn't finite, or which memory was too small, in a failed run."""
        if code == st.RUN_NO_ROOM:
            return (
                "more balls touch than can lie side by side: they are hardly larger than the "
                "rounding of their coordinates. Move the scene to the origin. The run stopped"
            )
        k = int(self._counters[st.NOT_FINITE])
        if k == st.FREE:
            return "the time of the next event became NaN"
        ball = f'`balls[{k}]` ("{self._scene.balls[k].id}")'
        state = self._state[k]
        wrong = [
            f"{name} {tuple(state[columns].tolist())}"
            for name, columns in _MOTION.items()
            if not np.all(np.isfinite(state[columns]))
        ]
        if not math.isfinite(state[st.RADIUS]):
            wrong.append(f"radius of {state[st.RADIUS]}")
        if not wrong and state[st.OWN_TIME] >= self._clock[st.NOW]:
            return f"the search for contacts of {ball} doesn't end"
        if not wrong:
            return f"{ball} has its next event at {state[st.OWN_TIME]:.9g} s, not later than now"
        return f"{ball} has no finite motion ({', '.join(wrong)})"

    def play(self, limits: Limits, budget: int = WORK_AT_ONCE) -> None:
        """Continue the run for as much work as `budget`, or to the end; see the counter STATUS."""
        started = time.perf_counter()
        try:
            self._place.play(limits, self._log, budget)
        finally:
            self.wall_time += time.perf_counter() - started

    def _check_resolved(self) -> None:
        """Fail if a ball is so far away that double precision can't resolve a collision there."""
        farthest, smallest = self._clock.item(st.FARTHEST), self._layout.smallest_radius
        if self.status is not Status.FAILED and not position_rounding(farthest) < smallest:
            self.status = Status.FAILED
            self.reason = (
                f"a ball went {farthest:.3g} m away, where double precision can't tell positions "
                f"apart by a radius of {smallest:.3g} m. Set `t_max` to an earlier time, or slow "
                "the balls"
            )

    def _start_new_log(self) -> None:
        """Store the full log and continue with one of twice its size."""
        self._logs.append(self._trimmed_log())
        self._log = log_of(2 * len(self._log[0]), self.size, self._layout.columns)
        self._counters[[st.LOGGED_EVENTS, st.LOGGED_MOTIONS]] = 0

    def leave(self) -> None:
        """Let a next run of the scene use the memory of this run, which must not be read again."""
        self._place.leave()

    def final_state(self) -> Samples:
        """Return the state of every ball at `t_end`, arrays (1, n, 3)."""
        ends = self._place.shots.ends.copy()
        return Samples(ends[:, 0], ends[:, 1], ends[:, 2])

    def collision_counts(self) -> dict[str, int]:
        """Return the number of collisions by kind."""
        return {
            _BALL_BALL: self._counts[st.BALL_BALL],
            _BALL_CUSHION: self._counts[st.BALL_CUSHION],
        }

    def work(self) -> dict[str, int]:
        """Return machine-independent counters of the run; the last ones only if not 0."""
        counters = self._counts
        work = {
            "events": counters[st.EVENTS],
            "bounds": counters[st.BOUNDS],
            "advancement_steps": counters[st.ADVANCEMENTS],
            "cell_moves": counters[st.CELL_MOVES],
            "joint_impacts": counters[st.JOINT_IMPACTS],
            "unsolved_joint_impacts": counters[st.UNSOLVED_JOINT_IMPACTS],
            "contact_steps": counters[st.CONTACT_STEPS],
            "unsolved_contact_steps": counters[st.UNSOLVED_STEPS],
        }
        for name, column in _RARE_WORK.items():
            if counters[column]:
                work[name] = counters[column]
        return work

    def events(self) -> Events | None:
        """Return the event log, or None if the run has no log."""
        if not self._keep_log:
            return None
        time, what, _, _ = self._whole_log()
        events = np.empty(len(time), dtype=EVENT_DTYPE)
        events["t"] = time
        events["kind"], events["a"], events["b"] = what
        return events

    def trajectory(self) -> ExactTrajectory | None:
        """Return the motion between events, or None if the run has no log."""
        if not self._keep_log:
            return None
        _, _, ball, motion = self._whole_log()
        order = np.argsort(ball, kind="stable")
        ends = np.cumsum(np.bincount(ball, minlength=self.size))
        segments = np.split(motion[order], ends[:-1])
        spin_decelerations = self._state[:, st.SPIN_SLOWING].copy()
        return ExactTrajectory(
            self._layout.radii,
            tuple(segments),
            self.t_end,
            spin_decelerations,
            lifts=self.variant is Variant.FULL,
        )

    def _trimmed_log(self) -> Log:
        events, motions = self._counters[st.LOGGED_EVENTS], self._counters[st.LOGGED_MOTIONS]
        time, what, ball, motion = self._log
        return time[:events], what[:, :events], ball[:motions], motion[:motions]

    def _whole_log(self) -> Log:
        times, whats, balls, motions = zip(*self._logs, self._trimmed_log(), strict=True)
        return (
            np.concatenate(times),
            np.concatenate(whats, axis=1),
            np.concatenate(balls),
            np.concatenate(motions),
        )
