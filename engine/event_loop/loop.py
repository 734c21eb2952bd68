"""The event loop: find the earliest event, move its balls there, resolve it, predict anew."""

from __future__ import annotations

import math

from engine.core.kernel import kernel
from engine.core.state import (
    CONTACT_STEPS,
    END,
    EVENTS,
    FARTHEST,
    FREE,
    LAST_EVENT,
    NO_ROOM,
    NOW,
    PENDING,
    RUN_CONTACTS,
    RUN_EVENT_LIMIT,
    RUN_LOG_FULL,
    RUN_NO_ROOM,
    RUN_NOT_FINITE,
    RUN_RESTED,
    RUN_T_MAX,
    SLIDING,
    UNSOUND,
    Balls,
    Cells,
    Contacts,
    FloatArray,
    Laws,
    Log,
    Pairs,
)
from engine.core.tolerances import EPS
from engine.event_loop.record import is_full, note_ends, note_motion
from engine.event_loop.resolve import NEEDS_CONTACTS, predict_anew, resolve_contacts, resolve_own
from engine.motion.geometry import at_rest
from engine.motion.pieces import advance
from engine.resting_contact.step import press_again
from engine.scheduling.scheduler import earliest, touching, update_balls

_MOST_IN_VAIN = 64
"""Bounds, for each pair, that may come to nothing before an event. A shot needs 1 or 2 in all; a
number that is NaN where nobody looks must not keep the loop busy for ever."""


@kernel
def run(
    balls: Balls,
    laws: Laws,
    pairs: Pairs | None,
    cells: Cells | None,
    contacts: Contacts | None,
    log: Log,
    limit: int,
) -> int:
    """Process events until every ball rests, `t_max`, a full log, or `limit` events and steps.

    Returns one of RUN_RESTED, RUN_T_MAX, RUN_EVENT_LIMIT, RUN_LOG_FULL, RUN_NOT_FINITE; or
    RUN_NO_ROOM, where more balls touch at once than the arrays have room for; or RUN_CONTACTS,
    where balls press each other, or hit several at once, and `contacts` is None.

    One of `pairs` and `cells` is None: which scheduler works, `scheduling.scheduler` says.

    Contract: every ball is marked when the run begins. No allocation, no raising. Everything is in
    the arguments, so a run that returned RUN_LOG_FULL, RUN_EVENT_LIMIT or RUN_CONTACTS goes on
    where it stopped when called again. A run that returned RUN_NOT_FINITE has in UNSOUND which
    ball's motion isn't.
    """
    held = 0
    log.counters[UNSOUND] = FREE
    while True:
        # Predict anew every ball whose motion changed, at first all: its old bounds are void.
        t = log.clock[NOW]
        predict_anew(balls, laws, contacts)
        if contacts is not None:
            press_again(balls, laws, cells, contacts, held, t, log.counters)
        _sort_touched(balls)
        for m in range(1, balls.touched[0] + 1):
            k = balls.touched[m]
            if contacts is not None:
                note_ends(balls, contacts, k, t, log)
            note_motion(balls, k, log)
            if not (balls.state[k].own_time >= t and _is_sound(balls, k)):
                log.counters[UNSOUND] = k
        if log.counters[UNSOUND] != FREE:  # here, so that each ball has its motion in the log
            return RUN_NOT_FINITE
        if log.counters[NO_ROOM] > 0:
            return RUN_NO_ROOM
        update_balls(balls, laws, pairs, cells, contacts, t, log.counters)
        _unmark(balls)

        # Find the earliest event: one ball's own, or the pair that may touch first.
        in_vain = 0
        while True:
            t, single, row = earliest(balls, laws, pairs, cells, contacts, log.counters)
            if not t >= log.clock[NOW]:
                log.counters[UNSOUND] = single if single >= 0 else row
                return RUN_NOT_FINITE
            if t == math.inf and _all_rest(balls):
                return RUN_RESTED
            if t > laws.t_max:
                return RUN_T_MAX
            if t == math.inf:  # a ball that moves, and neither stops nor has an end to wait for
                log.counters[UNSOUND] = single
                return RUN_NOT_FINITE
            if log.counters[EVENTS] + log.counters[CONTACT_STEPS] >= limit:
                return RUN_EVENT_LIMIT
            if is_full(log, len(balls.own_kind)):
                return RUN_LOG_FULL
            if single >= 0 or log.counters[PENDING] > 0:
                break
            t = touching(balls, laws, pairs, cells, contacts, t, row, log.counters)
            if log.counters[NO_ROOM] > 0:
                return RUN_NO_ROOM
            if t < math.inf:
                break
            in_vain += 1
            if in_vain > _MOST_IN_VAIN * (len(balls.own_kind) + 32) ** 2:
                log.counters[UNSOUND] = row
                return RUN_NOT_FINITE

        # Move its balls there and resolve it; mark every ball whose motion it changes.
        if single >= 0:
            held = resolve_own(balls, laws, cells, contacts, single, t, log)
        else:
            held = resolve_contacts(balls, laws, contacts, t, log)
        if held == NEEDS_CONTACTS:
            return RUN_CONTACTS
        log.counters[PENDING] = 0
        log.clock[NOW] = t


