"""The kernel that Python calls to run one shot: it unpacks plain arrays, and calls the loop.

Named tuples would cost a call from Python microseconds. Many shots have `event_loop.sweep`.
"""

from __future__ import annotations

from typing import Any

from ghostball.engine.core.kernel import COMPILED, kernel
from ghostball.engine.core.state import (
    BALL,
    OBSTACLE,
    RUN_CONTACTS,
    RUN_EVENT_LIMIT,
    RUN_LOG_FULL,
    Air,
    BallRow,
    Balls,
    BoolArray,
    Cells,
    FloatArray,
    Int32Array,
    IntArray,
    Laws,
    Log,
    ObstacleRow,
    Pairs,
    contacts_in,
    rows_of,
)
from ghostball.engine.event_loop.finish import finish
from ghostball.engine.event_loop.loop import run


@kernel(entry=True)
def enter(
    state: FloatArray,
    own_kind: IntArray,
    changed: BoolArray,
    touched: Int32Array,
    hits: Int32Array,
    near: Int32Array,
    higher: FloatArray | None,
    air: Air | None,
    height: FloatArray | None,
    laws: FloatArray,
    obstacles: FloatArray,
    integrated: int | None,
    bound: FloatArray,
    least: FloatArray,
    next_event: FloatArray,
    track: FloatArray,
    cells: Cells | None,
    room: tuple[BoolArray, IntArray, FloatArray] | None,
    clock: FloatArray,
    counters: IntArray,
    time: FloatArray,
    what: IntArray,
    ball: IntArray,
    motion: FloatArray,
    end: FloatArray,
    limit: int,
    last: bool,
) -> int:
    """Run, as `loop.run`; and where that is over, bring all balls to the end, as `loop.finish`.

    It is over, too, where `limit` is reached and `last` is true.
    """
    rows = state.view(BALL)[:, 0] if COMPILED else rows_of(state, BallRow)
    balls = Balls(rows, own_kind, changed, touched, hits, near, higher, air, height)
    lines = obstacles.view(OBSTACLE)[:, 0] if COMPILED else rows_of(obstacles, ObstacleRow)
    numbers = laws_from(laws, lines, integrated)
    contacts = None if room is None else contacts_from(*room)
    log = Log(clock, counters, time, what, ball, motion)
    if cells is None:
        pairs = Pairs(bound, least, next_event, track)
        status = run(balls, numbers, pairs, None, contacts, log, limit)
    else:
        status = run(balls, numbers, None, cells, contacts, log, limit)
    goes_on = status == RUN_LOG_FULL or status == RUN_CONTACTS  # noqa: PLR1714 - the compiler
    if goes_on or (status == RUN_EVENT_LIMIT and not last):
        return status
    return finish(balls, numbers, log, status, end)


contacts_from = kernel(inline=True)(contacts_in)


@kernel(inline=True)
def laws_from(numbers: FloatArray, obstacles: Any, integrated: int | None) -> Laws:
    """Return the `Laws` whose fields are `numbers`, and the other two."""
    return Laws(
        numbers[0] != 0.0,
        numbers[1] != 0.0,
        numbers[2] != 0.0,
        numbers[3] != 0.0,
        int(numbers[4]),
        numbers[5],
        numbers[6],
        numbers[7] != 0.0,
        numbers[8] != 0.0,
        numbers[9],
        numbers[10],
        numbers[11],
        numbers[12],
        numbers[13],
        numbers[14],
        numbers[15] != 0.0,
        numbers[16],
        numbers[17],
        numbers[18],
        obstacles,
        integrated,
    )
