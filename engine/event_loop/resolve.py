"""Does what happens at an event: balls collide, meet an obstacle, land, begin to roll, or stop.

Which event it is, `event_loop.find` has found; what an impact does, is in `impacts`. What changes a
ball's motion marks it in `balls.changed`, and leaves it to the loop to predict it. A `cushion` here
is any row of `Laws.obstacles`.

`Contacts` may be missing. What needs them then returns NEEDS_CONTACTS, having changed no motion,
and is called again when they are there.
"""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    ADVANCEMENTS,
    BALL_BALL,
    BALL_CUSHION,
    BALLS_GONE,
    DEGREE,
    FIRST,
    FREE,
    JOINT_IMPACTS,
    OWN_CUSHION,
    OWN_PIECE,
    OWN_REST,
    OWN_ROLL,
    SECOND,
    SLIDING,
    TAKES_OUT,
    UNSOLVED_JOINT_IMPACTS,
    Balls,
    Cells,
    Contacts,
    Laws,
    Log,
)
from ghostball.engine.event_loop.in_flight import (
    bounces_in_space,
    collide_pair,
    has_settled,
    is_hop,
    nose_of,
    note_held,
    press_below,
    resolve_flight,
    share_loads,
    touches_more,
)
from ghostball.engine.event_loop.record import (
    BALL_BALL_EVENT,
    BALL_CUSHION_EVENT,
    BALL_GONE_EVENT,
    SLIDE_TO_ROLL_EVENT,
    note_event,
    note_rest,
)
from ghostball.engine.impacts.impact import bounce, bounce_in_corner
from ghostball.engine.impacts.simultaneous import collide_together
from ghostball.engine.motion.geometry import (
    blocking_ball,
    capture_height,
    contact_tolerance,
    negligible_hop,
    tie_rounding,
)
from ghostball.engine.motion.next_piece import come_to_rest, leave, mark, start_rolling
from ghostball.engine.motion.obstacles import facing, nose_reach
from ghostball.engine.motion.position import advance
from ghostball.engine.resting_contact.step import end_step
from ghostball.engine.scheduling.contact_time import PRESSED
from ghostball.engine.scheduling.due_pairs import Event

NEEDS_CONTACTS = -1

_ALONG = 1.0 - 2.0**-20
"""Cosine between the normals of two obstacles above which they are one wall, and no corner."""


@kernel(inline=True)
def advance_to(balls: Balls, laws: Laws, contacts: Contacts | None, event: Event) -> None:
    """Move the balls of an event to its instant: but not pairs that are to be held together.

    A ball that stops, or stops sliding, is moved there without cancelling digits.
    """
    ball, t = event.ball, event.t
    if ball < 0:
        if event.verdict != PRESSED:
            for c in range(event.pairs):
                advance(balls, balls.hits[c, FIRST], t)
                advance(balls, balls.hits[c, SECOND], t)
        return
    kind = balls.own_kind[ball]
    if kind == OWN_REST:
        # One after the other, a second of a cluster would be moved there with what rounding leaves
        # of its speed.
        if contacts is not None and contacts.cluster[ball] != FREE:
            k = contacts.ring[ball]
            while k != ball:
                if _rests_by(balls, k, t):
                    come_to_rest(balls, laws, k, t)
                k = contacts.ring[k]
        come_to_rest(balls, laws, ball, t)
    elif kind == OWN_ROLL:
        start_rolling(balls, laws, ball, t)
    elif kind >= OWN_PIECE and not has_settled(balls.height, balls, ball, kind, t):
        advance(balls, ball, t)


@kernel(inline=True)
def resolve(
    balls: Balls,
    laws: Laws,
    cells: Cells | None,
    contacts: Contacts | None,
    event: Event,
    log: Log,
) -> int:
    """Resolve an event whose balls are at its instant; mark every ball whose motion it changes.

    Return how many contacts in `balls.hits` are to be held, or NEEDS_CONTACTS.
    """
    if event.ball < 0:
        return _resolve_contacts(balls, laws, cells, contacts, event, log)
    return _resolve_own(balls, laws, cells, contacts, event.ball, event.t, log)


@kernel
def _rests_by(balls: Balls, k: int, t: float) -> bool:
    return bool(balls.own_kind[k] == OWN_REST and balls.state[k].own_time <= t)


