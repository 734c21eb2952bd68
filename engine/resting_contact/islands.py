"""Islands of balls in resting contact: find their balls and contacts, and release them."""

from __future__ import annotations

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Contacts, World
from ghostball.engine.motion.geometry import (
    list_near,
    obstacle_in_contact,
    pair_in_contact,
    stands_before,
)
from ghostball.engine.motion.next_piece import mark, predict_again
from ghostball.engine.motion.position import advance


@kernel
def release(world: World, i: int, t: float) -> None:
    """Release every ball of i's island from its contact forces at time t [s].

    Contract: each ball is then advanced to t, predicted again and marked in `balls.changed`.
    """
    balls, contacts = world.balls, world.contacts
    if contacts.island[i] == st.FREE:
        return
    k = i
    while True:
        following = contacts.ring[k]
        contacts.island[k] = st.FREE
        contacts.ring[k] = k
        _let_go(contacts, k)
        advance(balls, k, t)
        predict_again(balls, k, world.laws)
        mark(balls, k)
        k = following
        if k == i:
            return


@kernel
def _hold_to(contacts: Contacts, i: int, j: int) -> None:
    """Store that a contact step holds ball i to ball j."""
    row = contacts.free[contacts.free[0]]
    contacts.free[0] -= 1
    contacts.held[row, st.PARTNER] = j
    contacts.held[row, st.NEXT] = contacts.first_held[i]
    contacts.first_held[i] = row


@kernel
def _let_go(contacts: Contacts, i: int) -> None:
    """Store that no contact step holds ball i to another ball."""
    row = contacts.first_held[i]
    while row != st.NOWHERE:
        contacts.free[0] += 1
        contacts.free[contacts.free[0]] = row
        row = contacts.held[row, st.NEXT]
    contacts.first_held[i] = st.NOWHERE


@kernel
def mark_again(contacts: Contacts, k: int) -> None:
    """Mark ball k, because its island starts a new step."""
    if not contacts.again[k]:
        contacts.again[k] = True
        contacts.waiting[0] += 1
        contacts.waiting[contacts.waiting[0]] = k


@kernel
def gather_members(world: World, i: int, listed: int, t: float) -> int:
    """Put in `contacts.member` ball i and all balls connected to it by contacts.

    The first `listed` rows of `balls.touching` count as contacts, whatever their gap. Return the
    number of members.
    """
    balls, contacts = world.balls, world.contacts
    release(world, i, t)
    contacts.member[0] = i
    members, m = 1, 0
    _join(world, i, i, t)
    while m < members:
        k = contacts.member[m]
        for c in range(list_near(balls, world.cells, k)):
            other = balls.near[c]
            if contacts.island[other] == i:
                continue
            if pair_in_contact(balls, k, other, t) or _is_listed(balls, listed, k, other):
                release(world, other, t)
                _join(world, other, i, t)
                contacts.member[members] = other
                members += 1
        m += 1
    sort_by_position(world, members)
    return members


@kernel
def _is_listed(balls: Balls, listed: int, i: int, j: int) -> bool:
    """Return whether the contact of i and j is in the first `listed` rows of `balls.touching`.

    i is a ball; j is a ball, or -1 minus the row of an obstacle.
    """
    for c in range(listed):
        a, b = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]
        if (a == i and b == j) or (a == j and b == i):
            return True
    return False


@kernel
def sort_by_position(world: World, members: int) -> None:
    """Sort the members by position, so that results don't depend on the numbering of the balls."""
    contacts = world.contacts
    for m in range(1, members):
        k, index = contacts.member[m], m
        while index > 0 and stands_before(world.balls, k, contacts.member[index - 1]):
            contacts.member[index] = contacts.member[index - 1]
            index -= 1
        contacts.member[index] = k


@kernel
def _join(world: World, k: int, label: int, t: float) -> None:
    balls, contacts = world.balls, world.contacts
    advance(balls, k, t)
    predict_again(balls, k, world.laws)
    contacts.island[k] = label
    if k != label:
        contacts.ring[k] = contacts.ring[label]
        contacts.ring[label] = k
    mark(balls, k)


@kernel
def gather_contacts(world: World, members: int, listed: int, t: float) -> int:
    """List the contacts of the members with each other and with cushions; return their number.

    If there are more than fit in `contacts`, NO_ROOM is set.
    """
    balls, contacts = world.balls, world.contacts
    count = 0
    for m in range(members):
        k = contacts.member[m]
        for other in range(m + 1, members):
            partner = contacts.member[other]
            if _is_listed(balls, listed, k, partner) or pair_in_contact(balls, k, partner, t):
                if contacts.free[0] < 2:
                    world.log.counters[st.NO_ROOM] = 1
                    return count
                count = list_contact(world, count, k, partner)
                _hold_to(contacts, k, partner)
                _hold_to(contacts, partner, k)
        for cushion in range(len(world.laws.obstacles)):
            listed_here = _is_listed(balls, listed, k, -1 - cushion)
            if listed_here or obstacle_in_contact(balls, k, world.laws, cushion):
                count = list_contact(world, count, k, -1 - cushion)
    return count


@kernel
def list_contact(world: World, count: int, k: int, other: int) -> int:
    """Put a contact of ball k into row `count` of `contacts.ends`; return the number of rows.

    If there is no room, NO_ROOM is set, and the loop ends the run.
    """
    contacts = world.contacts
    if count == contacts.ends.shape[0]:
        world.log.counters[st.NO_ROOM] = 1
        return count
    contacts.ends[count, st.FIRST] = k
    contacts.ends[count, st.SECOND] = other
    return count + 1
