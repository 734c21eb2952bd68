"""Recording of events and motions: counters always, a log if requested."""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Log, World
from ghostball.engine.impacts.impact import MOST_IN_CORNER
from ghostball.model.events import EventKind
from ghostball.model.trajectory.polynomial import PER_POWER

# Plain integers for the compiler.
BALL_BALL_EVENT = int(EventKind.BALL_BALL)
BALL_CUSHION_EVENT = int(EventKind.BALL_CUSHION)
SLIDE_TO_ROLL_EVENT = int(EventKind.SLIDE_TO_ROLL)
ROLL_TO_REST_EVENT = int(EventKind.ROLL_TO_REST)
POCKETED_EVENT = int(EventKind.POCKETED)
BALL_CLOTH_EVENT = int(EventKind.BALL_CLOTH)
LEAVES_TABLE_EVENT = int(EventKind.LEAVES_TABLE)


@kernel
def is_full(log: Log, n: int) -> bool:
    """Return whether the events of the next time might not fit in the log.

    Any ball may change its motion, start to roll and stop, and hit every ball that it touches:
    fewer than 3 n pairs in the plane. Besides, one ball may bounce many times in a corner.
    """
    if len(log.time) == 0:
        return False
    events_left = len(log.time) - log.counters[st.LOGGED_EVENTS]
    motions_left = len(log.ball) - log.counters[st.LOGGED_MOTIONS]
    return bool(events_left < 2 + 5 * n + MOST_IN_CORNER or motions_left < n)


@kernel
def note_ends(world: World, k: int, t: float) -> None:
    """Log that a contact step let ball k start to roll, or come to rest."""
    contacts = world.contacts
    if contacts.rolled[k]:
        contacts.rolled[k] = False
        note_event(SLIDE_TO_ROLL_EVENT, k, -1, t, world.log)
    if contacts.stopped[k]:
        contacts.stopped[k] = False
        note_rest(world, k, t)


@kernel
def note_rest(world: World, k: int, t: float) -> None:
    """Log that ball k came to rest, unless only contact steps have moved the ball since."""
    in_island = world.contacts.island[k] != st.FREE
    if not (in_island and world.balls.state[k].moved == 0.0):
        note_event(ROLL_TO_REST_EVENT, k, -1, t, world.log)
    world.log.clock[st.LAST_EVENT] = t
    world.balls.state[k].moved = 0.0


@kernel
def note_event(kind: int, a: int, b: int, t: float, log: Log) -> None:
    """Count an event, and log it if there is a log."""
    log.counters[st.EVENTS] += 1
    log.clock[st.LAST_EVENT] = t
    _count_outcome(kind, a, b, t, log)
    if len(log.time) > 0:
        row = log.counters[st.LOGGED_EVENTS]
        log.time[row] = t
        log.what[st.WHAT_KIND, row] = kind
        log.what[st.WHAT_A, row] = a
        log.what[st.WHAT_B, row] = b
        log.counters[st.LOGGED_EVENTS] = row + 1


@kernel
def _count_outcome(kind: int, a: int, b: int, t: float, log: Log) -> None:
    """Count an event in the outcomes of its balls; see `core.state`."""
    row = st.COUNTERS + st.OUTCOMES * a
    if kind == BALL_CUSHION_EVENT:
        log.counters[row + st.CUSHIONS] += 1
    elif kind == BALL_BALL_EVENT:
        _count_contact(row, b, log)
        _count_contact(st.COUNTERS + st.OUTCOMES * b, a, log)
    elif kind in (POCKETED_EVENT, LEAVES_TABLE_EVENT):
        log.counters[row + st.EXIT] = 1 + b if kind == POCKETED_EVENT else -1
        log.clock[st.CLOCKS + a] = t


@kernel(inline=True)
def _count_contact(row: int, partner: int, log: Log) -> None:
    """Keep the first ball that a ball hits, and how many cushion collisions it had before."""
    if log.counters[row + st.FIRST_CONTACT] == 0:
        log.counters[row + st.FIRST_CONTACT] = 1 + partner
        log.counters[row + st.CUSHIONS_BEFORE] = log.counters[row + st.CUSHIONS]


