"""What becomes of bounds that are due: which pairs touch, which hit first, and which together.

One judgement for both schedulers, so that few balls and many come to the same bits. A bound is no
contact yet: a pair is judged where its balls are at that instant, and where it doesn't touch, it
has a later bound (conservative advancement).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import World
from ghostball.engine.motion.flight import meets_in_space
from ghostball.engine.motion.geometry import list_near, tie_rounding
from ghostball.engine.motion.position import meets_until
from ghostball.engine.scheduling.scheduler import (
    bound_of,
    list_due,
    more_due,
    next_due,
    put_bound,
    set_aside,
)
from ghostball.engine.scheduling.ties import (
    comes_before,
    has_room,
    is_pair_listed,
    list_pair,
    sort_pairs,
    when_tied,
)
from ghostball.engine.scheduling.time_of_impact import IMPACT, LASTING, NOT_YET, touch


class Event(NamedTuple):
    """What happens next: one ball's own event, or pairs that touch.

    `judged` isn't counted yet: an event that waits for `Contacts` is resolved twice.
    """

    t: float  # [s]; inf: nothing does
    ball: int  # whose own event it is, or -1
    pairs: int  # how many pairs touch: the first rows of `balls.touching`, by their indices
    verdict: int  # of these pairs, IMPACT or LASTING
    judged: int  # pairs that were found to touch, also those that wait for the fastest


@kernel(inline=True)
def own_event(t: float, ball: int) -> Event:
    """Return the event that a ball has of its own at the instant t [s]; or none, where it is -1."""
    return Event(t, ball, 0, NOT_YET, 0)


@kernel(inline=True)
def touching(world: World, t: float, row: int) -> Event:
    """Judge every pair whose bound is the instant t [s]; `earliest` returned t and `row`.

    Return the first that touch, if nothing else comes before: all that approach, or the fastest of
    them where impacts are sequential; or else all whose contact lasts. Return an event at inf where
    those bounds have moved on. More than there is room for leave NO_ROOM.
    """
    if row >= 0 and list_due(world, row, t) == 1:
        partner = int(world.balls.near[0])
        return _judge_one(world, row, partner, t)
    return _judge_several(world, t)


@kernel(inline=True)
def _judge_one(world: World, i: int, j: int, t: float) -> Event:
    """Advance one pair from its bound t [s] until it touches, or something else comes first."""
    balls, laws, counters = world.balls, world.laws, world.log.counters
    until = min(set_aside(world, i, j), laws.t_max)
    end = min(meets_until(balls, i), meets_until(balls, j))
    verdict, bound, speed = NOT_YET, t, 0.0
    while True:
        verdict, bound, speed = touch(balls, laws, i, j, t, 0.0)
        if verdict != NOT_YET:
            break
        counters[st.ADVANCEMENTS] += 1
        counters[st.WORK] += 1
        bound = bound if bound <= end else math.inf
        if not bound < until or counters[st.WORK] >= counters[st.PAUSE_AT]:
            break
        t = bound
    count = 1
    if verdict != NOT_YET:
        list_pair(balls, 0, i, j)
        if (
            verdict == IMPACT
            and laws.simultaneous
            and not meets_in_space(balls.height, balls, i, j)
        ):
            tied = t + tie_rounding(balls, i, j, t) / speed
            if until <= tied and more_due(world, 1, t, tied):
                count = _join_ties(world, t, tied, 1)
    put_bound(world, i, j, bound, t)
    return Event(t if verdict != NOT_YET else math.inf, -1, count, verdict, 1)


@kernel
def _judge_several(world: World, t: float) -> Event:
    """Judge all pairs whose bound is the instant t [s], as `touching`.

    Of sequential impacts the fastest first, then by place. For impacts at one instant that feed
    each other (an inelastic one with a frozen line) then die out like a relaxation of the whole
    line, not of its end over and over. Impacts of balls in the air, or of different size where they
    may fly, are sequential always, and come after those in the plane.
    """
    balls, laws = world.balls, world.laws
    count, lasting, judged, fastest = 0, 0, 0, 0.0
    above, other, highest = st.NOWHERE, st.NOWHERE, 0.0
    last = balls.touching.shape[0]
    i = next_due(world, t, 0)
    while i != st.NOWHERE:
        for c in range(list_due(world, i, t)):
            j = int(balls.near[c])
            if is_pair_listed(balls, 0, count, i, j):
                continue
            if is_pair_listed(balls, last - lasting, last, i, j):
                continue
            verdict, bound, speed = touch(balls, laws, i, j, t, 0.0)
            if verdict == NOT_YET:
                world.log.counters[st.ADVANCEMENTS] += 1
                world.log.counters[st.WORK] += 1
                end = min(meets_until(balls, i), meets_until(balls, j))
                bound = bound if bound <= end else math.inf
                set_aside(world, i, j)
                put_bound(world, i, j, bound, t)
                continue
            judged += 1
            if not has_room(world, count, lasting):
                return Event(t, -1, count, IMPACT, judged)
            if verdict == LASTING:
                # From the other end, out of the way of impacts.
                lasting += 1
                list_pair(balls, last - lasting, i, j)
            elif laws.simultaneous and meets_in_space(balls.height, balls, i, j):
                if speed > highest:
                    above, other, highest = i, j, speed
            elif laws.simultaneous or comes_before(balls, count, speed, fastest, i, j, t):
                count = count + 1 if laws.simultaneous else 1
                fastest = max(speed, fastest)
                list_pair(balls, count - 1, i, j)
        i = next_due(world, t, i + 1)
    if count == 0 and above != st.NOWHERE:
        list_pair(balls, 0, above, other)
        return Event(t, -1, 1, IMPACT, judged)
    if count == 0:
        for c in range(lasting):
            list_pair(
                balls,
                c,
                balls.touching[last - 1 - c, st.FIRST],
                balls.touching[last - 1 - c, st.SECOND],
            )
        sort_pairs(balls, lasting)
        return Event(t if lasting > 0 else math.inf, -1, lasting, LASTING, judged)
    sort_pairs(balls, count)
    if laws.simultaneous:
        tied = when_tied(balls, count, t, fastest)
        if more_due(world, count, t, tied):
            count = _join_ties(world, t, tied, count)
    return Event(t, -1, count, IMPACT, judged)


@kernel
def _join_ties(world: World, t: float, until: float, listed: int) -> int:
    """List also the pairs that share a ball with a listed one, and touch too but for rounding.

    Their bounds are past the instant t, and no later than `until` [s]. Which of the gaps closes
    first is then noise: a symmetric collision with two touching balls would be resolved one after
    the other where coordinates are rounded. Return how many are listed now.
    """
    balls = world.balls
    count = listed
    for c in range(listed):
        for i in (balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]):
            for k in range(list_near(balls, world.cells, i)):
                j = int(balls.near[k])
                if is_pair_listed(balls, 0, count, i, j):
                    continue
                if meets_in_space(balls.height, balls, i, j):
                    continue
                bound = bound_of(world, i, j, t)
                if not t < bound <= until:
                    continue
                verdict, _, _ = touch(balls, world.laws, i, j, t, tie_rounding(balls, i, j, t))
                if verdict == IMPACT:
                    if not has_room(world, count, 0):
                        return count
                    list_pair(balls, count, i, j)
                    count += 1
    sort_pairs(balls, count)
    return count
