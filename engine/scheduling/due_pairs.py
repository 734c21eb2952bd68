"""Decide which pairs with an expired bound touch, which collide first, and which simultaneously.

Both schedulers use this code, so the results are bit-identical for any number of balls. An expired
bound is not a contact. The pair is checked at its positions at that time and, if it doesn't touch,
gets a later bound (conservative advancement).
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
    """Next event: the own event of a ball, or pairs that touch.

    `judged` isn't added to the counters yet: if `Contacts` is too small for an event, the event is
    resolved twice.
    """

    t: float  # [s]; inf: no event
    ball: int  # ball of an own event, or -1
    pairs: int  # number of touching pairs: first rows of `balls.touching`, sorted by index
    verdict: int  # IMPACT or LASTING, for these pairs
    judged: int  # number of pairs found to touch, including those that wait for the fastest


@kernel(inline=True)
def own_event(t: float, ball: int) -> Event:
    """Return the own event of a ball at time t [s]; an event of no ball if `ball` is -1."""
    return Event(t, ball, 0, NOT_YET, 0)


@kernel(inline=True)
def touching(world: World, t: float, row: int) -> Event:
    """Check every pair whose bound is t [s]; `earliest` returned t and `row`.

    Return the first pairs that touch, if no other event comes before. They are all approaching
    pairs, or only the fastest if impacts are sequential. Without approaching pairs, they are all
    pairs in resting contact. Return an event at inf if no pair touches, so that all bounds became
    later. If the pairs don't fit into `balls.touching`, set NO_ROOM.
    """
    if row >= 0 and list_due(world, row, t) == 1:
        partner = int(world.balls.near[0])
        return _judge_one(world, row, partner, t)
    return _judge_several(world, t)


@kernel(inline=True)
def _judge_one(world: World, i: int, j: int, t: float) -> Event:
    """Advance the bound t [s] of one pair until the pair touches, or another event comes first."""
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
        if verdict == IMPACT and laws.simultaneous and not meets_in_space(balls, i, j):
            tied = t + tie_rounding(balls, i, j, t) / speed
            if until <= tied and more_due(world, 1, t, tied):
                count = _join_ties(world, t, tied, 1)
    put_bound(world, i, j, bound, t)
    return Event(t if verdict != NOT_YET else math.inf, -1, count, verdict, 1)


@kernel
def _judge_several(world: World, t: float) -> Event:
    """Check all pairs whose bound is t [s], as `touching` does.

    Sequential impacts are resolved in order of approach speed, then of position. Simultaneous
    impacts that cause each other (for example an inelastic hit on a frozen line of balls) then die
    out along the whole line, instead of repeating at its end. Impacts in the air, and impacts of
    balls of different size that may leave the cloth, are always sequential and come after those in
    the plane.
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
                # Resting contacts are listed from the other end, apart from impacts.
                lasting += 1
                list_pair(balls, last - lasting, i, j)
            elif laws.simultaneous and meets_in_space(balls, i, j):
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
    """List also the pairs that share a ball with a listed pair and touch within rounding.

    Their bounds are later than t, and at most `until` [s]. Rounding decides which of these gaps
    closes first: without this function, a symmetric collision with two touching balls would be
    resolved as two impacts in sequence. Return the number of listed pairs.
    """
    balls = world.balls
    count = listed
    for c in range(listed):
        for i in (balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]):
            for k in range(list_near(balls, world.cells, i)):
                j = int(balls.near[k])
                if is_pair_listed(balls, 0, count, i, j):
                    continue
                if meets_in_space(balls, i, j):
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
