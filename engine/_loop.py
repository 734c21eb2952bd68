"""The event loop: find the earliest event, move its balls there, resolve it, predict anew."""

from __future__ import annotations

import math

from engine._geometry import (
    at_rest,
    blocking_ball,
    contact_tolerance,
    cushion_side,
    negligible_hop,
)
from engine._impact import bounce, collide_balls
from engine._jit import kernel
from engine._motion import advance, come_to_rest, predict_motion
from engine._pairs import IMPACT, NOT_YET, earliest, touching, update_ball
from engine._press import press, release
from engine._state import (
    AX,
    AY,
    BALL_BALL,
    BALL_CUSHION,
    CONTACT_STEPS,
    EPOCH,
    EVENTS,
    LAST_EVENT,
    LOGGED_EVENTS,
    LOGGED_MOTIONS,
    NOW,
    OWN_CONTACT,
    OWN_CUSHION,
    OWN_REST,
    OWN_TIME,
    REST,
    RUN_EVENT_LIMIT,
    RUN_LOG_FULL,
    RUN_NOT_FINITE,
    RUN_RESTED,
    RUN_T_MAX,
    STEP,
    VX,
    VY,
    WHAT_A,
    WHAT_B,
    WHAT_KIND,
    Balls,
    Contacts,
    FloatArray,
    IntArray,
    Laws,
    Log,
    Pairs,
    X,
    Y,
)
from engine.result import EventKind

# Plain integers for the compiler.
_BALL_BALL = int(EventKind.BALL_BALL)
_BALL_CUSHION = int(EventKind.BALL_CUSHION)
_ROLL_TO_REST = int(EventKind.ROLL_TO_REST)


@kernel
def start(balls: Balls, laws: Laws, contacts: Contacts, pairs: Pairs, counters: IntArray) -> None:
    """Predict every ball and bound every pair at t = 0; once, before `run`."""
    n = len(balls.own_kind)
    for i in range(n):
        predict_motion(balls, i, laws)
    for i in range(n):
        update_ball(balls, contacts.held, pairs, i, 0.0, counters)


@kernel
def run(
    balls: Balls,
    laws: Laws,
    contacts: Contacts,
    pairs: Pairs,
    log: Log,
    keep_log: bool,
    clock: FloatArray,
    counters: IntArray,
    limit: int,
) -> int:
    """Process events until every ball rests, `t_max`, a full log, or `limit` events and steps.

    Returns one of RUN_RESTED, RUN_T_MAX, RUN_EVENT_LIMIT, RUN_LOG_FULL, RUN_NOT_FINITE.

    Contract: no allocation, no raising. Everything is in the arguments, so a run that returned
    RUN_LOG_FULL or RUN_EVENT_LIMIT goes on where it stopped when called again.
    """
    while True:
        if keep_log and _full(log, counters, len(balls.own_kind)):
            return RUN_LOG_FULL

        # Find the earliest event: one ball's own, or the pair that may touch first.
        single = _earliest_own(balls)
        t = min(balls.state[OWN_TIME, single], earliest(pairs))
        if not t >= clock[NOW]:
            return RUN_NOT_FINITE
        if t == math.inf and _all_rest(balls):
            return RUN_RESTED
        if t > laws.t_max:
            return RUN_T_MAX
        if counters[EVENTS] + counters[CONTACT_STEPS] >= limit:
            return RUN_EVENT_LIMIT

        # Move its balls there and resolve it; mark every ball whose motion it changes.
        if balls.state[OWN_TIME, single] <= t:
            _resolve_own(balls, laws, contacts, single, t, clock, counters, log, keep_log)
        else:
            verdict, i, j = touching(balls, laws, pairs, t, counters)
            if verdict == NOT_YET:
                continue
            if verdict == IMPACT:
                _resolve_pair(balls, laws, contacts, i, j, t, clock, counters, log, keep_log)
            else:
                press(balls, laws, contacts, i, j, t, counters)
        clock[NOW] = t

        # Predict anew: every bound of a ball whose motion changed is void.
        for k in range(len(balls.own_kind)):
            if contacts.changed[k]:
                contacts.changed[k] = False
                if contacts.stopped[k]:
                    contacts.stopped[k] = False
                    counters[REST] += 1
                    _note_event(_ROLL_TO_REST, k, -1, t, clock, counters, log, keep_log)
                if keep_log:
                    _note_motion(balls, k, counters, log)
                update_ball(balls, contacts.held, pairs, k, t, counters)


@kernel
def finish(balls: Balls, t: float) -> None:
    """Move every ball that still moves to the instant t [s], where the run stopped."""
    for i in range(len(balls.own_kind)):
        if not at_rest(balls, i):
            advance(balls, i, t)


@kernel
def _all_rest(balls: Balls) -> bool:
    for i in range(len(balls.own_kind)):  # noqa: SIM110 - the compiler takes no generator
        if not at_rest(balls, i):
            return False
    return True


