"""Sustained contact, the whole of it: balls that friction presses together move as one cluster.

Two balls that roll side by side in contact, in slightly different directions, are slowed along
different lines, and so may be pressed together. Bouncing, they would meet again and again with
vanishing speed: without end for a restitution below 1. Instead a contact force holds each gap of
the cluster closed for as long as it has to push.

That motion isn't polynomial, because the line of centres and the direction of friction turn. While
every contact pushes and no slip ends, it is followed far, to high order (`resting_contact.follow`).
What happens between, where a contact parts or sticks, a ball stops or starts to slip, is taken
across in steps of constant acceleration, each as long as keeps every gap within `CONTACT_TOLERANCE`
diameters (4e-13 m for pool balls), checked on the very polynomials that the balls then follow, at
the step's end and seven times within. Normals and friction are taken at the middle of the step, so
that its error is third order in its length. The forces come from the one solver of contacts
(`impacts.contact_solver`), on the gaps at the end of the step. No ball is displaced. Impulses are
plastic, and a force works on a gap that stays within the tolerance: what energy that could add is
far below what friction takes in the same step.

A ball so slow that the cloth would stop it within `CAPTURE_HEIGHT` is brought to rest by the end of
its step, unless it is pushed harder than mu m g.

Each step is counted in `work["contact_steps"]`. A motion that is followed goes along its step in
pieces, for which no force is sought: those after the first are counted in `work["contact_pieces"]`.
"""

from __future__ import annotations

import math

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    AHEAD,
    CONTACT_PIECES,
    CONTACT_STEPS,
    FIRST,
    FORCE,
    FREE,
    LEFT,
    NEW_AX,
    NEW_AY,
    NEW_BX,
    NEW_BY,
    OWN_CONTACT,
    OWN_REST,
    SECOND,
    SLIDING,
    SLIPS,
    STEP,
    TWIST_Z,
    UNSOLVED_STEPS,
    Balls,
    Cells,
    Contacts,
    IntArray,
    Laws,
)
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.motion.geometry import at_rest, speed_of, stands_before
from ghostball.engine.motion.next_piece import (
    loosen,
    mark,
    predict_again,
    predict_obstacles,
)
from ghostball.engine.motion.position import advance, straighten
from ghostball.engine.resting_contact.capture import stop_approach
from ghostball.engine.resting_contact.cloth_response import keep_still, settle, stopping
from ghostball.engine.resting_contact.forces import solve
from ghostball.engine.resting_contact.going_on import (
    FIRST_STEP,
    follow_on,
    goes_on,
    next_step,
    own_time_of,
    shortest_step,
    time_to_half,
)
from ghostball.engine.resting_contact.islands import (
    gather_contacts,
    gather_members,
    mark_again,
    release,
)
from ghostball.engine.resting_contact.paths import held_obstacles

_GROWTH = 1.25
"""Next step tried, in units of the last good one; a longer one would mostly be tried in vain."""


@kernel
def end_step(contacts: Contacts, i: int) -> None:
    """Mark in `contacts.again` every ball of ball i's cluster, whose contact step ends."""
    k = i
    while True:
        mark_again(contacts, k)
        k = contacts.ring[k]
        if k == i:
            return