@kernel
def note_motion(world: World, i: int) -> None:
    """Log the motion of ball i from its epoch on."""
    balls, log = world.balls, world.log
    if len(log.time) > 0:
        row = log.counters[st.LOGGED_MOTIONS]
        log.ball[row] = i
        ball = balls.state[i]
        log.motion[row, st.EPOCH] = ball.epoch
        log.motion[row, st.X] = ball.x
        log.motion[row, st.Y] = ball.y
        log.motion[row, st.VX] = ball.vx
        log.motion[row, st.VY] = ball.vy
        log.motion[row, st.AX] = ball.ax
        log.motion[row, st.AY] = ball.ay
        log.motion[row, st.WX] = ball.wx
        log.motion[row, st.WY] = ball.wy
        log.motion[row, st.WZ] = ball.wz
        log.motion[row, st.BX] = ball.bx
        log.motion[row, st.BY] = ball.by
        log.motion[row, st.BZ] = ball.bz
        in_leg = balls.own_kind[i] == st.OWN_LEG
        log.motion[row, st.PHASE] = st.COMPRESSED if in_leg else ball.phase
        if balls.height is not None:
            for k, column in enumerate((st.RISE, st.UP_SPEED, st.FALL)):
                log.motion[row, st.SEGMENT_COLUMNS + k] = balls.height[i, column]
        if balls.powers is not None:
            first, size = st.SEGMENT_COLUMNS + 3, PER_POWER * int(balls.powers[i, st.COUNT])
            for k in range(log.motion.shape[1] - first):
                log.motion[row, first + k] = balls.powers[i, st.POWERS + k] if k < size else 0.0
        log.counters[st.LOGGED_MOTIONS] = row + 1


@kernel(inline=True)
def record(world: World, t: float) -> int:
    """Log the motion of every ball that changed at the time t [s], and the slides that end.

    Return RUN_CONTINUES, RUN_NO_ROOM or RUN_ENDLESS; or RUN_NOT_FINITE, with the ball in
    NOT_FINITE, if a motion isn't finite or its next event is in the past. The motions of all balls
    are then in the log.
    """
    balls, log = world.balls, world.log
    _sort_touched(balls)
    for m in range(1, balls.touched[0] + 1):
        k = balls.touched[m]
        if world.contacts.rolled[k] or world.contacts.stopped[k]:
            note_ends(world, k, t)
        note_motion(world, k)
        if not (balls.state[k].own_time >= t and is_finite(balls, k)):
            log.counters[st.NOT_FINITE] = k
    if log.counters[st.NOT_FINITE] != st.FREE:
        return st.RUN_NOT_FINITE
    if log.counters[st.ENDLESS] > 0:
        return st.RUN_ENDLESS
    return st.RUN_NO_ROOM if log.counters[st.NO_ROOM] > 0 else st.RUN_CONTINUES


@kernel(inline=True)
def is_finite(balls: Balls, i: int) -> bool:
    """Return whether all numbers of ball i's motion are finite.

    The test uses their sum, which isn't finite if one of the numbers isn't.
    """
    place = (balls.state[i].x + balls.state[i].y) + (balls.state[i].vx + balls.state[i].vy)
    spin = (balls.state[i].wx + balls.state[i].wy) + balls.state[i].wz
    pull = (balls.state[i].ax + balls.state[i].ay) + (balls.state[i].bx + balls.state[i].by)
    size = abs((place + spin) + (pull + balls.state[i].bz))
    if balls.height is not None:
        size += abs(balls.height[i, st.RISE] + balls.height[i, st.UP_SPEED])
    return bool(size < math.inf)


@kernel(inline=True)
def _sort_touched(balls: Balls) -> None:
    """Sort the balls that the event changed by their indices."""
    for m in range(2, balls.touched[0] + 1):
        k, index = balls.touched[m], m
        while index > 1 and balls.touched[index - 1] > k:
            balls.touched[index] = balls.touched[index - 1]
            index -= 1
        balls.touched[index] = k
