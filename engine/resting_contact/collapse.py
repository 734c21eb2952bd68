"""End an inelastic collapse: one set of impulses replaces its endless impacts."""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Contacts, World
from ghostball.engine.motion.flight import meets_in_space
from ghostball.engine.motion.geometry import contact_tolerance, list_near
from ghostball.engine.motion.next_piece import mark
from ghostball.engine.motion.obstacles import facing, nose_reach
from ghostball.engine.motion.position import advance, pair_reach, relative_motion
from ghostball.engine.resting_contact.capture import stop_approach
from ghostball.engine.resting_contact.islands import list_contact, sort_by_position


@kernel
def end_collapse(world: World, i: int, t: float) -> None:
    """End every approach among the balls that touch ball i, directly or through other balls.

    The impulses are inelastic and are computed together. They replace the impacts that would follow
    each other endlessly at the time t [s]. A collapse counts as a joint impact.

    Contract: the balls of the cluster are advanced to t and marked in `balls.changed`. No
    allocation. If some approach remains, the collapse counts as an unsolved joint impact. If the
    cluster has more contacts than fit in `contacts`, NO_ROOM is set.
    """
    balls, contacts = world.balls, world.contacts
    members, m = 0, 0
    members = _join(world, i, members, t)
    while m < members:
        k = contacts.member[m]
        m += 1
        for c in range(list_near(balls, world.cells, k)):
            other = int(balls.near[c])
            if not _is_member(contacts, other, members) and _touch(balls, k, other, t):
                members = _join(world, other, members, t)
    sort_by_position(world, members)
    count = _list_contacts(world, members, t)
    counters = world.log.counters
    counters[st.WORK] += members * (members + len(world.laws.obstacles))
    counters[st.JOINT_IMPACTS] += 1
    if not stop_approach(world, members, count, False):
        counters[st.UNSOLVED_JOINT_IMPACTS] += 1


@kernel
def _join(world: World, k: int, members: int, t: float) -> int:
    """Append ball k to the members; return their number."""
    advance(world.balls, k, t)
    mark(world.balls, k)
    world.contacts.member[members] = k
    world.contacts.motion[k].index = members
    return members + 1


@kernel(inline=True)
def _is_member(contacts: Contacts, k: int, members: int) -> bool:
    """Return whether ball k is a member; its `index` may be outdated."""
    index = int(contacts.motion[k].index)
    return bool(index < members and contacts.member[index] == k)


@kernel
def _touch(balls: Balls, i: int, j: int, t: float) -> bool:
    """Return whether balls i and j, on the cloth, touch at t [s] within the contact tolerance."""
    gone = st.GONE in (balls.state[i].phase, balls.state[j].phase)
    if gone or meets_in_space(balls, i, j):
        return False
    rx, ry, _, _, _, _ = relative_motion(balls, i, j, t)
    gap = math.sqrt(rx * rx + ry * ry) - pair_reach(balls, i, j)
    return gap <= contact_tolerance(balls, i, j)


@kernel
def _list_contacts(world: World, members: int, t: float) -> int:
    """List the contacts of the members with each other and with obstacles; return their number.

    If there are more than fit in `contacts`, NO_ROOM is set.
    """
    balls, contacts, laws = world.balls, world.contacts, world.laws
    count = 0
    for m in range(members):
        k = contacts.member[m]
        for other in range(m + 1, members):
            if _touch(balls, k, contacts.member[other], t):
                count = list_contact(world, count, k, contacts.member[other])
        for row in range(len(laws.obstacles)):
            _, _, away = facing(laws, row, balls.state[k].x, balls.state[k].y)
            gap = away - nose_reach(balls, k, laws, row)
            touches = gap <= contact_tolerance(balls, k, k)
            if touches and laws.obstacles[row].law != st.TAKES_OUT:
                count = list_contact(world, count, k, -1 - row)
    return count