@kernel
def press_again(
    balls: Balls,
    laws: Laws,
    cells: Cells | None,
    contacts: Contacts,
    listed: int,
    t: float,
    counters: IntArray,
) -> None:
    """End the contact steps of all balls marked in `contacts.again`; start others if they press.

    And start those of the first `listed` contacts of `balls.hits`, whether they press or not:
    FIRST is a ball, SECOND a ball or -1 minus the row of an obstacle.

    Clusters are judged as wholes, and all of them that an event changed at once: in a chain, the
    ball behind may be all that presses the two in front together, so that no pair of free balls
    would show it; and of two balls that hit each other, both may belong to a cluster. What one
    cluster does may bring another in contact: so they take turns by place, not by number.

    Contract: as `_press`, for every ball that is marked or listed.
    """
    for c in range(listed):
        for row in (FIRST, SECOND):
            k = balls.hits[c, row]
            if k >= 0:
                mark_again(contacts, k)
                contacts.motion[k, STEP] = 0.0
                contacts.motion[k, AHEAD] = 0.0
                if contacts.cluster[k] != FREE:
                    end_step(contacts, k)
    for m in range(1, contacts.waiting[0] + 1):
        k = contacts.waiting[m]
        counter = CONTACT_PIECES if contacts.motion[k, LEFT] > 0.0 else CONTACT_STEPS
        if contacts.again[k] and goes_on(balls, laws, contacts, k, t):
            counters[counter] += 1
    for m in range(1, contacts.waiting[0] + 1):
        k = contacts.waiting[m]
        if contacts.again[k]:
            release(balls, laws, contacts, k, t)
            advance(balls, k, t)
    while True:
        first = -1
        for m in range(1, contacts.waiting[0] + 1):
            k = contacts.waiting[m]
            if contacts.again[k] and (first < 0 or stands_before(balls, k, first)):
                first = k
        if first < 0:
            contacts.waiting[0] = 0
            return
        _press(balls, laws, cells, contacts, first, listed, t, counters)


@kernel
def _press(
    balls: Balls,
    laws: Laws,
    cells: Cells | None,
    contacts: Contacts,
    i: int,
    listed: int,
    t: float,
    counters: IntArray,
) -> None:
    """Start a contact step, at the instant t [s], for the cluster that ball i belongs to.

    The first `listed` contacts of `balls.hits` are held, close or not. Where the cluster has
    none of them, and no force turns out to be needed, or nothing moves, the balls are free again.

    Contract: every member is advanced to t, given its accelerations and an own event no later than
    the step's end, marked in `balls.changed` and unmarked in `contacts.again`; one whose slip or
    speed ends here because what is left of it is negligible is marked in `contacts.rolled` or
    `contacts.stopped`. No allocation: `contacts` has room.
    """
    counters[CONTACT_STEPS] += 1
    members = gather_members(balls, laws, cells, contacts, i, listed, t)
    for m in range(members):
        contacts.again[contacts.member[m]] = False
        contacts.motion[contacts.member[m], LEFT] = 0.0
    count = gather_contacts(balls, laws, contacts, members, listed, t, counters)
    if count == 0:
        release(balls, laws, contacts, i, t)
        return
    _settle_all(balls, laws, contacts, members)
    stopped = stop_approach(balls, laws, contacts, members, count)
    _settle_all(balls, laws, contacts, members)
    for m in range(members):
        if contacts.rolled[contacts.member[m]]:
            contacts.motion[contacts.member[0], AHEAD] = 0.0
    if stopped and follow_on(balls, laws, contacts, members, count, t):
        return
    own_time = own_time_of(balls, contacts, members)
    if own_time == math.inf:  # nothing moves, and no cloth could move it
        release(balls, laws, contacts, i, t)
        return
    fresh = FIRST_STEP * own_time
    shortest = shortest_step(own_time, t)
    change = time_to_half(balls, contacts, members)
    step = next_step(contacts, members, STEP, fresh, own_time)
    longest = min(step, change)
    solved, duration = _halve(balls, laws, contacts, members, count, longest, shortest, True)
    found = solved
    if not found and laws.slides:
        longest = min(fresh, change)
        found, duration = _halve(balls, laws, contacts, members, count, longest, shortest, False)
    for m in range(members):
        k = contacts.member[m]
        paused = contacts.motion[k, AHEAD] < 0.0
        contacts.motion[k, AHEAD] = contacts.motion[k, AHEAD] + 1.0 if paused else 0.0
    if not found:
        solve(balls, laws, contacts, members, 0, duration, False)  # no forces at all
    if duration < longest:
        step = duration
    if not (solved and stopped):
        counters[UNSOLVED_STEPS] += 1
    for m in range(members):
        keep_still(balls, contacts, contacts.member[m], duration)
    needed = _holds_listed(balls, contacts, i, listed) or _any_force(contacts, count)
    if not needed or not _moves(balls, contacts, members):
        release(balls, laws, contacts, i, t)
        return
    for m in range(members):
        k = contacts.member[m]
        balls.state[k].ax = contacts.motion[k, NEW_AX]
        balls.state[k].ay = contacts.motion[k, NEW_AY]
        straighten(balls, k)
        if laws.slides:
            if contacts.motion[k, SLIPS] == 1.0:
                loosen(balls, k)
            balls.state[k].bx = contacts.motion[k, NEW_BX]
            balls.state[k].by = contacts.motion[k, NEW_BY]
            _twist(balls, contacts, k, duration)
        if not stopping(balls, k):
            balls.state[k].moved = 1.0
        balls.own_kind[k] = OWN_REST if _comes_to_rest(balls, k, duration) else OWN_CONTACT
        predict_obstacles(balls, k, laws, duration, held_obstacles(contacts, count, k))
        contacts.motion[k, STEP] = _GROWTH * step
        mark(balls, k)