@kernel(inline=True)
def _resolve_own(
    balls: Balls,
    laws: Laws,
    cells: Cells | None,
    contacts: Contacts | None,
    i: int,
    t: float,
    log: Log,
) -> int:
    """Resolve what ball i does alone at the instant t: rest, roll, meet an obstacle, end a step.

    Return how many contacts in `balls.hits` are to be held.
    """
    kind = balls.own_kind[i]
    if resolve_flight(balls.height, balls, laws, contacts, i, kind, t, log):
        return 0
    if kind == OWN_REST:
        if contacts is not None and contacts.cluster[i] != FREE:
            k = contacts.ring[i]
            while k != i:
                if _rests_by(balls, k, t):
                    note_rest(balls, contacts, k, t, log)
                    mark(balls, k)
                k = contacts.ring[k]
        note_rest(balls, contacts, i, t, log)
        mark(balls, i)
    elif kind == OWN_ROLL:
        if balls.state[i].vx == 0.0 and balls.state[i].vy == 0.0:
            note_rest(balls, contacts, i, t, log)
        else:
            note_event(SLIDE_TO_ROLL_EVENT, i, -1, t, log)
        mark(balls, i)
    elif kind == OWN_PIECE:
        mark(balls, i)
    elif kind >= OWN_CUSHION:
        cushion = kind - OWN_CUSHION
        if laws.obstacles[cushion].law == TAKES_OUT:
            log.counters[BALLS_GONE] += 1
            note_event(BALL_GONE_EVENT, i, _index(laws, cushion), t, log)
            leave(balls, i)
            mark(balls, i)
            return 0
        partner = _pressed_against(balls, laws, cells, i, cushion, t)
        if partner != i:
            if contacts is None:
                return NEEDS_CONTACTS
            balls.hits[0, FIRST] = i
            balls.hits[0, SECOND] = partner
            return 1
        _resolve_cushion(balls, laws, i, cushion, t, log)
        mark(balls, i)
    elif contacts is not None:
        end_step(contacts, i)
    return 0


@kernel(inline=True)
def _resolve_cushion(balls: Balls, laws: Laws, i: int, cushion: int, t: float, log: Log) -> None:
    """Bounce ball i off a cushion; in a corner, off both at once."""
    cushion = nose_of(balls.height, balls, laws, i, cushion)
    log.counters[BALL_CUSHION] += 1
    note_event(BALL_CUSHION_EVENT, i, _index(laws, cushion), t, log)
    if bounces_in_space(balls.height, balls, laws, i, cushion):
        return
    other = _corner_cushion(balls, laws, i, cushion, t)
    if other < 0:
        bounce(balls, i, cushion, laws)
        return
    bounce_in_corner(balls, i, cushion, other, laws)
    log.counters[BALL_CUSHION] += 1
    log.counters[JOINT_IMPACTS] += 1
    note_event(BALL_CUSHION_EVENT, i, _index(laws, other), t, log)


@kernel(inline=True)
def _index(laws: Laws, k: int) -> int:
    return int(laws.obstacles[k].index)


@kernel(inline=True)
def _corner_cushion(balls: Balls, laws: Laws, i: int, cushion: int, t: float) -> int:
    """Return an obstacle across the given one that ball i meets at the same instant, or -1."""
    ball = balls.state[i]
    ox, oy, _ = facing(laws, cushion, ball.x, ball.y)
    for other in range(len(laws.obstacles)):
        nx, ny, distance = facing(laws, other, ball.x, ball.y)
        if not nx * ball.vx + ny * ball.vy < 0.0 or abs(nx * ox + ny * oy) > _ALONG:
            continue
        met = distance - nose_reach(balls, i, laws) <= tie_rounding(balls, i, i, t)
        if met and laws.obstacles[other].law != TAKES_OUT:
            return other
    return -1


