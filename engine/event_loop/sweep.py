"""Many shots of one scene in one kernel call: no Python in between."""

from __future__ import annotations

import math
from typing import NamedTuple

from ghostball.engine.core.kernel import COMPILED, kernel
from ghostball.engine.core.state import (
    BALL,
    BALL_BALL,
    BALL_CUSHION,
    CONTACT_STEPS,
    END,
    EVENTS,
    FARTHEST,
    FREE,
    NOWHERE,
    OBSTACLE,
    ROLLING,
    RUN_CONTACTS,
    RUN_EVENT_LIMIT,
    SLIDING,
    STATE_COLUMNS,
    BallRow,
    Balls,
    BoolArray,
    Cells,
    Contacts,
    FloatArray,
    IntArray,
    Log,
    ObstacleRow,
    Pairs,
    rows_of,
)
from ghostball.engine.event_loop.entry import laws_from
from ghostball.engine.event_loop.finish import finish
from ghostball.engine.event_loop.loop import run


class Shots(NamedTuple):
    """What differs between the k shots of a sweep, and what becomes of each."""

    velocity: FloatArray  # (k, 2) of the cue ball [m/s]
    spin: FloatArray  # (k, 3) its angular velocity [rad/s]
    slides: BoolArray  # (k,) whether that is a state of its own, or rolling without slip
    status: IntArray  # (k,) what `event_loop.loop.run` returned
    rest_time: FloatArray  # (k,) [s]
    rest: FloatArray  # (k, n, 3) positions at the end [m]
    counts: IntArray  # (k, 3) impacts of two balls, impacts on cushions, all events
    farthest: FloatArray  # (k,) largest coordinate of a ball at the end [m]


@kernel(entry=True)
def sweep(
    which: IntArray,
    cue: int,
    shots: Shots,
    limit: int,
    at_once: int,
    stop: BoolArray,
    start: FloatArray,
    numbers: FloatArray,
    obstacles: FloatArray,
    integrated: int | None,
    room: Balls,
    pairs: Pairs,
    cells: Cells | None,
    contacts: Contacts | None,
    log: Log,
    end: FloatArray,
) -> None:
    """Simulate the shots `which`; `start` is the state of all balls but for ball `cue`'s motion.

    After each `at_once` events it looks whether `stop`, (1,), was set: then it leaves off.
    The rest is room to work in, a thread's own. A shot that needs `contacts` and has none is left
    with the status RUN_CONTACTS.

    Contract: no allocation. Each shot starts from the same state of that room, so that neither
    their order nor who does them matters.
    """
    lines = obstacles.view(OBSTACLE)[:, 0] if COMPILED else rows_of(obstacles, ObstacleRow)
    laws = laws_from(numbers, lines, integrated)
    rows = room.state.view(BALL)[:, 0] if COMPILED else rows_of(room.state, BallRow)
    balls = Balls(
        rows,
        room.own_kind,
        room.changed,
        room.touched,
        room.hits,
        room.near,
        room.higher,
        room.air,
        room.height,
    )
    for m in range(len(which)):
        k = which[m]
        _clear(balls, log)
        if contacts is not None:
            _clear_contacts(contacts)
        for i in range(len(start)):
            for column in range(STATE_COLUMNS):
                room.state[i, column] = start[i, column]
        balls.state[cue].vx = shots.velocity[k, 0]
        balls.state[cue].vy = shots.velocity[k, 1]
        balls.state[cue].wx = shots.spin[k, 0]
        balls.state[cue].wy = shots.spin[k, 1]
        balls.state[cue].wz = shots.spin[k, 2]
        balls.state[cue].phase = SLIDING if shots.slides[k] else ROLLING
        if cells is None:
            _clear_pairs(pairs)
        else:
            _clear_cells(cells)
        status = RUN_EVENT_LIMIT
        done = 0
        while status == RUN_EVENT_LIMIT and done < limit:
            if stop[0]:
                return
            until = min(done + at_once, limit)
            if cells is None:
                status = run(balls, laws, pairs, None, contacts, log, until)
            else:
                status = run(balls, laws, None, cells, contacts, log, until)
            done = log.counters[EVENTS] + log.counters[CONTACT_STEPS]
        if status != RUN_CONTACTS:
            status = finish(balls, laws, log, status, end)
        shots.status[k] = status
        shots.rest_time[k] = log.clock[END]
        shots.counts[k, 0] = log.counters[BALL_BALL]
        shots.counts[k, 1] = log.counters[BALL_CUSHION]
        shots.counts[k, 2] = log.counters[EVENTS]
        shots.farthest[k] = log.clock[FARTHEST]
        for i in range(len(balls.own_kind)):
            for axis in range(3):
                shots.rest[k, i, axis] = end[0, i, axis]


@kernel
def _clear(balls: Balls, log: Log) -> None:
    """Mark all balls, as at the start of a run, and forget all counts."""
    n = len(balls.own_kind)
    balls.touched[0] = n
    for i in range(n):
        balls.touched[1 + i] = i
        balls.changed[i] = True
    log.clock[:] = 0.0
    log.counters[:] = 0


@kernel
def _clear_pairs(pairs: Pairs) -> None:
    pairs.bound[:] = math.inf
    pairs.least[:] = math.inf
    pairs.next[:] = math.inf


@kernel
def _clear_cells(cells: Cells) -> None:
    cells.first[:] = NOWHERE
    cells.link[:] = 0
    cells.tree[:] = math.inf


@kernel
def _clear_contacts(contacts: Contacts) -> None:
    """Forget all clusters and forces; nothing is held after that."""
    for i in range(len(contacts.cluster)):
        contacts.cluster[i] = FREE
        contacts.ring[i] = i
        contacts.first_held[i] = NOWHERE
    contacts.again[:] = False
    contacts.waiting[0] = 0
    contacts.stopped[:] = False
    contacts.rolled[:] = False
    contacts.free[0] = len(contacts.held)
    for row in range(len(contacts.held)):
        contacts.free[1 + row] = row
    contacts.motion[:] = 0.0