@kernel
def _earliest_own(balls: Balls) -> int:
    """Return the ball whose own event comes first; of several at one instant, one coming to rest.

    So a ball that has all but stopped is at rest before its neighbours are looked at again.
    """
    best = 0
    for i in range(1, len(balls.own_kind)):
        earlier = balls.state[OWN_TIME, i] < balls.state[OWN_TIME, best]
        tie = balls.state[OWN_TIME, i] == balls.state[OWN_TIME, best]
        if earlier or (tie and balls.own_kind[i] < balls.own_kind[best]):
            best = i
    return best


@kernel
def _resolve_own(
    balls: Balls,
    laws: Laws,
    contacts: Contacts,
    i: int,
    t: float,
    clock: FloatArray,
    counters: IntArray,
    log: Log,
    keep_log: bool,
) -> None:
    """Resolve what ball i does alone at the instant t: rest, meet a cushion, end a contact step."""
    kind = balls.own_kind[i]
    if kind == OWN_REST:
        come_to_rest(balls, i, t)
        counters[REST] += 1
        _note_event(_ROLL_TO_REST, i, -1, t, clock, counters, log, keep_log)
    elif kind != OWN_CONTACT:
        cushion = kind - OWN_CUSHION
        advance(balls, i, t)
        blocking = _wedging_ball(balls, laws, i, cushion, t)
        if blocking >= 0:
            press(balls, laws, contacts, i, blocking, t, counters)
            return
        bounce(balls, i, cushion, laws)
        counters[BALL_CUSHION] += 1
        _note_event(_BALL_CUSHION, i, cushion, t, clock, counters, log, keep_log)
    _set_free(balls, laws, contacts, i, t)


@kernel
def _wedging_ball(balls: Balls, laws: Laws, i: int, cushion: int, t: float) -> int:
    """Return a ball that keeps ball i at the cushion, where a bounce would be negligible, or -1."""
    nx, ny, _ = cushion_side(laws, cushion)
    rate = nx * balls.state[VX, i] + ny * balls.state[VY, i]
    if not negligible_hop(rate, 2.0 * laws.deceleration, contact_tolerance(balls, i, i)):
        return -1
    return blocking_ball(balls, i, nx, ny, t, laws.deceleration)


@kernel
def _resolve_pair(
    balls: Balls,
    laws: Laws,
    contacts: Contacts,
    i: int,
    j: int,
    t: float,
    clock: FloatArray,
    counters: IntArray,
    log: Log,
    keep_log: bool,
) -> None:
    """Collide balls i and j at the instant t."""
    advance(balls, i, t)
    advance(balls, j, t)
    collide_balls(balls, i, j, laws)
    counters[BALL_BALL] += 1
    _note_event(_BALL_BALL, i, j, t, clock, counters, log, keep_log)
    _set_free(balls, laws, contacts, i, t)
    _set_free(balls, laws, contacts, j, t)


@kernel
def _set_free(balls: Balls, laws: Laws, contacts: Contacts, i: int, t: float) -> None:
    """Predict ball i, whose velocity an event set; a cluster that it belonged to ends."""
    release(balls, laws, contacts, i, t)
    predict_motion(balls, i, laws)
    contacts.motion[STEP, i] = 0.0
    contacts.changed[i] = True


@kernel
def _full(log: Log, counters: IntArray, n: int) -> bool:
    """Whether the next instant might not fit in the log: it may change, and stop, every ball."""
    events_left = len(log.time) - counters[LOGGED_EVENTS]
    motions_left = len(log.ball) - counters[LOGGED_MOTIONS]
    return bool(events_left < 1 + n or motions_left < n)


@kernel
def _note_event(
    kind: int,
    a: int,
    b: int,
    t: float,
    clock: FloatArray,
    counters: IntArray,
    log: Log,
    keep_log: bool,
) -> None:
    counters[EVENTS] += 1
    clock[LAST_EVENT] = t
    if keep_log:
        row = counters[LOGGED_EVENTS]
        log.time[row] = t
        log.what[WHAT_KIND, row] = kind
        log.what[WHAT_A, row] = a
        log.what[WHAT_B, row] = b
        counters[LOGGED_EVENTS] = row + 1


@kernel
def _note_motion(balls: Balls, i: int, counters: IntArray, log: Log) -> None:
    """Log how ball i moves from its epoch on."""
    row = counters[LOGGED_MOTIONS]
    log.ball[row] = i
    log.motion[row, 0] = balls.state[EPOCH, i]
    log.motion[row, 1] = balls.state[X, i]
    log.motion[row, 2] = balls.state[Y, i]
    log.motion[row, 3] = balls.state[VX, i]
    log.motion[row, 4] = balls.state[VY, i]
    log.motion[row, 5] = balls.state[AX, i]
    log.motion[row, 6] = balls.state[AY, i]
    counters[LOGGED_MOTIONS] = row + 1
