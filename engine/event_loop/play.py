"""Kernel that Python calls to simulate one or many shots of a scene.

Its arguments are arrays and numbers, because kernels take no tuples from Python; it unpacks them.
The arguments that differ from call to call come first, see `running.calls`.
"""

from __future__ import annotations

from typing import Any

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import COMPILED, kernel
from ghostball.engine.core.rows import OBSTACLE, ObstacleRow, rows_of
from ghostball.engine.core.state import (
    Balls,
    FloatArray,
    IntArray,
    Laws,
    Log,
    World,
)
from ghostball.engine.event_loop.finish import finish
from ghostball.engine.event_loop.loop import run
from ghostball.engine.event_loop.unpack import (
    balls_in,
    cells_in,
    contacts_from,
    pairs_in,
    start_from,
)

# Columns of the initial state of a ball, for shots of one scene with different initial states.
START_X = 0  # position of its centre [m]
START_Y = 1
START_RISE = 2  # height of its lowest point above the cloth [m]
START_VX = 3  # its velocity [m/s]
START_VY = 4
START_UP = 5
START_WX = 6  # its angular velocity [rad/s]
START_WY = 7
START_WZ = 8
START_PHASE = 9  # SLIDING, ROLLING or FLYING
START_COLUMNS = 10


@kernel(entry=True)
def play(
    which: IntArray,
    starts: FloatArray,
    clocks: FloatArray,
    counts: IntArray,
    ends: FloatArray,
    time: FloatArray,
    what: IntArray,
    ball: IntArray,
    motion: FloatArray,
    numbers: FloatArray,
    first: int,
    continues: bool,
    who: int,
    max_events: int,
    max_work: int,
    budget: int,
    start: FloatArray,
    offsets: IntArray,
    full: int | None,
    laws: FloatArray,
    obstacles: FloatArray,
) -> int:
    """Simulate the shots `which`, from element `first` on; return the index of the next element.

    `which` (m,) int64: the shots to simulate, as rows of the next four arrays.
    `starts` (k, m, START_COLUMNS) float64: the initial states of m balls in each shot, from ball
        `who` on. If k is 0, all shots have the initial state of the scene.
    `clocks` (k, CLOCKS + n) float64: times of each shot, and when each ball left the table.
    `counts` (k, COUNTERS + OUTCOMES n) int64: counters of each shot, and the outcomes of each ball;
        STATUS tells how the shot ended.
    `ends` (k, p, n, 3) float64: final positions of each shot; velocities if p > 1, angular
        velocities if p > 2.
    `time`, `what`, `ball`, `motion`: the `Log`, if there is only one shot; empty for no log.
    `numbers`, `start`, `offsets`: a block of arrays to work in, the block with the initial state,
        and their offsets: `core.block`. `full` is None if `Balls` has no `powers`, `series` and
        `height`; from its type numba knows which code to leave out.
    `continues`: True if the shot `which[first]` was interrupted and continues; False if it starts.
    `max_events`, `max_work`: limits of a shot: events and contact steps; WORK.
    `budget`: WORK after which the kernel returns, so that interrupts are handled. A shot with the
        status RUN_PAUSED or RUN_LOG_FULL continues when called again.
    `laws`, `obstacles`: the `Laws`.

    Contract: no allocation, no raising. Each shot starts with the same numbers, so the results
    don't depend on the order of the shots, or on the threads.
    """
    lines = obstacles.view(OBSTACLE)[:, 0] if COMPILED else rows_of(obstacles, ObstacleRow)
    rules = laws_from(laws, lines)
    contacts = contacts_from(numbers, offsets)
    pairs, cells = pairs_in(numbers, offsets), cells_in(numbers, offsets)
    left = budget
    for m in range(first, len(which)):
        k = which[m]
        counters = counts[k]
        balls = balls_in(numbers, offsets, counters, full)
        log = Log(clocks[k], counters, time, what, ball, motion)
        world = World(balls, rules, pairs, cells, contacts, log)
        if m > first or not continues:
            start_from(numbers, start, offsets)
            log.clock[:] = 0.0
            counters[:] = 0
            if len(starts) > 0:
                _begin(balls, who, starts[k])
        before = counters[st.WORK]
        counters[st.PAUSE_AT] = min(before + left, max_work)
        status = run(world, max_events)
        if status == st.RUN_PAUSED and counters[st.WORK] >= max_work:
            status = st.RUN_WORK_LIMIT
        counters[st.STATUS] = status
        if status in (st.RUN_PAUSED, st.RUN_LOG_FULL):
            return m
        counters[st.STATUS] = finish(world, status, ends[k])
        left -= counters[st.WORK] - before
        if left <= 0:
            return m + 1
    return len(which)


@kernel(inline=True)
def _begin(balls: Balls, who: int, starts: FloatArray) -> None:
    """Set the initial positions, velocities and phases of balls."""
    for j in range(len(starts)):
        ball = balls.state[who + j]
        ball.x, ball.y = starts[j, START_X], starts[j, START_Y]
        ball.vx, ball.vy = starts[j, START_VX], starts[j, START_VY]
        ball.wx, ball.wy, ball.wz = starts[j, START_WX], starts[j, START_WY], starts[j, START_WZ]
        ball.phase = starts[j, START_PHASE]
        if balls.height is not None:
            balls.height[who + j, st.RISE] = starts[j, START_RISE]
            balls.height[who + j, st.UP_SPEED] = starts[j, START_UP]


@kernel(inline=True)
def laws_from(numbers: FloatArray, obstacles: Any) -> Laws:
    """Return the `Laws` with the fields `numbers`, and the obstacles."""
    return Laws(
        numbers[0] != 0.0,
        numbers[1] != 0.0,
        numbers[2] != 0.0,
        int(numbers[3]),
        numbers[4],
        numbers[5],
        numbers[6] != 0.0,
        numbers[7],
        numbers[8],
        numbers[9] != 0.0,
        numbers[10],
        numbers[11],
        numbers[12],
        int(numbers[13]),
        numbers[14],
        numbers[15],
        numbers[16] != 0.0,
        numbers[17],
        numbers[18],
        obstacles,
    )
