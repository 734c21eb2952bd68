"""Islands: which balls are in contact with each other, and where; and how they are set free."""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    FIRST,
    FREE,
    NEXT,
    NO_ROOM,
    NOWHERE,
    PARTNER,
    SECOND,
    Balls,
    Cells,
    Contacts,
    IntArray,
    Laws,
)
from ghostball.engine.motion.geometry import (
    list_near,
    obstacle_in_contact,
    pair_in_contact,
    stands_before,
)
from ghostball.engine.motion.next_piece import mark, predict_again
from ghostball.engine.motion.position import advance


@kernel
def release(balls: Balls, laws: Laws, contacts: Contacts, i: int, t: float) -> None:
    """Take the contact forces off every ball of i's cluster at the instant t [s].

    Contract: all of them are advanced to t, predicted anew and marked in `balls.changed`.
    """
    if contacts.cluster[i] == FREE:
        return
    k = i
    while True:
        following = contacts.ring[k]
        contacts.cluster[k] = FREE
        contacts.ring[k] = k
        _let_go(contacts, k)
        advance(balls, k, t)
        predict_again(balls, k, laws)
        mark(balls, k)
        k = following
        if k == i:
            return


@kernel
def _hold_to(contacts: Contacts, i: int, j: int) -> None:
    """Note that a contact step holds ball i to ball j."""
    row = contacts.free[contacts.free[0]]
    contacts.free[0] -= 1
    contacts.held[row, PARTNER] = j
    contacts.held[row, NEXT] = contacts.first_held[i]
    contacts.first_held[i] = row


@kernel
def _let_go(contacts: Contacts, i: int) -> None:
    """Note that no contact step holds ball i to another."""
    row = contacts.first_held[i]
    while row != NOWHERE:
        contacts.free[0] += 1
        contacts.free[contacts.free[0]] = row
        row = contacts.held[row, NEXT]
    contacts.first_held[i] = NOWHERE


@kernel
def mark_again(contacts: Contacts, k: int) -> None:
    """Note that ball k's cluster is to be pressed anew."""
    if not contacts.again[k]:
        contacts.again[k] = True
        contacts.waiting[0] += 1
        contacts.waiting[contacts.waiting[0]] = k


@kernel
def gather_members(
    balls: Balls,
    laws: Laws,
    cells: Cells | None,
    contacts: Contacts,
    i: int,
    listed: int,
    t: float,
) -> int:
    """Put in `contacts.member` ball i and all in contact with a member; return how many.

    The first `listed` rows of `balls.hits` are contacts, close or not.
    """
    release(balls, laws, contacts, i, t)
    contacts.member[0] = i
    members, m = 1, 0
    _join(balls, laws, contacts, i, i, t)
    while m < members:
        k = contacts.member[m]
        for c in range(list_near(balls, cells, k)):
            other = balls.near[c]
            if contacts.cluster[other] == i:
                continue
            if pair_in_contact(balls, k, other, t) or _is_listed(balls, listed, k, other):
                release(balls, laws, contacts, other, t)
                _join(balls, laws, contacts, other, i, t)
                contacts.member[members] = other
                members += 1
        m += 1
    sort_by_place(balls, contacts, members)
    return members


@kernel
def _is_listed(balls: Balls, listed: int, i: int, j: int) -> bool:
    """Whether ball i and j, a ball or -1 minus an obstacle's row, are in `balls.hits`."""
    for c in range(listed):
        a, b = balls.hits[c, FIRST], balls.hits[c, SECOND]
        if (a == i and b == j) or (a == j and b == i):
            return True
    return False


@kernel
def sort_by_place(balls: Balls, contacts: Contacts, members: int) -> None:
    """Put the members in the order of their places, so that their numbering doesn't matter."""
    for m in range(1, members):
        k, place = contacts.member[m], m
        while place > 0 and stands_before(balls, k, contacts.member[place - 1]):
            contacts.member[place] = contacts.member[place - 1]
            place -= 1
        contacts.member[place] = k


@kernel
def _join(balls: Balls, laws: Laws, contacts: Contacts, k: int, label: int, t: float) -> None:
    advance(balls, k, t)
    predict_again(balls, k, laws)
    contacts.cluster[k] = label
    if k != label:
        contacts.ring[k] = contacts.ring[label]
        contacts.ring[label] = k
    mark(balls, k)


@kernel
def gather_contacts(
    balls: Balls,
    laws: Laws,
    contacts: Contacts,
    members: int,
    listed: int,
    t: float,
    counters: IntArray,
) -> int:
    """List the contacts of the members with each other and with cushions; return how many.

    Where there are more than `contacts` has room for, NO_ROOM says so.
    """
    count = 0
    for m in range(members):
        k = contacts.member[m]
        for other in range(m + 1, members):
            partner = contacts.member[other]
            if _is_listed(balls, listed, k, partner) or pair_in_contact(balls, k, partner, t):
                if not _has_room(contacts, count, counters):
                    return count
                contacts.ends[count, FIRST] = k
                contacts.ends[count, SECOND] = partner
                _hold_to(contacts, k, partner)
                _hold_to(contacts, partner, k)
                count += 1
        for cushion in range(len(laws.obstacles)):
            listed_here = _is_listed(balls, listed, k, -1 - cushion)
            if listed_here or obstacle_in_contact(balls, k, laws, cushion):
                if not _has_room(contacts, count, counters):
                    return count
                contacts.ends[count, FIRST] = k
                contacts.ends[count, SECOND] = -1 - cushion
                count += 1
    return count


@kernel
def _has_room(contacts: Contacts, count: int, counters: IntArray) -> bool:
    """Whether `contacts` takes one more than `count` contacts of a cluster, which holds two balls.

    Where it doesn't, NO_ROOM says so, and the loop ends the run.
    """
    if count < contacts.ends.shape[0] and contacts.free[0] >= 2:
        return True
    counters[NO_ROOM] = 1
    return False
