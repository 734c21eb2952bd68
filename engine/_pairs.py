"""When the next two balls touch: lazy lower bounds of the contact time of every pair.

Contact needs the relative motion, projected on today's line of centres, to have closed the gap: the
first root of a quadratic, never later than the first entering root of the true quartic. So a pair
costs one quadratic; only when its bound becomes the earliest of all is the step repeated from that
instant (conservative advancement), which converges to the true root quadratically and from outside,
so that no contact is passed over. Each pair stands once, in the row of the ball that was recomputed
last; a bound beyond either ball's own next event is dropped, since the motion changes there and the
row is computed again.

This is the part of the engine that another scheduler would replace: `update_ball` after a ball's
motion changed, `earliest`, and `touching` are all that the loop uses.
"""

from __future__ import annotations

import math

from engine._geometry import (
    at_rest,
    capture_height,
    negligible_hop,
    relative_motion,
    tie_rounding,
)
from engine._jit import kernel
from engine._motion import first_crossing
from engine._state import (
    ADVANCEMENTS,
    AX,
    AY,
    BOUNDS,
    EPOCH,
    FIRST,
    OWN_TIME,
    RADIUS,
    ROLL,
    SECOND,
    VX,
    VY,
    Balls,
    BoolArray,
    Contacts,
    IntArray,
    Laws,
    Pairs,
)
from engine._tolerances import APPROACH_ROUNDING, GAP_ROUNDING, TIME_ROUNDING

NOT_YET = 0
"""The bound moved on; the pair doesn't touch at this instant."""
IMPACT = 1
"""The pair touches and approaches: collide it now."""
PRESSED = 2
"""The pair touches, and is pulled together so that it would not part by what is resolved."""


@kernel
def update_ball(
    balls: Balls, held: BoolArray, pairs: Pairs, i: int, t: float, counters: IntArray
) -> None:
    """Bound anew every pair of ball i, whose motion changed at the instant t [s]."""
    n = len(balls.own_kind)
    least, partner = math.inf, 0
    for j in range(n):
        if j == i:
            continue
        bound = math.inf if held[i, j] else _bound(balls, i, j, t)
        pairs.bound[i, j] = bound
        if bound < least:
            least, partner = bound, j
        pairs.bound[j, i] = math.inf
        if pairs.row_partner[j] == i:
            _rescan(pairs, j)
    pairs.row_least[i] = least
    pairs.row_partner[i] = partner
    counters[BOUNDS] += n - 1


@kernel
def earliest(pairs: Pairs) -> float:
    """Return the least bound of all pairs [s]."""
    least = math.inf
    for i in range(len(pairs.row_least)):
        least = min(least, pairs.row_least[i])
    return least


@kernel
def touching(
    balls: Balls, laws: Laws, contacts: Contacts, pairs: Pairs, t: float, counters: IntArray
) -> tuple[int, int]:
    """Judge every pair whose bound is the instant t [s]: a verdict, and how many pairs it is about.

    IMPACT, for all pairs that approach, or for the fastest of them where impacts are sequential;
    else PRESSED; else NOT_YET, when all those bounds have moved on. The pairs are in the first
    columns of `contacts.hits`, the lower index first.

    Notes
    -----
    Of sequential impacts the fastest first, because impacts at one instant that feed each other (a
    plastic hit on a frozen line) then die out like a relaxation of the whole line, not of its end
    over and over.
    """
    count, pressed, fastest = 0, 0, 0.0
    n = len(pairs.row_least)
    for i in range(n):
        if pairs.row_least[i] > t:
            continue
        for j in range(n):
            if pairs.bound[i, j] > t:
                continue
            counters[ADVANCEMENTS] += 1
            verdict, bound, speed = _touch(balls, i, j, t, 0.0)
            if verdict == NOT_YET:
                own = min(balls.state[OWN_TIME, i], balls.state[OWN_TIME, j])
                pairs.bound[i, j] = bound if bound <= own else math.inf
            elif verdict == PRESSED:
                # From the other end, out of the way of impacts.
                pressed += 1
                _list_hit(contacts, contacts.hits.shape[1] - pressed, i, j)
            elif laws.simultaneous or speed > fastest:
                count = count + 1 if laws.simultaneous else 1
                fastest = max(speed, fastest)
                _list_hit(contacts, count - 1, i, j)
        _rescan(pairs, i)
    if count > 0:
        if laws.simultaneous:
            count = _join_ties(balls, contacts, pairs, t, fastest, count)
        return IMPACT, count
    for c in range(pressed):
        last = contacts.hits.shape[1] - 1 - c
        _list_hit(contacts, c, contacts.hits[FIRST, last], contacts.hits[SECOND, last])
    return (PRESSED, pressed) if pressed > 0 else (NOT_YET, 0)


@kernel
def _list_hit(contacts: Contacts, c: int, i: int, j: int) -> None:
    contacts.hits[FIRST, c] = min(i, j)
    contacts.hits[SECOND, c] = max(i, j)


@kernel
def _join_ties(
    balls: Balls, contacts: Contacts, pairs: Pairs, t: float, speed: float, listed: int
) -> int:
    """List also the pairs that share a ball with a listed one, and touch too but for rounding.

    Which of the gaps closes first is then noise: a symmetric hit on two touching balls would be
    resolved one after the other where coordinates are rounded. Return how many are listed now.
    """
    rounding = 0.0
    for c in range(listed):
        a, b = contacts.hits[FIRST, c], contacts.hits[SECOND, c]
        rounding = max(rounding, tie_rounding(balls, a, b, t))
    until = t + rounding / speed  # when a gap of that size has closed
    count = listed
    n = len(pairs.row_least)
    for i in range(n):
        if pairs.row_least[i] > until:
            continue
        for j in range(n):
            if not t < pairs.bound[i, j] <= until:
                continue
            if not (_is_listed(contacts, listed, i) or _is_listed(contacts, listed, j)):
                continue
            verdict, _, _ = _touch(balls, i, j, t, tie_rounding(balls, i, j, t))
            if verdict == IMPACT:
                _list_hit(contacts, count, i, j)
                count += 1
    return count


