"""The event loop: find the earliest event, move its balls there, resolve it, predict anew."""

from __future__ import annotations

import math

from engine._geometry import (
    at_rest,
    blocking_ball,
    capture_height,
    contact_tolerance,
    cushion_gap,
    cushion_side,
    negligible_hop,
    relative_motion,
    tie_rounding,
)
from engine._impact import bounce, bounce_in_corner, collide_balls
from engine._jit import kernel
from engine._motion import advance, come_to_rest, predict_motion, start_rolling
from engine._pairs import IMPACT, NOT_YET, earliest, touching, update_ball
from engine._press import end_step, press_again
from engine._state import (
    AX,
    AY,
    BALL_BALL,
    BALL_CUSHION,
    CONTACT_STEPS,
    DEGREE,
    EVENTS,
    FIRST,
    FREE,
    JOINT_IMPACTS,
    KNOT,
    LAST_EVENT,
    LOGGED_EVENTS,
    LOGGED_MOTIONS,
    MOVED,
    NOW,
    OWN_CONTACT,
    OWN_CUSHION,
    OWN_REST,
    OWN_ROLL,
    OWN_TIME,
    PHASE,
    RADIUS,
    ROLL,
    RUN_EVENT_LIMIT,
    RUN_LOG_FULL,
    RUN_NOT_FINITE,
    RUN_RESTED,
    RUN_T_MAX,
    SECOND,
    SLIDE,
    SLIDING,
    STEP,
    UNSOLVED_JOINT_IMPACTS,
    VX,
    VY,
    WHAT_A,
    WHAT_B,
    WHAT_KIND,
    Balls,
    Contacts,
    IntArray,
    Laws,
    Log,
    Pairs,
    X,
    Y,
)
from engine._together import collide_together
from engine.result import EventKind

# Plain integers for the compiler.
_BALL_BALL = int(EventKind.BALL_BALL)
_BALL_CUSHION = int(EventKind.BALL_CUSHION)
_SLIDE_TO_ROLL = int(EventKind.SLIDE_TO_ROLL)
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
def run(balls: Balls, laws: Laws, contacts: Contacts, pairs: Pairs, log: Log, limit: int) -> int:
    """Process events until every ball rests, `t_max`, a full log, or `limit` events and steps.

    Returns one of RUN_RESTED, RUN_T_MAX, RUN_EVENT_LIMIT, RUN_LOG_FULL, RUN_NOT_FINITE.

    Contract: no allocation, no raising. Everything is in the arguments, so a run that returned
    RUN_LOG_FULL or RUN_EVENT_LIMIT goes on where it stopped when called again.
    """
    while True:
        if _full(log, len(balls.own_kind)):
            return RUN_LOG_FULL

        # Find the earliest event: one ball's own, or the pair that may touch first.
        single = _earliest_own(balls)
        t = min(balls.state[OWN_TIME, single], earliest(pairs))
        if not t >= log.clock[NOW]:
            return RUN_NOT_FINITE
        if t == math.inf and _all_rest(balls):
            return RUN_RESTED
        if t > laws.t_max:
            return RUN_T_MAX
        if log.counters[EVENTS] + log.counters[CONTACT_STEPS] >= limit:
            return RUN_EVENT_LIMIT

        # Move its balls there and resolve it; mark every ball whose motion it changes.
        if balls.state[OWN_TIME, single] <= t:
            _resolve_own(balls, laws, contacts, single, t, log)
        else:
            verdict, count = touching(balls, laws, contacts, pairs, t, log.counters)
            if verdict == NOT_YET:
                continue
            if verdict == IMPACT:
                _resolve_pairs(balls, laws, contacts, count, t, log)
            else:
                press_again(balls, laws, contacts, count, t, log.counters)
        log.clock[NOW] = t

        # Predict anew: every bound of a ball whose motion changed is void.
        for k in range(len(balls.own_kind)):
            if contacts.changed[k]:
                contacts.changed[k] = False
                _note_ends(contacts, k, t, log)
                _note_motion(balls, k, log)
                update_ball(balls, contacts.held, pairs, k, t, log.counters)


