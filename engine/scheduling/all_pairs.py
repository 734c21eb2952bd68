"""Few balls: a lower bound of the time of impact of every pair, computed when it is needed.

Contact needs the relative motion, projected on today's line of centres, to have closed the gap: the
first root of a quadratic, never later than the first entering root of the true quartic. So a pair
costs one quadratic; only when its bound becomes the earliest of all is the step repeated from that
instant (conservative advancement), which converges to the true root quadratically and from outside,
so that no contact is passed over. Each pair stands once, in the row of the ball that was recomputed
last; a bound beyond either ball's own next event is dropped, since the motion changes there and the
row is computed again. Where a motion is no parabola, its jerk makes the bound sooner; where nothing
slows balls, the quadratic's root is the contact itself.

`scheduling.broad_phase` is the other scheduler; `scheduling.scheduler` is what the loop uses of
either.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import FloatArray, Pairs, World
from ghostball.engine.motion.air import in_air
from ghostball.engine.motion.crossings import first_crossing, first_meeting
from ghostball.engine.motion.flight import may_meet_in_space
from ghostball.engine.motion.position import (
    FOR_EVER,
    displacement,
    jerk,
    meets_until,
    position_at,
    speed,
    velocity,
)
from ghostball.engine.scheduling.ties import takes_precedence
from ghostball.engine.scheduling.time_of_impact import first_bound, time_to_bent_bound


@kernel(inline=True)
def update(world: World, t: float) -> None:
    """Bound anew every pair of the balls in `balls.touched`, whose motion changed at t [s]."""
    balls = world.balls
    for m in range(balls.touched[0]):
        _track(world, balls.touched[1 + m])
    for m in range(balls.touched[0]):
        _update_ball(world, balls.touched[1 + m], t)
    world.log.counters[st.BOUNDS] += balls.touched[0] * (len(balls.own_kind) - 1)


@kernel(inline=True)
def _track(world: World, i: int) -> None:
    """Copy from ball i what its bounds need."""
    balls, pairs = world.balls, world.pairs
    at = (i // st.TRACK_BALLS) * (st.TRACKS * st.TRACK_BALLS) + i % st.TRACK_BALLS
    pairs.track[at + st.TRACK_X] = balls.state[i].x
    pairs.track[at + st.TRACK_Y] = balls.state[i].y
    pairs.track[at + st.TRACK_VX] = balls.state[i].vx
    pairs.track[at + st.TRACK_VY] = balls.state[i].vy
    pairs.track[at + st.TRACK_AX] = balls.state[i].ax
    pairs.track[at + st.TRACK_AY] = balls.state[i].ay
    pairs.track[at + st.TRACK_EPOCH] = balls.state[i].epoch
    pairs.track[at + st.TRACK_RADIUS] = balls.state[i].radius
    pairs.track[at + st.TRACK_OWN_TIME] = meets_until(balls, i)
    _track_bend(balls.powers, world, i, at)


@kernel(inline=True)
def _track_bend(powers: FloatArray | None, world: World, i: int, at: int) -> None:
    """Copy from ball i how it bends, if any does."""
    if powers is not None:
        world.pairs.track[at + st.TRACK_JERK] = jerk(world.balls, i)


@kernel(inline=True)
def _update_ball(world: World, i: int, t: float) -> None:
    """Bound anew every pair of ball i; its row takes them over from the others' rows."""
    balls, pairs, contacts = world.balls, world.pairs, world.contacts
    n = len(balls.own_kind)
    _bound_row(balls.powers, balls.height, world, i, t)
    pairs.bound[i * n + i] = math.inf
    if contacts.island[i] != st.FREE:
        row = contacts.first_held[i]
        while row != st.NOWHERE:
            pairs.bound[i * n + contacts.held[row, st.PARTNER]] = math.inf
            row = contacts.held[row, st.NEXT]
    column = pairs.bound[i::n]
    for j in range(n):
        was = column[j]
        if was < math.inf and j != i:
            column[j] = math.inf
            if was <= pairs.least[j]:
                rescan(world, j)
    rescan(world, i)