@kernel
def _is_listed(contacts: Contacts, listed: int, i: int) -> bool:
    for c in range(listed):  # noqa: SIM110 - the compiler takes no generator
        if contacts.hits[FIRST, c] == i or contacts.hits[SECOND, c] == i:
            return True
    return False


@kernel
def _bound(balls: Balls, i: int, j: int, t: float) -> float:
    """Return a lower bound, from the instant t, of when i and j touch; inf where they can't."""
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, t)
    reach = balls.state[RADIUS, i] + balls.state[RADIUS, j]
    distance = math.sqrt(rx * rx + ry * ry)
    # All three scaled by the distance, which saves dividing by it.
    gap = distance * (distance - reach)
    s = first_crossing(gap, rx * vx + ry * vy, rx * ax + ry * ay)
    bound = t + s
    return bound if bound <= min(balls.state[OWN_TIME, i], balls.state[OWN_TIME, j]) else math.inf


@kernel
def _touch(balls: Balls, i: int, j: int, t: float, slack: float) -> tuple[int, float, float]:
    """Judge the pair at the instant t: a verdict, the next bound, the speed of approach.

    A gap of up to `slack` [m] counts as closed.
    """
    rx, ry, vx, vy, ax, ay = relative_motion(balls, i, j, t)
    reach = balls.state[RADIUS, i] + balls.state[RADIUS, j]
    distance = math.sqrt(rx * rx + ry * ry)
    gap = distance - reach
    rate = (rx * vx + ry * vy) / distance
    pull = (rx * ax + ry * ay) / distance
    s = first_crossing(gap, rate, pull)
    progress = s > TIME_ROUNDING * t
    if gap > max(GAP_ROUNDING * reach, slack) and progress:
        return NOT_YET, t + s, 0.0
    # They touch, as far as doubles can tell. While r . v = 0, the gap opens at first as
    # `opening` s^2 / 2: the lines of centres turn away, or friction pulls together.
    noise = APPROACH_ROUNDING * (_speed(balls, i, t) + _speed(balls, j, t))
    across = max(vx * vx + vy * vy - rate * rate, 0.0)
    opening = across / distance + pull
    pulled = opening < -APPROACH_ROUNDING * (_pull(balls, i) + _pull(balls, j))
    if rate < -noise:
        # A rebound that slow ends within `CAPTURE_HEIGHT`, where friction pulls the balls together
        # again; the cloth also stops one that was struck at rest.
        struck = at_rest(balls, i) or at_rest(balls, j)
        closing = _stopping(balls, i) + _stopping(balls, j) - opening
        height = capture_height(balls, i, j)
        hop = (pulled or struck) and negligible_hop(rate, closing, height)
        return (PRESSED if hop else IMPACT), t, -rate
    if rate > noise and progress:
        return NOT_YET, t + s, 0.0
    if pulled:
        return PRESSED, t, 0.0
    s = _next_approach(distance * max(opening, 0.0), vx, vy, ax, ay)
    return (NOT_YET, t + s, 0.0) if s > TIME_ROUNDING * t else (PRESSED, t, 0.0)


@kernel
def _next_approach(opening: float, vx: float, vy: float, ax: float, ay: float) -> float:
    """Return when a touching pair that neither approaches nor recedes can approach next [s].

    With r . v = 0, half the rate of |r|^2 is s (A + B s + C s^2), A = v^2 + r . a = `opening`,
    B = 3/2 v . a, C = a^2 / 2: the pair opens while that is positive.
    """
    linear = 1.5 * (vx * ax + vy * ay)
    quadratic = 0.5 * (ax * ax + ay * ay)
    discriminant = linear * linear - 4.0 * quadratic * opening
    if linear >= 0.0 or discriminant < 0.0:
        return math.inf
    return 2.0 * opening / (math.sqrt(discriminant) - linear)


@kernel
def _stopping(balls: Balls, i: int) -> float:
    """Deceleration [m/s^2] that will stop ball i where an impact makes it leave its rest."""
    deceleration: float = balls.state[ROLL, i] if at_rest(balls, i) else 0.0
    return deceleration


@kernel
def _pull(balls: Balls, i: int) -> float:
    """Size of the acceleration of ball i [m/s^2], in the 1-norm."""
    size: float = abs(balls.state[AX, i]) + abs(balls.state[AY, i])
    return size


@kernel
def _speed(balls: Balls, i: int, t: float) -> float:
    """Size of the velocity of ball i at the instant t [m/s], in the 1-norm."""
    s = t - balls.state[EPOCH, i]
    size: float = abs(balls.state[VX, i] + balls.state[AX, i] * s) + abs(
        balls.state[VY, i] + balls.state[AY, i] * s
    )
    return size


@kernel
def _rescan(pairs: Pairs, i: int) -> None:
    """Find the least bound of row i again."""
    least, partner = math.inf, 0
    for j in range(len(pairs.row_least)):
        if pairs.bound[i, j] < least:
            least, partner = pairs.bound[i, j], j
    pairs.row_least[i] = least
    pairs.row_partner[i] = partner
