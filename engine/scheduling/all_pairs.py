"""When the next two balls touch: lazy lower bounds of the contact time of every pair.

Contact needs the relative motion, projected on today's line of centres, to have closed the gap: the
first root of a quadratic, never later than the first entering root of the true quartic. So a pair
costs one quadratic; only when its bound becomes the earliest of all is the step repeated from that
instant (conservative advancement), which converges to the true root quadratically and from outside,
so that no contact is passed over. Each pair stands once, in the row of the ball that was recomputed
last; a bound beyond either ball's own next event is dropped, since the motion changes there and the
row is computed again.

`scheduling.cells` is the other scheduler; `scheduling.scheduler` is what the loop uses of either.
"""

from __future__ import annotations

import math

from engine.core.kernel import kernel
from engine.core.state import (
    ADVANCEMENTS,
    BOUNDS,
    FREE,
    LANES,
    NEXT,
    NOWHERE,
    PARTNER,
    PENDING,
    PENDING_VERDICT,
    TRACK_AX,
    TRACK_AY,
    TRACK_EPOCH,
    TRACK_OWN_TIME,
    TRACK_RADIUS,
    TRACK_VX,
    TRACK_VY,
    TRACK_X,
    TRACK_Y,
    TRACKS,
    Balls,
    Contacts,
    FloatArray,
    IntArray,
    Laws,
    Pairs,
)
from engine.motion.crossings import first_crossing, first_meeting
from engine.motion.geometry import tie_rounding
from engine.motion.pieces import meets_until, place, speed, velocity, way
from engine.scheduling.contact_time import IMPACT, NOT_YET, PRESSED, touch
from engine.scheduling.ties import (
    comes_before,
    hand_over,
    has_room,
    is_listed,
    list_hit,
    takes_precedence,
    when_tied,
)


@kernel(inline=True)
def update_pairs(
    balls: Balls,
    laws: Laws,
    pairs: Pairs,
    contacts: Contacts | None,
    t: float,
    counters: IntArray,
) -> None:
    """Bound anew every pair of the balls in `balls.touched`, whose motion changed at t [s]."""
    for m in range(balls.touched[0]):
        _track(balls, pairs, balls.touched[1 + m])
    for m in range(balls.touched[0]):
        _update_ball(balls, laws, pairs, contacts, balls.touched[1 + m], t)
    counters[BOUNDS] += balls.touched[0] * (len(balls.own_kind) - 1)