@kernel(inline=True)
def _pressed_against(
    balls: Balls, laws: Laws, cells: Cells | None, i: int, cushion: int, t: float
) -> int:
    """Return what ball i is pressed against, where it wouldn't leave the cushion by bouncing.

    The cushion itself (as -1 minus its row), where friction drives the ball into it; or a ball
    that is in its way; or the ball itself: nothing.
    """
    nx, ny, _ = facing(laws, cushion, balls.state[i].x, balls.state[i].y)
    rate = nx * balls.state[i].vx + ny * balls.state[i].vy
    opening = nx * balls.state[i].ax + ny * balls.state[i].ay
    if opening < 0.0 and negligible_hop(rate, -opening, capture_height(balls, i, i)):
        return -1 - cushion
    pull = (
        balls.state[i].slide_slowing
        if balls.state[i].phase == SLIDING
        else balls.state[i].roll_slowing
    )
    if not negligible_hop(rate, 2.0 * pull, contact_tolerance(balls, i, i)):
        return i
    blocking = blocking_ball(balls, cells, i, nx, ny, t)
    return blocking if blocking >= 0 else i


@kernel(inline=True)
def _resolve_contacts(
    balls: Balls,
    laws: Laws,
    cells: Cells | None,
    contacts: Contacts | None,
    event: Event,
    log: Log,
) -> int:
    """Collide the pairs of `balls.hits` that touch now, or leave them to be held.

    A pair of which neither ball has another impact now follows the scene's law; others collide
    together. Return how many contacts in `balls.hits` are to be held.
    """
    count, t = event.pairs, event.t
    if contacts is None:
        if event.verdict == PRESSED:
            return NEEDS_CONTACTS
        for c in range(count):
            for other in range(c):
                if _share_ball(balls, c, other):
                    return NEEDS_CONTACTS
    hop = event.verdict != PRESSED and count == 1 and is_hop(balls.height, balls, laws, t)
    if hop and contacts is None and touches_more(balls, cells, t):
        return NEEDS_CONTACTS
    log.counters[ADVANCEMENTS] += event.judged
    if event.verdict == PRESSED:
        share_loads(balls.height, balls, count, t)
        return count
    for c in range(count):
        a, b = balls.hits[c, FIRST], balls.hits[c, SECOND]
        mark(balls, a)
        mark(balls, b)
        log.counters[BALL_BALL] += 1
        note_event(BALL_BALL_EVENT, a, b, t, log)
    if contacts is None:
        for c in range(count):
            i, j = balls.hits[c, FIRST], balls.hits[c, SECOND]
            collide_pair(balls.height, balls, i, j, laws, cells)
    else:
        _collide_groups(balls, laws, cells, contacts, count, log)
    note_held(balls.height, balls, contacts, count, t, log)
    return press_below(balls.height, balls, laws, cells, t) if hop else 0


@kernel
def _share_ball(balls: Balls, c: int, other: int) -> bool:
    """Whether two pairs of `balls.hits` have a ball in common."""
    a, b = balls.hits[c, FIRST], balls.hits[c, SECOND]
    k, m = balls.hits[other, FIRST], balls.hits[other, SECOND]
    return bool(k in (a, b) or m in (a, b))


@kernel
def _collide_groups(
    balls: Balls, laws: Laws, cells: Cells | None, contacts: Contacts, count: int, log: Log
) -> None:
    """Collide the first `count` pairs of `balls.hits`, together where they share balls."""
    for c in range(count):
        contacts.motion[balls.hits[c, FIRST], DEGREE] += 1.0
        contacts.motion[balls.hits[c, SECOND], DEGREE] += 1.0
    joint = 0
    for c in range(count):
        a, b = balls.hits[c, FIRST], balls.hits[c, SECOND]
        if contacts.motion[a, DEGREE] == 1.0 and contacts.motion[b, DEGREE] == 1.0:
            collide_pair(balls.height, balls, a, b, laws, cells)
            contacts.motion[a, DEGREE] = 0.0
            contacts.motion[b, DEGREE] = 0.0
        else:
            contacts.ends[joint, FIRST] = a
            contacts.ends[joint, SECOND] = b
            joint += 1
    if joint > 0:
        log.counters[JOINT_IMPACTS] += 1
        if not collide_together(balls, laws, contacts, joint):
            log.counters[UNSOLVED_JOINT_IMPACTS] += 1
    for c in range(count):
        contacts.motion[balls.hits[c, FIRST], DEGREE] = 0.0
        contacts.motion[balls.hits[c, SECOND], DEGREE] = 0.0