@kernel
def _halve(
    balls: Balls,
    laws: Laws,
    contacts: Contacts,
    members: int,
    count: int,
    longest: float,
    shortest: float,
    rubs: bool,
) -> tuple[bool, float]:
    """Halve a step until it is solved, or too short; return whether it is solved, and the step."""
    duration = longest
    while True:
        if solve(balls, laws, contacts, members, count, duration, rubs):
            return True, duration
        if not duration > shortest:  # nor where one of both is NaN
            return False, duration
        duration *= 0.5


@kernel
def _settle_all(balls: Balls, laws: Laws, contacts: Contacts, members: int) -> None:
    """End the slips that the cloth ends at once; mark whose."""
    for m in range(members):
        k = contacts.member[m]
        if laws.slides and settle(balls, contacts, k):
            contacts.rolled[k] = True
            predict_again(balls, k, laws)


@kernel
def _holds_listed(balls: Balls, contacts: Contacts, i: int, listed: int) -> bool:
    """Whether one of the first `listed` contacts of `balls.hits` is of ball i's cluster."""
    for c in range(listed):  # noqa: SIM110 - the compiler takes no generator
        if contacts.cluster[balls.hits[c, FIRST]] == contacts.cluster[i]:
            return True
    return False


@kernel
def _moves(balls: Balls, contacts: Contacts, members: int) -> bool:
    """Whether any member moves: what rests may be under pressure, but nothing comes of it."""
    for m in range(members):
        k = contacts.member[m]
        driven = contacts.motion[k, NEW_AX] != 0.0 or contacts.motion[k, NEW_AY] != 0.0
        if driven or not at_rest(balls, k):
            return True
    return False


@kernel
def _any_force(contacts: Contacts, count: int) -> bool:
    for c in range(count):  # noqa: SIM110 - the compiler takes no generator
        if contacts.forces[c, FORCE] > 0.0:
            return True
    return False


@kernel
def _twist(balls: Balls, contacts: Contacts, k: int, duration: float) -> None:
    """Turn member k about the vertical: what its contacts do, and the cloth against that."""
    spin = balls.state[k].wz
    slowed = duration * balls.state[k].spin_slowing
    gain = 2.5 * contacts.motion[k, TWIST_Z] / (balls.state[k].mass * balls.state[k].radius)
    if gain == 0.0:
        return
    driven = spin + duration * gain
    end = max(abs(driven) - slowed, 0.0)
    end = end if driven > 0.0 else -end
    alone = max(abs(spin) - slowed, 0.0)
    alone = alone if spin > 0.0 else -alone
    balls.state[k].bz = (end - alone) / duration


@kernel
def _comes_to_rest(balls: Balls, k: int, duration: float) -> bool:
    """Whether member k moves, and its acceleration takes just that velocity in `duration`."""
    left_x = balls.state[k].vx + duration * balls.state[k].ax
    left_y = balls.state[k].vy + duration * balls.state[k].ay
    speed = speed_of(balls.state[k].vx, balls.state[k].vy)
    if balls.state[k].phase == SLIDING:
        return False  # it rolls first
    return speed > 0.0 and speed_of(left_x, left_y) <= 4.0 * EPS * speed
