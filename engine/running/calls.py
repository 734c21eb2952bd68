"""Calls of the kernels, and the memory in which a thread simulates one shot after the other.

A single shot, a batch and a sweep use the same code; they differ in how they make the shots.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import Event
from typing import NamedTuple

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.block import END
from ghostball.engine.event_loop.play import START_COLUMNS, play
from ghostball.engine.library.entry import Needed
from ghostball.engine.running.from_scene import SceneLayout, log_of
from ghostball.model.events import Status

WORK_AT_ONCE = 5_000_000
"""Work between two returns from the kernel: about 50 ms, so that interrupts are handled in time."""

STATUS = {
    st.RUN_RESTED: Status.REST,
    st.RUN_T_MAX: Status.T_MAX,
    st.RUN_EVENT_LIMIT: Status.EVENT_LIMIT,
    st.RUN_WORK_LIMIT: Status.WORK_LIMIT,
    st.RUN_ENDLESS: Status.ENDLESS,
    st.RUN_NOT_FINITE: Status.FAILED,
    st.RUN_STANDSTILL: Status.ENDLESS,
    st.RUN_NO_ROOM: Status.FAILED,
}
"""Status of a shot for each final value of the counter STATUS."""


class Limits(NamedTuple):
    """Limits on the cost of a shot, after which it is stopped."""

    events: int  # events and contact steps
    work: int  # iterations of all loops, in units of about 6 ns


class Shots(NamedTuple):
    """The initial states of k shots of a scene, and their results."""

    starts: st.FloatArray  # (k, m, START_COLUMNS); k = 0: each shot starts as in the scene
    clocks: st.FloatArray  # (k, CLOCKS + n)
    counts: st.IntArray  # (k, COUNTERS + OUTCOMES n)
    ends: st.FloatArray  # (k, p, n, 3) the first p of: positions, velocities, angular velocities


def shots_of(k: int, n: int, arrays: int) -> Shots:
    """Return arrays for k shots of n balls, with the first `arrays` of the arrays in `ends`."""
    return Shots(
        _NO_STARTS,
        np.zeros((k, st.CLOCKS + n)),
        np.zeros((k, st.COUNTERS + st.OUTCOMES * n), dtype=np.int64),
        np.empty((k, arrays, n, 3)),
    )


_NO_STARTS = np.empty((0, 0, START_COLUMNS))

Log = tuple[st.FloatArray, st.IntArray, st.IntArray, st.FloatArray]

NO_LOG: Log = log_of(0, 0)
"""The log of shots whose events are not recorded."""


def memory_for(layout: SceneLayout) -> st.FloatArray:
    """Return memory for one shot of a scene at a time: the block of its arrays, see `core.block`.

    Shots of other scenes can use it too, if it is large enough.
    """
    return np.empty(layout.block.offsets[END])


def play_some(
    layout: SceneLayout,
    memory: st.FloatArray,
    shots: Shots,
    which: st.IntArray,
    first: int,
    continues: bool,
    log: Log,
    limits: Limits,
    budget: int = WORK_AT_ONCE,
    *,
    who: int = 0,
) -> int:
    """Simulate shots, see `event_loop.play.play`; return the index of the next in `which`."""
    numbers = (first, continues, who, *limits, budget)
    return int(play(which, *shots, *log, memory, *numbers, *layout.arguments))


class Workplace:
    """Memory and arrays for one shot of a scene at a time, and the call that plays a shot there.

    A layout keeps the workplaces of finished shots for its next shots. Otherwise each shot would
    allocate the arrays and pack the arguments again.
    """

    __slots__ = ("_call", "_of", "clock", "counters", "layout", "memory", "shots")

    def __init__(self, layout: SceneLayout, start: st.FloatArray | None = None) -> None:
        self.layout, self.memory = layout, memory_for(layout)
        self.shots = shots_of(1, layout.count, 3)
        if start is not None:
            self.shots = self.shots._replace(starts=np.ascontiguousarray(start[np.newaxis]))
        self.clock, self.counters = self.shots.clocks[0], self.shots.counts[0]
        self.counters[st.STATUS] = st.RUN_CONTINUES
        self._call: Callable[[], int] | None = None
        self._of: tuple[Limits, int] | None = None

    def play(self, limits: Limits, log: Log, budget: int) -> None:
        """Begin or continue the shot, for as much work as `budget`; see the counter STATUS."""
        begun = self.counters.item(st.STATUS) != st.RUN_CONTINUES
        if begun or log is not NO_LOG:
            play_some(self.layout, self.memory, self.shots, _FIRST, 0, begun, log, limits, budget)
            return
        if self._call is None or self._of != (limits, budget):
            numbers = (0, False, 0, *limits, budget)
            arguments = (*self.shots, *NO_LOG, self.memory, *numbers, *self.layout.arguments)
            self._call, self._of = play.bind(_FIRST, *arguments), (limits, budget)
        self._call()

    def leave(self) -> None:
        """Keep the workplace for a next shot of the scene, unless its memory is large."""
        if self.memory.size <= _KEPT_NUMBERS:
            self.counters[st.STATUS] = st.RUN_CONTINUES
            self.layout.idle.append(self)


_FIRST = np.zeros(1, dtype=np.int64)
_FIRST.flags.writeable = False

_KEPT_NUMBERS = 2**16
"""Largest number of doubles in the memory of a kept workplace: half a megabyte, some 100 balls."""


def workplace_for(layout: SceneLayout) -> Workplace:
    """Return a workplace that no other thread uses: one that was left, or a new one."""
    try:
        left: Workplace = layout.idle.pop()
    except IndexError:
        return Workplace(layout)
    return left


def play_all(
    layout: SceneLayout,
    memory: st.FloatArray,
    shots: Shots,
    which: st.IntArray,
    limits: Limits,
    *,
    who: int = 0,
    stop: Event | None = None,
) -> None:
    """Simulate the shots `which` to their ends, without a log, and put the results in `shots`.

    `who`: the ball to which the first of `shots.starts` belongs.
    `stop`: when another thread sets this event, the loop ends after its next return from the
        kernel, and the remaining shots aren't simulated.
    """
    first, continues = 0, False
    while first < len(which) and not (stop is not None and stop.is_set()):
        first = play_some(layout, memory, shots, which, first, continues, NO_LOG, limits, who=who)
        # The kernel also returns between two shots; then the next one has no status yet.
        continues = first < len(which) and shots.counts[which[first], st.STATUS] == st.RUN_PAUSED


def needed(layout: SceneLayout, name: str) -> Needed:
    """Return the kernel that shots of a scene need, for compiling, with its `name` in messages."""
    shots, none = shots_of(0, 0, 0), np.empty(0, dtype=np.int64)
    numbers = (0, False, 0, 0, 0, 0)
    arguments = (none, *shots, *NO_LOG, np.empty(0), *numbers, *layout.arguments)
    return Needed(play, arguments, name)
