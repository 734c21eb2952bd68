"""What a run keeps of what happened: counters always, a log where one was asked for."""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    AX,
    AY,
    BX,
    BY,
    BZ,
    EPOCH,
    EVENTS,
    FALL,
    FREE,
    HIGHER,
    HOPPING,
    KNOT,
    LAST_EVENT,
    LOGGED_EVENTS,
    LOGGED_MOTIONS,
    NO_ROOM,
    PHASE,
    POWERS,
    RISE,
    RUN_GOES_ON,
    RUN_HOPS,
    RUN_NO_ROOM,
    RUN_NOT_FINITE,
    UNSOUND,
    UP_SPEED,
    VX,
    VY,
    WHAT_A,
    WHAT_B,
    WHAT_KIND,
    WX,
    WY,
    WZ,
    Air,
    Balls,
    Contacts,
    FloatArray,
    Log,
    X,
    Y,
)
from ghostball.model.events import EventKind

# Plain integers for the compiler.
BALL_BALL_EVENT = int(EventKind.BALL_BALL)
BALL_CUSHION_EVENT = int(EventKind.BALL_CUSHION)
SLIDE_TO_ROLL_EVENT = int(EventKind.SLIDE_TO_ROLL)
ROLL_TO_REST_EVENT = int(EventKind.ROLL_TO_REST)
BALL_GONE_EVENT = int(EventKind.BALL_GONE)
BALL_CLOTH_EVENT = int(EventKind.BALL_CLOTH)
LEAVES_TABLE_EVENT = int(EventKind.LEAVES_TABLE)


@kernel
def is_full(log: Log, n: int) -> bool:
    """Whether the next instant might not fit in the log: any ball may change, roll and stop.

    And hit each pair that can touch at once: fewer than 3 n in the plane.
    """
    if len(log.time) == 0:
        return False
    events_left = len(log.time) - log.counters[LOGGED_EVENTS]
    motions_left = len(log.ball) - log.counters[LOGGED_MOTIONS]
    return bool(events_left < 2 + 5 * n or motions_left < n)


@kernel
def note_ends(balls: Balls, contacts: Contacts, k: int, t: float, log: Log) -> None:
    """Log that ball k came to roll or to rest by a contact step."""
    if contacts.rolled[k]:
        contacts.rolled[k] = False
        note_event(SLIDE_TO_ROLL_EVENT, k, -1, t, log)
    if contacts.stopped[k]:
        contacts.stopped[k] = False
        note_rest(balls, contacts, k, t, log)


@kernel
def note_rest(balls: Balls, contacts: Contacts | None, k: int, t: float, log: Log) -> None:
    """Log that ball k came to rest; but not again after what a contact step let it creep."""
    creeps = False
    if contacts is not None:
        creeps = contacts.cluster[k] != FREE and balls.state[k].moved == 0.0
    if not creeps:
        note_event(ROLL_TO_REST_EVENT, k, -1, t, log)
    log.clock[LAST_EVENT] = t
    balls.state[k].moved = 0.0


@kernel
def note_event(kind: int, a: int, b: int, t: float, log: Log) -> None:
    """Count an event, and log it."""
    log.counters[EVENTS] += 1
    log.clock[LAST_EVENT] = t
    if len(log.time) > 0:
        row = log.counters[LOGGED_EVENTS]
        log.time[row] = t
        log.what[WHAT_KIND, row] = kind
        log.what[WHAT_A, row] = a
        log.what[WHAT_B, row] = b
        log.counters[LOGGED_EVENTS] = row + 1


