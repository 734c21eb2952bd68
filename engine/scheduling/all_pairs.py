"""Scheduler for few balls: stores a lower bound on the time of impact of every pair.

The bound of a pair is the time at which its relative motion, projected on the present line of
centres, closes the gap. This time is the first root of a quadratic. It is never later than the
contact, which is a root of a quartic. If the bound of a pair becomes the earliest of all, it is
computed again from the positions at that time (conservative advancement). These bounds converge
quadratically, and never pass a contact.

Each pair is stored once, in the row of the ball that was updated last. A bound later than the next
own event of either ball is dropped: that event changes the motion and updates the row. If a motion
isn't a parabola, a limit on its jerk makes the bound earlier. If nothing slows the balls, the root
is the contact time itself.

`scheduling.broad_phase` is the other scheduler; `scheduling.scheduler` is their common interface.
"""

from __future__ import annotations

import math
from typing import NamedTuple

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


class _Moving(NamedTuple):
    """Motion of a ball at a time, and the other numbers that bounds of its pairs need."""

    x: float  # [m]
    y: float
    vx: float  # [m/s]
    vy: float
    ax: float  # [m/s^2]
    ay: float
    radius: float  # [m]
    own_time: float  # time until which it may hit other balls [s]


@kernel(inline=True)
def update(world: World, t: float) -> None:
    """Recompute the bounds of the balls in `balls.touched`, whose motion changed at t [s]."""
    balls = world.balls
    for m in range(balls.touched[0]):
        _track(world, balls.touched[1 + m])
    for m in range(balls.touched[0]):
        _update_ball(world, balls.touched[1 + m], t)
    world.log.counters[st.BOUNDS] += balls.touched[0] * (len(balls.own_kind) - 1)


@kernel(inline=True)
def _track(world: World, i: int) -> None:
    """Copy the numbers of ball i that bounds need to `pairs.track`."""
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
    if balls.powers is not None:
        pairs.track[at + st.TRACK_JERK] = jerk(balls, i)


@kernel(inline=True)
def _update_ball(world: World, i: int, t: float) -> None:
    """Recompute all bounds of ball i in its row, and delete them from the other rows."""
    balls, pairs, contacts = world.balls, world.pairs, world.contacts
    n = len(balls.own_kind)
    _bound_row(world, i, t)
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
def _bound_row(world: World, i: int, t: float) -> None:
    """Put in row i the earliest times after t [s] at which ball i can touch each other ball."""
    balls = world.balls
    n = len(balls.own_kind)
    if balls.height is not None and may_meet_in_space(balls):
        _bound_each(world, i, t)
        return
    (x, y), (vx, vy) = position_at(balls, i, t), velocity(balls, i, t)
    own_time = meets_until(balls, i)
    ball = balls.state[i]
    one = _Moving(x, y, vx, vy, ball.ax, ball.ay, ball.radius, own_time)
    for block in range(0, n, st.TRACK_BALLS):
        track = world.pairs.track[block * st.TRACKS : (block + st.TRACK_BALLS) * st.TRACKS]
        row = world.pairs.bound[i * n + block : i * n + min(block + st.TRACK_BALLS, n)]
        if world.laws.uniform:
            _meet_block(track, row, t, one)
        elif balls.powers is not None and in_air(balls, world.laws):
            bent, left = jerk(balls, i), min(max(own_time - t, 0.0), FOR_EVER)
            _bent_block(track, row, t, one, bent, left)
        else:
            _bound_block(track, row, t, one)


@kernel
def _bound_each(world: World, i: int, t: float) -> None:
    """Do the same as `_bound_row` if balls may meet above the cloth."""
    balls = world.balls
    n = len(balls.own_kind)
    for j in range(n):
        if j != i:
            bound = first_bound(balls, world.laws, i, j, t)
            until = min(meets_until(balls, i), meets_until(balls, j))
            world.pairs.bound[i * n + j] = bound if bound <= until else math.inf


@kernel
def _bound_block(track: FloatArray, bounds: FloatArray, t: float, one: _Moving) -> None:
    """Put in `bounds` the earliest times at which a ball can touch each ball of a block of `track`.

    `one` is the ball at time t [s]. A time is inf if the two can't touch; the entry for the ball
    itself is meaningless. The code repeats `relative_motion` and `first_crossing` without branches,
    so that the compiler can vectorise the loop. The results are bit-identical.
    """
    for j in range(len(bounds)):
        s = t - track[st.TRACK_EPOCH + j]
        ax_j, ay_j = track[st.TRACK_AX + j], track[st.TRACK_AY + j]
        vx_j, vy_j = track[st.TRACK_VX + j], track[st.TRACK_VY + j]
        rx = track[st.TRACK_X + j] + displacement(vx_j, ax_j, s) - one.x
        ry = track[st.TRACK_Y + j] + displacement(vy_j, ay_j, s) - one.y
        ux, uy = speed(vx_j, ax_j, s) - one.vx, speed(vy_j, ay_j, s) - one.vy
        distance = math.sqrt(rx * rx + ry * ry)
        # All three are multiplied by the distance, which saves divisions.
        gap = distance * (distance - (one.radius + track[st.TRACK_RADIUS + j]))
        rate = rx * ux + ry * uy
        pull = rx * (ax_j - one.ax) + ry * (ay_j - one.ay)
        bound = t + first_crossing(gap, rate, pull)
        own_time_j = track[st.TRACK_OWN_TIME + j]
        until = own_time_j if own_time_j < one.own_time else one.own_time
        bounds[j] = bound if bound <= until else math.inf


