"""Events of one instant: which comes first, and which belong together; for both schedulers."""

from __future__ import annotations

import math

from engine._geometry import capture_height, relative_motion, tie_rounding
from engine._jit import kernel
from engine._state import (
    FIRST,
    OWN_CUSHION,
    OWN_TIME,
    PENDING,
    PENDING_VERDICT,
    RADIUS,
    SECOND,
    Balls,
    IntArray,
)
from engine._touch import IMPACT, PRESSED


@kernel
def takes_precedence(balls: Balls, i: int, j: int) -> bool:
    """Whether ball i's own event is resolved before ball j's, which is at the same instant."""
    if balls.own_kind[i] != balls.own_kind[j]:
        return bool(balls.own_kind[i] < balls.own_kind[j])
    if balls.own_kind[i] < OWN_CUSHION:
        return False
    dx, dy, _, _, _, _ = relative_motion(balls, i, j, balls.state[i, OWN_TIME])
    gap = math.sqrt(dx * dx + dy * dy) - (balls.state[i, RADIUS] + balls.state[j, RADIUS])
    apart = gap > capture_height(balls, i, j)
    return bool(not apart and (dx > 0.0 or (dx == 0.0 and dy > 0.0)))


@kernel
def list_hit(balls: Balls, c: int, i: int, j: int) -> None:
    """Put the pair of balls i and j in row c of `balls.hits`, the lower index first."""
    balls.hits[c, FIRST] = min(i, j)
    balls.hits[c, SECOND] = max(i, j)


@kernel
def is_listed(balls: Balls, listed: int, i: int) -> bool:
    """Whether ball i is in the first `listed` rows of `balls.hits`."""
    for c in range(listed):  # noqa: SIM110 - the compiler takes no generator
        if balls.hits[c, FIRST] == i or balls.hits[c, SECOND] == i:
            return True
    return False


@kernel
def is_pair_listed(balls: Balls, start: int, stop: int, i: int, j: int) -> bool:
    """Whether the pair of balls i and j is in rows `start` to `stop` of `balls.hits`."""
    for c in range(start, stop):
        if balls.hits[c, FIRST] == min(i, j) and balls.hits[c, SECOND] == max(i, j):
            return True
    return False


@kernel
def when_tied(balls: Balls, listed: int, t: float, speed: float) -> float:
    """Return until when a gap closes that is closed at the instant t [s], but for rounding.

    `speed` is the fastest approach of the first `listed` pairs of `balls.hits`.
    """
    rounding = 0.0
    for c in range(listed):
        a, b = balls.hits[c, FIRST], balls.hits[c, SECOND]
        rounding = max(rounding, tie_rounding(balls, a, b, t))
    return t + rounding / speed


@kernel
def hand_over(balls: Balls, count: int, pressed: int, counters: IntArray) -> bool:
    """Note what the loop is to resolve now: impacts, or else pressed pairs, by their indices.

    The former are the first `count` rows of `balls.hits`, the latter the last `pressed`. Return
    whether there are any.
    """
    counters[PENDING_VERDICT] = IMPACT if count > 0 else PRESSED
    if count == 0:
        for c in range(pressed):
            last = balls.hits.shape[0] - 1 - c
            list_hit(balls, c, balls.hits[last, FIRST], balls.hits[last, SECOND])
        count = pressed
    counters[PENDING] = count
    for c in range(1, count):
        a, b, place = balls.hits[c, FIRST], balls.hits[c, SECOND], c
        while place > 0 and _is_after(balls, place - 1, a, b):
            list_hit(balls, place, balls.hits[place - 1, FIRST], balls.hits[place - 1, SECOND])
            place -= 1
        list_hit(balls, place, a, b)
    return count > 0


@kernel
def _is_after(balls: Balls, c: int, a: int, b: int) -> bool:
    first, second = balls.hits[c, FIRST], balls.hits[c, SECOND]
    return bool(first > a or (first == a and second > b))
