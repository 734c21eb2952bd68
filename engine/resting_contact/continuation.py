"""Continuation of an island whose integrated motion has ended, if nothing else has happened.

Its members and contacts are unchanged, and no gap has a rate, so the island needn't be gathered
again. A ball that comes in contact with the island causes an event, which ends its step. The first
and the shortest step are defined here, too.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Contacts, World
from ghostball.engine.core.tolerances import TIME_ROUNDING
from ghostball.engine.motion.geometry import friction_limit, speed_of
from ghostball.engine.motion.position import advance
from ghostball.engine.resting_contact.cloth_response import slip_ends, time_to_change
from ghostball.engine.resting_contact.integrate import integrate
from ghostball.engine.resting_contact.islands import list_contact, sort_by_position
from ghostball.engine.resting_contact.paths import start_piece
from ghostball.engine.scheduling.time_of_impact import holds

_NEARLY = 1.9
"""Longest integration, relative to the time in which the cloth takes half of some slip or speed.

The integration continues nearly to the end of the slip or speed, if the error of the motion
permits.
"""

_LEAST_INTEGRATED = 2.0**-11
"""Shortest step of an integrated motion, relative to the time to move by one radius."""

_LEAST_PART = 2.0**-6
"""Shortest step of an integrated motion, relative to the time in which a slip or speed ends.

The smaller of this limit and `_LEAST_INTEGRATED` applies.
"""

_AFTER = 2.0**-4
"""First step after an integrated motion that has ended, relative to a fresh one.

Such a motion ends with a contact that parts or sticks, or with a ball that stops or starts to
slip; these changes take little time.
"""

FIRST_STEP = 2.0**-6
"""First step, relative to the time in which the cloth can move a ball by one radius."""

_SHORTEST = 2.0**-26
"""Shortest step, relative to the time in which the cloth can move a ball by one radius.

About 2 ns for pool balls. A contact with large friction between very different masses may jam: then
no forces, only shocks, are a solution. Shorter steps only increase the forces, and the work of the
forces on the rounding errors of the gaps. Such a step neglects the friction of the contacts, and is
counted in `work["unsolved_contact_steps"]`.
"""


@kernel
def continue_island(world: World, i: int, t: float) -> bool:
    """Continue ball i's island if a piece of its motion ends at t [s] and nothing else happens.

    The result is False, without any change, if the island must be gathered again.
    """
    contacts = world.contacts
    if not _is_undisturbed(world, i, t):
        return False
    if contacts.motion[i].pieces_left == 0.0:
        return _start_next_motion(world, i, t)
    k = i
    while True:
        advance(world.balls, k, t)
        start_piece(world, k)
        contacts.again[k] = False
        k = contacts.ring[k]
        if k == i:
            return True


@kernel
def _is_undisturbed(world: World, i: int, t: float) -> bool:
    """Return whether ball i's island is integrated and only a piece of its motion ends at t."""
    contacts = world.contacts
    if contacts.island[i] == st.FREE:
        return False
    k = i
    while True:
        touched = contacts.motion[k].step == 0.0 or world.balls.own_kind[k] != st.OWN_CONTACT
        if touched or contacts.motion[k].ahead <= 0.0 or world.balls.state[k].own_time != t:
            return False
        k = contacts.ring[k]
        if k == i:
            return True


@kernel
def _start_next_motion(world: World, i: int, t: float) -> bool:
    """Integrate the motion of ball i's island for another step; result as in `continue_island`."""
    contacts = world.contacts
    members, k = 0, i
    while True:
        advance(world.balls, k, t)
        contacts.member[members] = k
        members += 1
        if world.laws.slides and slip_ends(world, k):
            return False
        k = contacts.ring[k]
        if k == i:
            break
    if members > st.MOST_DIRECT:
        return False
    sort_by_position(world, members)
    count = 0
    for m in range(members):
        k = contacts.member[m]
        held = int(contacts.motion[k].held_off)
        for other in range(m + 1, members + len(world.laws.obstacles)):
            second = contacts.member[other] if other < members else members - 1 - other
            touches = holds(contacts, k, second) if second >= 0 else held >> (-1 - second) & 1 == 1
            if touches and count == st.MOST_DIRECT:
                return False
            if touches:
                count = list_contact(world, count, k, second)
    if not start_motion(world, members, count, t):
        return False
    for m in range(members):
        contacts.again[contacts.member[m]] = False
    return True


@kernel
def start_motion(world: World, members: int, count: int, t: float) -> bool:
    """Integrate the motion of the members and start it; return False if it isn't smooth."""
    contacts = world.contacts
    own_time = own_time_of(world, members)
    fresh = FIRST_STEP * own_time
    ahead = next_step(contacts, members, True, fresh, own_time)
    if not ahead > 0.0:
        return False
    far = _NEARLY * time_to_half(world, members)
    least = min(_LEAST_INTEGRATED * own_time, _LEAST_PART * far)
    shortest = shortest_step(own_time, t)
    if not integrate(world, members, count, far, least, shortest, ahead) > 0.0:
        return False
    for m in range(members):
        contacts.motion[contacts.member[m]].step = _AFTER * fresh
        start_piece(world, contacts.member[m])
    return True


@kernel
def shortest_step(own_time: float, t: float) -> float:
    """Return the shortest step [s] at the time t [s]."""
    return max(_SHORTEST * own_time, 4.0 * TIME_ROUNDING * t)


@kernel
def time_to_half(world: World, members: int) -> float:
    """Return the time [s] in which the cloth takes half of some member's slip or speed."""
    least = math.inf
    for m in range(members):
        least = min(least, time_to_change(world.balls, world.contacts.member[m]))
    return least


@kernel
def next_step(
    contacts: Contacts, members: int, integrated: bool, fresh: float, most: float
) -> float:
    """Return the step to try [s]: the shortest last step of a member; `fresh` if one has none."""
    step = most
    for m in range(members):
        row = contacts.motion[contacts.member[m]]
        last = row.ahead if integrated else row.step
        if last == 0.0:
            return min(fresh, most)
        step = min(step, last)
    return step


@kernel
def own_time_of(world: World, members: int) -> float:
    """Return the shortest time [s] in which the cloth can move a member by its radius.

    If the cloth has no friction (air alone may push balls together), return the shortest time in
    which a member moves by its radius.
    """
    balls = world.balls
    least, fastest = math.inf, math.inf
    for m in range(members):
        k = world.contacts.member[m]
        radius, speed = balls.state[k].radius, speed_of(balls.state[k].vx, balls.state[k].vy)
        if friction_limit(balls, k) > 0.0:
            least = min(least, math.sqrt(2.0 * radius / friction_limit(balls, k)))
        if speed > 0.0:
            fastest = min(fastest, radius / speed)
    return least if least < math.inf else fastest