@kernel(inline=True)
def _bound_row(
    powers: FloatArray | None, height: FloatArray | None, world: World, i: int, t: float
) -> None:
    """Put in row i when, at the soonest, ball i touches each of the others after the instant t."""
    balls = world.balls
    n = len(balls.own_kind)
    if height is not None and may_meet_in_space(height, balls):
        _bound_each(world, i, t)
        return
    radius, own_time = balls.state[i].radius, meets_until(balls, i)
    (x, y), (vx, vy) = position_at(balls, i, t), velocity(balls, i, t)
    ax, ay = balls.state[i].ax, balls.state[i].ay
    for block in range(0, n, st.TRACK_BALLS):
        track = world.pairs.track[block * st.TRACKS : (block + st.TRACK_BALLS) * st.TRACKS]
        row = world.pairs.bound[i * n + block : i * n + min(block + st.TRACK_BALLS, n)]
        if world.laws.uniform:
            _meet_block(track, row, t, x, y, vx, vy, radius, own_time)
        elif powers is not None and in_air(balls.powers, world.laws):
            bent, left = jerk(balls, i), min(max(own_time - t, 0.0), FOR_EVER)
            _bent_block(track, row, t, x, y, vx, vy, ax, ay, radius, own_time, bent, left)
        else:
            _bound_block(track, row, t, x, y, vx, vy, ax, ay, radius, own_time)


@kernel
def _bound_each(world: World, i: int, t: float) -> None:
    """`_bound_row` while balls may meet in space."""
    balls = world.balls
    n = len(balls.own_kind)
    for j in range(n):
        if j != i:
            bound = first_bound(balls, world.laws, i, j, t)
            until = min(meets_until(balls, i), meets_until(balls, j))
            world.pairs.bound[i * n + j] = bound if bound <= until else math.inf


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
        s = t - track[st.TRACK_EPOCH + j]
        ax_j, ay_j = track[st.TRACK_AX + j], track[st.TRACK_AY + j]
        vx_j, vy_j = track[st.TRACK_VX + j], track[st.TRACK_VY + j]
        rx = track[st.TRACK_X + j] + displacement(vx_j, ax_j, s) - x
        ry = track[st.TRACK_Y + j] + displacement(vy_j, ay_j, s) - y
        ux, uy = speed(vx_j, ax_j, s) - vx, speed(vy_j, ay_j, s) - vy
        distance = math.sqrt(rx * rx + ry * ry)
        # All three scaled by the distance, which saves dividing by it.
        gap = distance * (distance - (radius + track[st.TRACK_RADIUS + j]))
        rate = rx * ux + ry * uy
        pull = rx * (ax_j - ax) + ry * (ay_j - ay)
        bound = t + first_crossing(gap, rate, pull)
        own_time_j = track[st.TRACK_OWN_TIME + j]
        until = own_time_j if own_time_j < own_time else own_time
        bounds[j] = bound if bound <= until else math.inf


@kernel
def _bent_block(
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
    bent: float,
    left: float,
) -> None:
    """As `_bound_block`, where a ball may be on no parabola; this one begins its piece now."""
    for j in range(len(bounds)):
        s = t - track[st.TRACK_EPOCH + j]
        ax_j, ay_j = track[st.TRACK_AX + j], track[st.TRACK_AY + j]
        vx_j, vy_j = track[st.TRACK_VX + j], track[st.TRACK_VY + j]
        own_time_j = track[st.TRACK_OWN_TIME + j]
        left_j = own_time_j - t
        left_j = left_j if left_j > 0.0 else 0.0
        bent_j = track[st.TRACK_JERK + j]
        bound = t + time_to_bent_bound(
            track[st.TRACK_X + j] + displacement(vx_j, ax_j, s) - x,
            track[st.TRACK_Y + j] + displacement(vy_j, ay_j, s) - y,
            speed(vx_j, ax_j, s) - vx,
            speed(vy_j, ay_j, s) - vy,
            ax_j - ax,
            ay_j - ay,
            radius + track[st.TRACK_RADIUS + j],
            bent_j * s,
            bent_j * s * s,
            bent_j * s * s * s,
            bent + bent_j,
            left_j if left_j < left else left,
        )
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
        s = t - track[st.TRACK_EPOCH + j]
        rx = track[st.TRACK_X + j] + s * track[st.TRACK_VX + j] - x
        ry = track[st.TRACK_Y + j] + s * track[st.TRACK_VY + j] - y
        bound = t + first_meeting(
            rx,
            ry,
            track[st.TRACK_VX + j] - vx,
            track[st.TRACK_VY + j] - vy,
            radius + track[st.TRACK_RADIUS + j],
        )
        own_time_j = track[st.TRACK_OWN_TIME + j]
        until = own_time_j if own_time_j < own_time else own_time
        bounds[j] = bound if bound <= until else math.inf