@kernel(inline=True)
def _track(balls: Balls, pairs: Pairs, i: int) -> None:
    """Copy from ball i what its bounds need."""
    at = (i // LANES) * (TRACKS * LANES) + i % LANES
    pairs.track[at + TRACK_X] = balls.state[i].x
    pairs.track[at + TRACK_Y] = balls.state[i].y
    pairs.track[at + TRACK_VX] = balls.state[i].vx
    pairs.track[at + TRACK_VY] = balls.state[i].vy
    pairs.track[at + TRACK_AX] = balls.state[i].ax
    pairs.track[at + TRACK_AY] = balls.state[i].ay
    pairs.track[at + TRACK_EPOCH] = balls.state[i].epoch
    pairs.track[at + TRACK_RADIUS] = balls.state[i].radius
    pairs.track[at + TRACK_OWN_TIME] = meets_until(balls, i)


@kernel(inline=True)
def _update_ball(
    balls: Balls, laws: Laws, pairs: Pairs, contacts: Contacts | None, i: int, t: float
) -> None:
    """Bound anew every pair of ball i; its row takes them over from the others' rows."""
    n = len(balls.own_kind)
    (x, y), (vx, vy) = place(balls, i, t), velocity(balls, i, t)
    ax, ay = balls.state[i].ax, balls.state[i].ay
    radius, own_time = balls.state[i].radius, meets_until(balls, i)
    for block in range(0, n, LANES):
        track = pairs.track[block * TRACKS : (block + LANES) * TRACKS]
        row = pairs.bound[i * n + block : i * n + min(block + LANES, n)]
        if laws.uniform:
            _meet_block(track, row, t, x, y, vx, vy, radius, own_time)
        else:
            _bound_block(track, row, t, x, y, vx, vy, ax, ay, radius, own_time)
    pairs.bound[i * n + i] = math.inf
    if contacts is not None and contacts.cluster[i] != FREE:
        row = contacts.first_held[i]
        while row != NOWHERE:
            pairs.bound[i * n + contacts.held[row, PARTNER]] = math.inf
            row = contacts.held[row, NEXT]
    column = pairs.bound[i::n]
    for j in range(n):
        was = column[j]
        if was < math.inf and j != i:
            column[j] = math.inf
            if was <= pairs.least[j]:
                rescan(balls, pairs, j)
    rescan(balls, pairs, i)


@kernel
def _bound_block(
    track: FloatArray,
    bounds: FloatArray,
    t: float,
    x: float,
    y: float,
    vx: float,
    vy: float,
    ax: float,
    ay: float,
    radius: float,
    own_time: float,
) -> None:
    """Put in `bounds` when, at the soonest, a ball touches each of those in a block of `track`.

    From the instant t [s], at which the ball is and moves as given; inf where it can't. For the
    ball itself, a number without meaning. `relative_motion` and `first_crossing` written out,
    without branches, so that the compiler makes vector instructions of it, to the same bits.
    """
    for j in range(len(bounds)):
        s = t - track[TRACK_EPOCH + j]
        ax_j, ay_j = track[TRACK_AX + j], track[TRACK_AY + j]
        vx_j, vy_j = track[TRACK_VX + j], track[TRACK_VY + j]
        rx = track[TRACK_X + j] + way(vx_j, ax_j, s) - x
        ry = track[TRACK_Y + j] + way(vy_j, ay_j, s) - y
        ux, uy = speed(vx_j, ax_j, s) - vx, speed(vy_j, ay_j, s) - vy
        distance = math.sqrt(rx * rx + ry * ry)
        # All three scaled by the distance, which saves dividing by it.
        gap = distance * (distance - (radius + track[TRACK_RADIUS + j]))
        rate = rx * ux + ry * uy
        pull = rx * (ax_j - ax) + ry * (ay_j - ay)
        bound = t + first_crossing(gap, rate, pull)
        own_time_j = track[TRACK_OWN_TIME + j]
        until = own_time_j if own_time_j < own_time else own_time
        bounds[j] = bound if bound <= until else math.inf


@kernel
def _meet_block(
    track: FloatArray,
    bounds: FloatArray,
    t: float,
    x: float,
    y: float,
    vx: float,
    vy: float,
    radius: float,
    own_time: float,
) -> None:
    """Put in `bounds` when a ball touches each in a block of `track`, where none is ever slowed.

    As `_bound_block`, but the distance of two centres that move uniformly is a quadratic itself, so
    that its root is no bound, but the contact.
    """
    for j in range(len(bounds)):
        s = t - track[TRACK_EPOCH + j]
        rx = track[TRACK_X + j] + s * track[TRACK_VX + j] - x
        ry = track[TRACK_Y + j] + s * track[TRACK_VY + j] - y
        bound = t + first_meeting(
            rx,
            ry,
            track[TRACK_VX + j] - vx,
            track[TRACK_VY + j] - vy,
            radius + track[TRACK_RADIUS + j],
        )
        own_time_j = track[TRACK_OWN_TIME + j]
        until = own_time_j if own_time_j < own_time else own_time
        bounds[j] = bound if bound <= until else math.inf


@kernel(inline=True)
def rescan(balls: Balls, pairs: Pairs, i: int) -> None:
    """Find the least bound of row i again, and ball i's next event."""
    n = len(balls.own_kind)
    least = _least(pairs.bound[i * n : i * n + n])
    pairs.least[i] = least
    pairs.next[i] = min(least, balls.state[i].own_time)


@kernel
def _least(values: FloatArray) -> float:
    """Return the least of `values`; four at a time, since each comparison waits for the last."""
    a, b, c, d = math.inf, math.inf, math.inf, math.inf
    fours = len(values) // 4 * 4
    for k in range(0, fours, 4):
        a = values[k] if values[k] < a else a
        b = values[k + 1] if values[k + 1] < b else b
        c = values[k + 2] if values[k + 2] < c else c
        d = values[k + 3] if values[k + 3] < d else d
    for k in range(fours, len(values)):
        a = values[k] if values[k] < a else a
    return min(a, b, c, d)


@kernel(inline=True)
def earliest_of_pairs(balls: Balls, pairs: Pairs) -> tuple[float, int, int]:
    """Return the next instant and whose it is, as `scheduling.scheduler.earliest`.

    Of several own events at one instant, one coming to rest: so a ball that has all but stopped is
    at rest before its neighbours are looked at again. Of two that touch each other and meet a
    cushion together, the first by place, not by number.
    """
    t = _least(pairs.next)
    first, ties = _places(pairs.next, t)
    if ties == 1:
        return t, first if balls.state[first].own_time == t else -1, first
    single = -1
    for i in range(first, len(balls.own_kind)):
        if balls.state[i].own_time != t:
            continue
        if single < 0 or takes_precedence(balls, i, single):
            single = i
    return t, single, -1


@kernel
def _places(values: FloatArray, value: float) -> tuple[int, int]:
    """Return where `value` first stands in `values`, and how often."""
    count = 0
    for k in range(len(values)):
        count += values[k] == value
    first = 0
    while first < len(values) - 1 and values[first] != value:
        first += 1
    return first, count


@kernel(inline=True)
def touching_pairs(
    balls: Balls, laws: Laws, pairs: Pairs, t: float, row: int, counters: IntArray
) -> float:
    """Judge every pair whose bound is the instant t [s], as `scheduling.scheduler.touching`."""
    n = len(balls.own_kind)
    if row >= 0:
        other, ties = _places(pairs.bound[row * n : row * n + n], t)
        if ties == 1:
            return _follow(balls, laws, pairs, row, other, t, counters)
    return t if _touching_several(balls, laws, pairs, t, counters) else math.inf


@kernel(inline=True)
def _follow(
    balls: Balls, laws: Laws, pairs: Pairs, i: int, j: int, t: float, counters: IntArray
) -> float:
    """Advance one pair from its bound t [s] until it touches, or something else comes first."""
    n = len(balls.own_kind)
    own_time = balls.state[i].own_time
    pairs.bound[i * n + j] = math.inf
    others = _least(pairs.bound[i * n : i * n + n])
    pairs.next[i] = min(others, own_time)
    until = min(_least(pairs.next), laws.t_max)
    end = min(own_time, balls.state[j].own_time)
    verdict, bound, speed = NOT_YET, t, 0.0
    while True:
        counters[ADVANCEMENTS] += 1
        verdict, bound, speed = touch(balls, i, j, t, 0.0)
        if verdict != NOT_YET:
            break
        bound = bound if bound <= end else math.inf
        if not bound < until:
            break
        t = bound
    pairs.bound[i * n + j] = bound
    pairs.least[i] = min(others, bound)
    pairs.next[i] = min(others, bound, own_time)
    if verdict == NOT_YET:
        return math.inf
    list_hit(balls, 0, i, j)
    counters[PENDING] = 1
    counters[PENDING_VERDICT] = verdict
    if verdict == IMPACT and laws.simultaneous:
        after = t + tie_rounding(balls, i, j, t) / speed
        if others <= after or _until(pairs.least, after) > 1:
            hand_over(balls, _join_ties(balls, pairs, t, speed, 1, counters), 0, counters)
    return t


@kernel
def _until(values: FloatArray, last: float) -> int:
    """Return how many of `values` are at most `last`."""
    count = 0
    for k in range(len(values)):
        count += values[k] <= last
    return count


@kernel
def _touching_several(balls: Balls, laws: Laws, pairs: Pairs, t: float, counters: IntArray) -> bool:
    """Judge all pairs whose bound is the instant t [s], as `touching_pairs`; whether one touches.

    Notes
    -----
    Of sequential impacts the fastest first, then by place. For impacts at one instant that feed
    each other (a plastic hit on a frozen line) then die out like a relaxation of the whole line,
    not of its end over and over.
    """
    count, pressed, fastest = 0, 0, 0.0
    n = len(balls.own_kind)
    for i in range(n):
        if pairs.least[i] > t:
            continue
        for j in range(n):
            if pairs.bound[i * n + j] > t:
                continue
            counters[ADVANCEMENTS] += 1
            verdict, bound, speed = touch(balls, i, j, t, 0.0)
            if verdict == NOT_YET:
                own = min(balls.state[i].own_time, balls.state[j].own_time)
                pairs.bound[i * n + j] = bound if bound <= own else math.inf
            elif not has_room(balls, count, pressed, counters):
                return True
            elif verdict == PRESSED:
                # From the other end, out of the way of impacts.
                pressed += 1
                list_hit(balls, balls.hits.shape[0] - pressed, i, j)
            elif laws.simultaneous or comes_before(balls, count, speed, fastest, i, j, t):
                count = count + 1 if laws.simultaneous else 1
                fastest = max(speed, fastest)
                list_hit(balls, count - 1, i, j)
        rescan(balls, pairs, i)
    if count > 0 and laws.simultaneous:
        count = _join_ties(balls, pairs, t, fastest, count, counters)
    return hand_over(balls, count, pressed, counters)


@kernel
def _join_ties(
    balls: Balls, pairs: Pairs, t: float, speed: float, listed: int, counters: IntArray
) -> int:
    """List also the pairs that share a ball with a listed one, and touch too but for rounding.

    Which of the gaps closes first is then noise: a symmetric hit on two touching balls would be
    resolved one after the other where coordinates are rounded. Return how many are listed now.
    """
    until = when_tied(balls, listed, t, speed)
    count = listed
    n = len(balls.own_kind)
    for i in range(n):
        if pairs.least[i] > until:
            continue
        for j in range(n):
            if not t < pairs.bound[i * n + j] <= until:
                continue
            if not (is_listed(balls, listed, i) or is_listed(balls, listed, j)):
                continue
            verdict, _, _ = touch(balls, i, j, t, tie_rounding(balls, i, j, t))
            if verdict == IMPACT:
                if not has_room(balls, count, 0, counters):
                    return count
                list_hit(balls, count, i, j)
                count += 1
    return count