@kernel
def finish(balls: Balls, laws: Laws, log: Log, status: int, end: FloatArray) -> int:
    """Move every ball to the instant `log.clock[END]` at which a run that returned `status` ends.

    And put in `end`, (3, n, 3), its position, velocity and angular velocity there.

    When all centres rest, that is when the last spin about the vertical has decayed, too; a spin
    that no friction slows goes on, and isn't waited for. Return `status`, or RUN_T_MAX where a ball
    still spins then.
    """
    t = log.clock[NOW]
    if status == RUN_T_MAX:
        t = laws.t_max
    elif status == RUN_RESTED:
        t = log.clock[LAST_EVENT]
        for i in range(len(balls.own_kind)):
            spin, rate = balls.state[i].wz, balls.state[i].spin_slowing
            if spin != 0.0 and rate > 0.0:
                # Late by more than rounding, so that whoever computes the spin then finds none.
                t = max(t, (balls.state[i].epoch + abs(spin) / rate) * (1.0 + 4.0 * EPS))
    if t > laws.t_max:
        t, status = laws.t_max, RUN_T_MAX
    log.clock[END] = t
    unsound = False
    for i in range(len(balls.own_kind)):
        advance(balls, i, t)
        log.clock[FARTHEST] = max(log.clock[FARTHEST], abs(balls.state[i].x), abs(balls.state[i].y))
        _put_state(balls, i, end)
        sound = _is_sound(balls, i) and abs(balls.state[i].radius) < math.inf
        if status != RUN_NOT_FINITE and not sound:
            # A resting ball has no event at which it would have been seen before.
            log.counters[UNSOUND] = i
            unsound = True
    return RUN_NOT_FINITE if unsound else status


@kernel
def _put_state(balls: Balls, i: int, end: FloatArray) -> None:
    """Put in end[:, i] the position, velocity and angular velocity of ball i."""
    vx, vy, radius = balls.state[i].vx, balls.state[i].vy, balls.state[i].radius
    slides = balls.state[i].phase == SLIDING
    end[0, i, 0] = balls.state[i].x
    end[0, i, 1] = balls.state[i].y
    end[0, i, 2] = radius
    end[1, i, 0] = vx
    end[1, i, 1] = vy
    end[1, i, 2] = 0.0
    end[2, i, 0] = balls.state[i].wx if slides else -vy / radius
    end[2, i, 1] = balls.state[i].wy if slides else vx / radius
    end[2, i, 2] = balls.state[i].wz


@kernel(inline=True)
def _is_sound(balls: Balls, i: int) -> bool:
    """Whether no number of ball i's motion is NaN or infinite: a sum of such is never finite."""
    place = (balls.state[i].x + balls.state[i].y) + (balls.state[i].vx + balls.state[i].vy)
    spin = (balls.state[i].wx + balls.state[i].wy) + balls.state[i].wz
    pull = (balls.state[i].ax + balls.state[i].ay) + (balls.state[i].bx + balls.state[i].by)
    return bool(abs((place + spin) + (pull + balls.state[i].bz)) < math.inf)


@kernel
def _all_rest(balls: Balls) -> bool:
    for i in range(len(balls.own_kind)):  # noqa: SIM110 - the compiler takes no generator
        if not at_rest(balls, i):
            return False
    return True


@kernel(inline=True)
def _sort_touched(balls: Balls) -> None:
    """Put the balls that the event touched in the order of their numbers."""
    for m in range(2, balls.touched[0] + 1):
        k, place = balls.touched[m], m
        while place > 1 and balls.touched[place - 1] > k:
            balls.touched[place] = balls.touched[place - 1]
            place -= 1
        balls.touched[place] = k


@kernel(inline=True)
def _unmark(balls: Balls) -> None:
    for m in range(1, balls.touched[0] + 1):
        balls.changed[balls.touched[m]] = False
    balls.touched[0] = 0