@kernel(inline=True)
def rescan(world: World, i: int) -> None:
    """Find the least bound of row i again, and ball i's next event."""
    pairs = world.pairs
    n = len(world.balls.own_kind)
    least = _least(pairs.bound[i * n : i * n + n])
    pairs.least[i] = least
    pairs.next[i] = min(least, world.balls.state[i].own_time)


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
def earliest(world: World) -> tuple[float, int, int]:
    """As `scheduling.scheduler.earliest`.

    Of several own events at one instant, one coming to rest: so a ball that has all but stopped is
    at rest before its neighbours are looked at again. Of two that touch each other and meet a
    cushion together, the first by place, not by number.
    """
    balls = world.balls
    t = _least(world.pairs.next)
    first, ties = _places(world.pairs.next, t)
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
def set_aside(world: World, i: int, j: int) -> float:
    """As `scheduling.scheduler.set_aside`: row i is as if it hadn't the pair."""
    pairs = world.pairs
    pairs.bound[i * len(pairs.least) + j] = math.inf
    rescan(world, i)
    return _least(pairs.next)


@kernel(inline=True)
def put_bound(pairs: Pairs, i: int, j: int, bound: float) -> None:
    """As `scheduling.scheduler.put_bound`."""
    pairs.bound[i * len(pairs.least) + j] = bound
    pairs.least[i] = min(pairs.least[i], bound)
    pairs.next[i] = min(pairs.next[i], bound)


@kernel(inline=True)
def next_due(pairs: Pairs, t: float, start: int) -> int:
    """As `scheduling.scheduler.next_due`."""
    for i in range(start, len(pairs.least)):
        if pairs.least[i] <= t:
            return i
    return st.NOWHERE


@kernel(inline=True)
def list_due(world: World, i: int, t: float) -> int:
    """As `scheduling.scheduler.list_due`; a pair is listed once."""
    n = len(world.pairs.least)
    other, ties = _places(world.pairs.bound[i * n : i * n + n], t)
    world.balls.near[0] = other
    return 1 if ties == 1 else _list_several(world, i, t)


@kernel
def _list_several(world: World, i: int, t: float) -> int:
    """`list_due`, where not exactly one pair is due."""
    count, n = 0, len(world.pairs.least)
    for j in range(n):
        if world.pairs.bound[i * n + j] <= t:
            world.balls.near[count] = j
            count += 1
    return count


@kernel(inline=True)
def more_due(pairs: Pairs, until: float) -> bool:
    """As `scheduling.scheduler.more_due`; true where a listed pair isn't set aside."""
    return _until(pairs.least, until) > 0


@kernel
def _until(values: FloatArray, last: float) -> int:
    """Return how many of `values` are at most `last`."""
    count = 0
    for k in range(len(values)):
        count += values[k] <= last
    return count


@kernel(inline=True)
def bound_of(pairs: Pairs, i: int, j: int) -> float:
    """As `scheduling.scheduler.bound_of`: the pair is in one of two rows."""
    n = len(pairs.least)
    bound: float = min(pairs.bound[i * n + j], pairs.bound[j * n + i])
    return bound
