"""What a run keeps of what happened: counters always, a log where one was asked for."""

from __future__ import annotations

from engine.core.events import EventKind
from engine.core.kernel import kernel
from engine.core.state import (
    AX,
    AY,
    BX,
    BY,
    BZ,
    EPOCH,
    EVENTS,
    FREE,
    LAST_EVENT,
    LOGGED_EVENTS,
    LOGGED_MOTIONS,
    PHASE,
    VX,
    VY,
    WHAT_A,
    WHAT_B,
    WHAT_KIND,
    WX,
    WY,
    WZ,
    Balls,
    Contacts,
    Log,
    X,
    Y,
)

# Plain integers for the compiler.
BALL_BALL_EVENT = int(EventKind.BALL_BALL)
BALL_CUSHION_EVENT = int(EventKind.BALL_CUSHION)
SLIDE_TO_ROLL_EVENT = int(EventKind.SLIDE_TO_ROLL)
ROLL_TO_REST_EVENT = int(EventKind.ROLL_TO_REST)


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
        log.counters[LOGGED_MOTIONS] = row + 1