@kernel
def finish(balls: Balls, t: float) -> None:
    """Move every ball to the instant t [s], where the run stopped."""
    for i in range(len(balls.own_kind)):
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

    So a ball that has all but stopped is at rest before its neighbours are looked at again. Of
    two that touch each other and meet a cushion together, the first by place, not by number. A time
    that is NaN comes before all, so that the run stops there.
    """
    best = 0
    for i in range(1, len(balls.own_kind)):
        earlier = balls.state[OWN_TIME, i] < balls.state[OWN_TIME, best]
        tie = balls.state[OWN_TIME, i] == balls.state[OWN_TIME, best]
        if math.isnan(balls.state[OWN_TIME, i]):
            return i
        if earlier or (tie and _takes_precedence(balls, i, best)):
            best = i
    return best


@kernel
def _takes_precedence(balls: Balls, i: int, j: int) -> bool:
    """Whether ball i's own event is resolved before ball j's, which is at the same instant."""
    if balls.own_kind[i] != balls.own_kind[j]:
        return bool(balls.own_kind[i] < balls.own_kind[j])
    if balls.own_kind[i] < OWN_CUSHION:
        return False
    dx, dy, _, _, _, _ = relative_motion(balls, i, j, balls.state[OWN_TIME, i])
    gap = math.sqrt(dx * dx + dy * dy) - (balls.state[RADIUS, i] + balls.state[RADIUS, j])
    apart = gap > capture_height(balls, i, j)
    return bool(not apart and (dx > 0.0 or (dx == 0.0 and dy > 0.0)))


@kernel
def _resolve_own(balls: Balls, laws: Laws, contacts: Contacts, i: int, t: float, log: Log) -> None:
    """Resolve what ball i does alone at the instant t: rest, roll, meet a cushion, end a step."""
    kind = balls.own_kind[i]
    listed = 0
    if kind == OWN_CONTACT:
        end_step(contacts, i)
    elif kind == OWN_REST:
        for k in range(len(balls.own_kind)):
            if k == i or _rests_with(balls, contacts, i, k, t):
                come_to_rest(balls, k, t)
                _note_rest(contacts, k, t, log)
                _predict_anew(balls, laws, contacts, k)
    elif kind == OWN_ROLL:
        start_rolling(balls, i, t)
        if balls.state[VX, i] == 0.0 and balls.state[VY, i] == 0.0:
            _note_rest(contacts, i, t, log)
        else:
            _note_event(_SLIDE_TO_ROLL, i, -1, t, log)
        _predict_anew(balls, laws, contacts, i)
    else:
        cushion = kind - OWN_CUSHION
        advance(balls, i, t)
        partner = _pressed_against(balls, laws, i, cushion, t)
        if partner == i:
            _resolve_cushion(balls, laws, i, cushion, t, log)
            _predict_anew(balls, laws, contacts, i)
        else:
            contacts.hits[FIRST, 0] = i
            contacts.hits[SECOND, 0] = partner
            listed = 1
    press_again(balls, laws, contacts, listed, t, log.counters)


@kernel
def _rests_with(balls: Balls, contacts: Contacts, i: int, k: int, t: float) -> bool:
    """Whether ball k comes to rest at the instant t too, by the contact step that stops ball i.

    One after the other, the second would be moved there with what rounding leaves of its speed.
    """
    together = contacts.cluster[i] != FREE and contacts.cluster[k] == contacts.cluster[i]
    return bool(together and balls.own_kind[k] == OWN_REST and balls.state[OWN_TIME, k] <= t)


@kernel
def _resolve_cushion(balls: Balls, laws: Laws, i: int, cushion: int, t: float, log: Log) -> None:
    """Bounce ball i off a cushion; in a corner, off both at once."""
    log.counters[BALL_CUSHION] += 1
    _note_event(_BALL_CUSHION, i, cushion, t, log)
    other = _corner_cushion(balls, laws, i, cushion, t)
    if other < 0:
        bounce(balls, i, cushion, laws)
        return
    bounce_in_corner(balls, i, cushion, other, laws)
    log.counters[BALL_CUSHION] += 1
    log.counters[JOINT_IMPACTS] += 1
    _note_event(_BALL_CUSHION, i, other, t, log)


@kernel
def _corner_cushion(balls: Balls, laws: Laws, i: int, cushion: int, t: float) -> int:
    """Return a cushion across the given one that ball i meets at the same instant, or -1."""
    for other in range(4):
        if other // 2 == cushion // 2:
            continue
        nx, ny, _ = cushion_side(laws, other)
        x, y = balls.state[X, i], balls.state[Y, i]
        gap = cushion_gap(x, y, balls.state[RADIUS, i], laws, other)
        approaching = nx * balls.state[VX, i] + ny * balls.state[VY, i] < 0.0
        if gap <= tie_rounding(balls, i, i, t) and approaching:
            return other
    return -1


@kernel
def _pressed_against(balls: Balls, laws: Laws, i: int, cushion: int, t: float) -> int:
    """Return what ball i is pressed against, where it wouldn't leave the cushion by bouncing.

    The cushion itself (as -1 minus its index), where friction drives the ball into it; or a ball
    that is in its way; or the ball itself: nothing.
    """
    nx, ny, _ = cushion_side(laws, cushion)
    rate = nx * balls.state[VX, i] + ny * balls.state[VY, i]
    opening = nx * balls.state[AX, i] + ny * balls.state[AY, i]
    if opening < 0.0 and negligible_hop(rate, -opening, capture_height(balls, i, i)):
        return -1 - cushion
    pull = balls.state[SLIDE, i] if balls.state[PHASE, i] == SLIDING else balls.state[ROLL, i]
    if not negligible_hop(rate, 2.0 * pull, contact_tolerance(balls, i, i)):
        return i
    blocking = blocking_ball(balls, i, nx, ny, t)
    return blocking if blocking >= 0 else i


@kernel
def _resolve_pairs(
    balls: Balls, laws: Laws, contacts: Contacts, count: int, t: float, log: Log
) -> None:
    """Collide the first `count` pairs of `contacts.hits` at the instant t; together if they touch.

    A pair of which neither ball has another impact now follows the scene's law.
    """
    for c in range(count):
        a, b = contacts.hits[FIRST, c], contacts.hits[SECOND, c]
        advance(balls, a, t)
        advance(balls, b, t)
        contacts.motion[DEGREE, a] += 1.0
        contacts.motion[DEGREE, b] += 1.0
        log.counters[BALL_BALL] += 1
        _note_event(_BALL_BALL, a, b, t, log)
    joint = 0
    for c in range(count):
        a, b = contacts.hits[FIRST, c], contacts.hits[SECOND, c]
        if contacts.motion[DEGREE, a] == 1.0 and contacts.motion[DEGREE, b] == 1.0:
            collide_balls(balls, a, b, laws)
        else:
            contacts.ends[FIRST, joint] = a
            contacts.ends[SECOND, joint] = b
            joint += 1
    if joint > 0:
        log.counters[JOINT_IMPACTS] += 1
        if not collide_together(balls, laws, contacts, joint):
            log.counters[UNSOLVED_JOINT_IMPACTS] += 1
    for c in range(count):
        for row in (FIRST, SECOND):
            k = contacts.hits[row, c]
            if contacts.motion[DEGREE, k] > 0.0:
                contacts.motion[DEGREE, k] = 0.0
                _predict_anew(balls, laws, contacts, k)
    press_again(balls, laws, contacts, 0, t, log.counters)


@kernel
def _predict_anew(balls: Balls, laws: Laws, contacts: Contacts, i: int) -> None:
    """Predict ball i, whose velocity an event set; so the contact step that it was in ends.

    Contract: `press_again` follows, after all balls of the event.
    """
    contacts.motion[STEP, i] = 0.0
    if not at_rest(balls, i):
        contacts.motion[MOVED, i] = 1.0
    if contacts.cluster[i] == FREE:
        predict_motion(balls, i, laws)
        contacts.changed[i] = True
    else:
        end_step(contacts, i)


@kernel
def _full(log: Log, n: int) -> bool:
    """Whether the next instant might not fit in the log: any ball may change, roll and stop.

    And hit each pair that can touch at once: fewer than 3 n in the plane.
    """
    if len(log.time) == 0:
        return False
    events_left = len(log.time) - log.counters[LOGGED_EVENTS]
    motions_left = len(log.ball) - log.counters[LOGGED_MOTIONS]
    return bool(events_left < 2 + 5 * n or motions_left < n)


@kernel
def _note_ends(contacts: Contacts, k: int, t: float, log: Log) -> None:
    """Log that ball k came to roll or to rest by a contact step."""
    if contacts.rolled[k]:
        contacts.rolled[k] = False
        _note_event(_SLIDE_TO_ROLL, k, -1, t, log)
    if contacts.stopped[k]:
        contacts.stopped[k] = False
        _note_rest(contacts, k, t, log)


@kernel
def _note_rest(contacts: Contacts, k: int, t: float, log: Log) -> None:
    """Log that ball k came to rest; but not again after what a contact step let it creep."""
    if contacts.cluster[k] == FREE or contacts.motion[MOVED, k] == 1.0:
        _note_event(_ROLL_TO_REST, k, -1, t, log)
    log.clock[LAST_EVENT] = t
    contacts.motion[MOVED, k] = 0.0


@kernel
def _note_event(kind: int, a: int, b: int, t: float, log: Log) -> None:
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
def _note_motion(balls: Balls, i: int, log: Log) -> None:
    """Log how ball i moves from its epoch on."""
    if len(log.time) > 0:
        row = log.counters[LOGGED_MOTIONS]
        log.ball[row] = i
        for k in range(KNOT):
            log.motion[row, k] = balls.state[k, i]
        log.counters[LOGGED_MOTIONS] = row + 1