@kernel
def _bent_block(
    track: FloatArray, bounds: FloatArray, t: float, one: _Moving, bent: float, left: float
) -> None:
    """Do the same as `_bound_block` for motions with jerk; the given ball's piece starts at t."""
    for j in range(len(bounds)):
        s = t - track[st.TRACK_EPOCH + j]
        ax_j, ay_j = track[st.TRACK_AX + j], track[st.TRACK_AY + j]
        vx_j, vy_j = track[st.TRACK_VX + j], track[st.TRACK_VY + j]
        own_time_j = track[st.TRACK_OWN_TIME + j]
        left_j = own_time_j - t
        left_j = left_j if left_j > 0.0 else 0.0
        bent_j = track[st.TRACK_JERK + j]
        bound = t + time_to_bent_bound(
            track[st.TRACK_X + j] + displacement(vx_j, ax_j, s) - one.x,
            track[st.TRACK_Y + j] + displacement(vy_j, ay_j, s) - one.y,
            speed(vx_j, ax_j, s) - one.vx,
            speed(vy_j, ay_j, s) - one.vy,
            ax_j - one.ax,
            ay_j - one.ay,
            one.radius + track[st.TRACK_RADIUS + j],
            bent_j * s,
            bent_j * s * s,
            bent_j * s * s * s,
            bent + bent_j,
            left_j if left_j < left else left,
        )
        until = own_time_j if own_time_j < one.own_time else one.own_time
        bounds[j] = bound if bound <= until else math.inf


@kernel
def _meet_block(track: FloatArray, bounds: FloatArray, t: float, one: _Moving) -> None:
    """Put in `bounds` when a ball touches each ball of a block of `track`, if nothing slows balls.

    Like `_bound_block`. The squared distance of two centres in uniform motion is a quadratic in
    time, so its root is the contact time itself rather than a bound.
    """
    for j in range(len(bounds)):
        s = t - track[st.TRACK_EPOCH + j]
        rx = track[st.TRACK_X + j] + s * track[st.TRACK_VX + j] - one.x
        ry = track[st.TRACK_Y + j] + s * track[st.TRACK_VY + j] - one.y
        bound = t + first_meeting(
            rx,
            ry,
            track[st.TRACK_VX + j] - one.vx,
            track[st.TRACK_VY + j] - one.vy,
            one.radius + track[st.TRACK_RADIUS + j],
        )
        own_time_j = track[st.TRACK_OWN_TIME + j]
        until = own_time_j if own_time_j < one.own_time else one.own_time
        bounds[j] = bound if bound <= until else math.inf


@kernel(inline=True)
def rescan(world: World, i: int) -> None:
    """Find the smallest bound of row i, and the time of the next event of ball i."""
    pairs = world.pairs
    n = len(world.balls.own_kind)
    least = _least(pairs.bound[i * n : i * n + n])
    pairs.least[i] = least
    pairs.next[i] = min(least, world.balls.state[i].own_time)


@kernel
def _least(values: FloatArray) -> float:
    """Return the smallest of `values`, from four minima that the processor computes in parallel."""
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
    """Implement `scheduling.scheduler.earliest`.

    If several own events have the same time, a ball that comes to rest is first
    (`takes_precedence`). So a ball that has almost stopped is at rest before its neighbours are
    checked again. If two touching balls reach a cushion simultaneously, their positions decide
    which event is first, not their indices.
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
    """Return the index of the first entry equal to `value`, and the number of equal entries."""
    count = 0
    for k in range(len(values)):
        count += values[k] == value
    first = 0
    while first < len(values) - 1 and values[first] != value:
        first += 1
    return first, count


@kernel(inline=True)
def set_aside(world: World, i: int, j: int) -> float:
    """Implement `scheduling.scheduler.set_aside`: delete the pair from row i."""
    pairs = world.pairs
    pairs.bound[i * len(pairs.least) + j] = math.inf
    rescan(world, i)
    return _least(pairs.next)


@kernel(inline=True)
def put_bound(pairs: Pairs, i: int, j: int, bound: float) -> None:
    """Implement `scheduling.scheduler.put_bound`."""
    pairs.bound[i * len(pairs.least) + j] = bound
    pairs.least[i] = min(pairs.least[i], bound)
    pairs.next[i] = min(pairs.next[i], bound)


@kernel(inline=True)
def next_due(pairs: Pairs, t: float, start: int) -> int:
    """Implement `scheduling.scheduler.next_due`."""
    for i in range(start, len(pairs.least)):
        if pairs.least[i] <= t:
            return i
    return st.NOWHERE


@kernel(inline=True)
def list_due(world: World, i: int, t: float) -> int:
    """Implement `scheduling.scheduler.list_due`; each pair is listed once."""
    n = len(world.pairs.least)
    other, ties = _places(world.pairs.bound[i * n : i * n + n], t)
    world.balls.near[0] = other
    return 1 if ties == 1 else _list_several(world, i, t)


@kernel
def _list_several(world: World, i: int, t: float) -> int:
    """Do the same as `list_due` if none or several pairs are due."""
    count, n = 0, len(world.pairs.least)
    for j in range(n):
        if world.pairs.bound[i * n + j] <= t:
            world.balls.near[count] = j
            count += 1
    return count


@kernel(inline=True)
def more_due(pairs: Pairs, until: float) -> bool:
    """Implement `scheduling.scheduler.more_due`; also true if a listed pair wasn't set aside."""
    return _until(pairs.least, until) > 0


@kernel
def _until(values: FloatArray, last: float) -> int:
    """Return the number of `values` that are at most `last`."""
    count = 0
    for k in range(len(values)):
        count += values[k] <= last
    return count


@kernel(inline=True)
def bound_of(pairs: Pairs, i: int, j: int) -> float:
    """Implement `scheduling.scheduler.bound_of`: the pair is in the row of one of its balls."""
    n = len(pairs.least)
    bound: float = min(pairs.bound[i * n + j], pairs.bound[j * n + i])
    return bound