@kernel
def note_motion(balls: Balls, i: int, log: Log) -> None:
    """Log how ball i moves from its epoch on."""
    if len(log.time) > 0:
        row = log.counters[LOGGED_MOTIONS]
        log.ball[row] = i
        ball = balls.state[i]
        log.motion[row, EPOCH] = ball.epoch
        log.motion[row, X] = ball.x
        log.motion[row, Y] = ball.y
        log.motion[row, VX] = ball.vx
        log.motion[row, VY] = ball.vy
        log.motion[row, AX] = ball.ax
        log.motion[row, AY] = ball.ay
        log.motion[row, WX] = ball.wx
        log.motion[row, WY] = ball.wy
        log.motion[row, WZ] = ball.wz
        log.motion[row, BX] = ball.bx
        log.motion[row, BY] = ball.by
        log.motion[row, BZ] = ball.bz
        log.motion[row, PHASE] = ball.phase
        _note_height(balls.height, i, log.motion, row)
        _note_higher(balls.higher, balls.air, _columns_of(balls.height), i, log.motion, row)
        log.counters[LOGGED_MOTIONS] = row + 1


@kernel(inline=True)
def _columns_of(height: FloatArray | None) -> int:
    """Return after how many numbers of a motion its higher powers come."""
    return KNOT if height is None else KNOT + 3


@kernel(inline=True)
def _note_height(height: FloatArray | None, i: int, motion: FloatArray, row: int) -> None:
    if height is not None:
        for k, column in enumerate((RISE, UP_SPEED, FALL)):
            motion[row, KNOT + k] = height[i, column]


@kernel(inline=True)
def _note_higher(
    higher: FloatArray | None,
    air: Air | None,
    first: int,
    i: int,
    motion: FloatArray,
    row: int,
) -> None:
    if higher is not None:
        room, count = higher.shape[1] - HIGHER, 2 * int(higher[i, POWERS])
        for k in range(room):
            motion[row, first + k] = higher[i, HIGHER + k] if k < count else 0.0
        if air is not None:
            for k in range(room):
                motion[row, first + room + k] = air.turning[i, k] if k < count else 0.0


@kernel(inline=True)
def record(balls: Balls, contacts: Contacts | None, t: float, log: Log) -> int:
    """Log how every ball moves on whose motion changed at the instant t, and what a step ended.

    Return RUN_GOES_ON; or RUN_NOT_FINITE, with the ball in UNSOUND, where a motion isn't finite or
    its next event is past: after each ball has its motion in the log; or RUN_NO_ROOM; or RUN_HOPS.
    """
    _sort_touched(balls)
    for m in range(1, balls.touched[0] + 1):
        k = balls.touched[m]
        if contacts is not None:
            note_ends(balls, contacts, k, t, log)
        note_motion(balls, k, log)
        if not (balls.state[k].own_time >= t and is_sound(balls, k)):
            log.counters[UNSOUND] = k
    if log.counters[UNSOUND] != FREE:
        return RUN_NOT_FINITE
    if log.counters[HOPPING] > 0:
        return RUN_HOPS
    return RUN_NO_ROOM if log.counters[NO_ROOM] > 0 else RUN_GOES_ON


@kernel(inline=True)
def is_sound(balls: Balls, i: int) -> bool:
    """Whether no number of ball i's motion is NaN or infinite: a sum of such is never finite."""
    place = (balls.state[i].x + balls.state[i].y) + (balls.state[i].vx + balls.state[i].vy)
    spin = (balls.state[i].wx + balls.state[i].wy) + balls.state[i].wz
    pull = (balls.state[i].ax + balls.state[i].ay) + (balls.state[i].bx + balls.state[i].by)
    size = abs((place + spin) + (pull + balls.state[i].bz))
    return bool(_with_height(balls.height, i, size) < math.inf)


@kernel(inline=True)
def _with_height(height: FloatArray | None, i: int, size: float) -> float:
    return size if height is None else size + abs(height[i, RISE] + height[i, UP_SPEED])


@kernel(inline=True)
def _sort_touched(balls: Balls) -> None:
    """Put the balls that the event touched in the order of their numbers."""
    for m in range(2, balls.touched[0] + 1):
        k, place = balls.touched[m], m
        while place > 1 and balls.touched[place - 1] > k:
            balls.touched[place] = balls.touched[place - 1]
            place -= 1
        balls.touched[place] = k
