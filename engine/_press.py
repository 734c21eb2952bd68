"""Sustained contact: balls that friction presses together move as one cluster, in short steps.

Two balls that roll side by side in contact, in slightly different directions, are slowed along
different lines, and so may be pressed together. Bouncing, they would meet again and again with
vanishing speed: without end for a restitution below 1. Instead a contact force holds each gap of
the cluster closed for as long as it has to push.

That motion isn't polynomial, because the line of centres and the direction of friction turn. It is
followed in steps of constant acceleration, each as long as keeps every gap within
`CONTACT_TOLERANCE` diameters (4e-13 m for pool balls), checked on the very polynomials that the
balls then follow, at the step's end and twice within. Normals and friction are taken at the middle
of the step, so that its error is third order in its length. The forces come from projected
Gauss-Seidel on the gaps at the end of the step. No ball is displaced. Impulses are plastic, and a
force works on a gap that stays within the tolerance: what energy that could add is far below what
friction takes in the same step.

A ball so slow that the cloth would stop it within `CAPTURE_HEIGHT` is brought to rest by the end of
its step, unless it is pushed harder than mu m g.

Each step is counted in `work["contact_steps"]`.
"""

from __future__ import annotations

import math

from engine._clusters import gather_contacts, gather_members, release, stands_before
from engine._contact_answer import keep_still, settle, stopping, time_to_change
from engine._contact_force import gap_after, solve
from engine._geometry import (
    at_rest,
    capture_height,
    contact_tolerance,
    grip,
    negligible_hop,
)
from engine._jit import kernel
from engine._motion import advance, loosen, predict_cushion, predict_motion, speed_of
from engine._plastic import end_approach, gained, gap_rate, sum_at
from engine._state import (
    ANSWERING,
    AX,
    AY,
    BX,
    BY,
    BZ,
    CONTACT_STEPS,
    FIRST,
    FORCE,
    MASS,
    MOVED,
    NEW_AX,
    NEW_AY,
    NEW_BX,
    NEW_BY,
    NX,
    NY,
    OWN_CONTACT,
    OWN_REST,
    PHASE,
    PUSH_X,
    PUSH_Y,
    RADIUS,
    RATE,
    SECOND,
    SLIDE,
    SLIDING,
    SLIPS,
    SPIN,
    STEP,
    TWIST_Z,
    UNSOLVED_STEPS,
    VX,
    VY,
    WZ,
    Balls,
    Contacts,
    IntArray,
    Laws,
)
from engine._tolerances import APPROACH_ROUNDING, EPS, TIME_ROUNDING

_SHORTEST = 2.0**-26
"""Shortest step, in units of the time to go one radius at what the cloth can give.

About 2 ns for pool balls. A contact that rubs by much, where masses differ by much, may jam: no
forces but shocks are then a solution. Shorter steps only make the forces greater, and the work that
they do on what rounding leaves of the gaps. The friction of the contacts is left out of such a step
and it is counted in `work["unsolved_contact_steps"]`.
"""

_RESIDUE = 2.0**-20
"""Hop, in units of a negligible one, left to the contact force: a thousandth of its speed."""

_GROWTH = 1.25
"""First step tried, in units of the last good one; a longer one would mostly be tried in vain."""

_FIRST_STEP = 2.0**-6
"""First step tried, in units of the time to go one radius at what the cloth can give."""


@kernel
def end_step(contacts: Contacts, i: int) -> None:
    """Mark in `contacts.again` every ball of ball i's cluster, whose contact step ends."""
    label = contacts.cluster[i]
    for k in range(len(contacts.cluster)):
        if contacts.cluster[k] == label:
            contacts.again[k] = True


@kernel
def press_again(
    balls: Balls, laws: Laws, contacts: Contacts, listed: int, t: float, counters: IntArray
) -> None:
    """End the contact steps of all balls marked in `contacts.again`; start others if they press.

    And start those of the first `listed` contacts of `contacts.hits`, whether they press or not:
    FIRST is a ball, SECOND a ball or -1 minus the index of a cushion.

    Clusters are judged as wholes, and all of them that an event changed at once: in a chain, the
    ball behind may be all that presses the two in front together, so that no pair of free balls
    would show it; and of two balls that hit each other, both may belong to a cluster. What one
    cluster does may bring another in contact: so they take turns by place, not by number.

    Contract: as `_press`, for every ball that is marked or listed.
    """
    for c in range(listed):
        for row in (FIRST, SECOND):
            if contacts.hits[row, c] >= 0:
                contacts.again[contacts.hits[row, c]] = True
    for k in range(len(balls.own_kind)):
        if contacts.again[k]:
            release(balls, laws, contacts, k, t)
            advance(balls, k, t)
    while True:
        first = -1
        for k in range(len(balls.own_kind)):
            if contacts.again[k] and (first < 0 or stands_before(balls, k, first)):
                first = k
        if first < 0:
            return
        _press(balls, laws, contacts, first, listed, t, counters)


@kernel
def _press(
    balls: Balls,
    laws: Laws,
    contacts: Contacts,
    i: int,
    listed: int,
    t: float,
    counters: IntArray,
) -> None:
    """Start a contact step, at the instant t [s], for the cluster that ball i belongs to.

    The first `listed` contacts of `contacts.hits` are held, close or not. Where none is listed, and
    no force turns out to be needed, the balls are free again.

    Contract: every member is advanced to t, given its accelerations and an own event no later than
    the step's end, marked in `contacts.changed` and unmarked in `contacts.again`; one whose slip or
    speed ends here because what is left of it is negligible is marked in `contacts.rolled` or
    `contacts.stopped`. No allocation: `contacts` has room.
    """
    counters[CONTACT_STEPS] += 1
    members = gather_members(balls, laws, contacts, i, listed, t)
    for m in range(members):
        contacts.again[contacts.member[m]] = False
    count = gather_contacts(balls, laws, contacts, members, listed, t)
    if count == 0:
        release(balls, laws, contacts, i, t)
        return
    for m in range(members):
        k = contacts.member[m]
        if laws.slides and settle(balls, k):
            contacts.rolled[k] = True
            predict_motion(balls, k, laws)
    stopped = _stop_approach(balls, laws, contacts, members, count)
    fresh = _FIRST_STEP * _own_time(balls, contacts, members)
    shortest = max(_SHORTEST * _own_time(balls, contacts, members), 4.0 * TIME_ROUNDING * t)
    change = math.inf
    for m in range(members):
        change = min(change, time_to_change(balls, contacts.member[m]))
    step = _next_step(contacts, members, fresh)
    longest = min(step, change)
    solved, duration = _halve(balls, laws, contacts, members, count, longest, shortest, True)
    if not solved and laws.slides:
        longest = min(fresh, change)
        _, duration = _halve(balls, laws, contacts, members, count, longest, shortest, False)
    if duration < longest:
        step = duration
    if not (solved and stopped):
        counters[UNSOLVED_STEPS] += 1
    for m in range(members):
        keep_still(balls, contacts, contacts.member[m], duration)
    if not _moves(balls, contacts, members) or not (listed > 0 or _any_force(contacts, count)):
        release(balls, laws, contacts, i, t)
        return
    for m in range(members):
        k = contacts.member[m]
        balls.state[AX, k] = contacts.motion[NEW_AX, k]
        balls.state[AY, k] = contacts.motion[NEW_AY, k]
        if laws.slides:
            if contacts.motion[SLIPS, k] == 1.0:
                loosen(balls, k)
            balls.state[BX, k] = contacts.motion[NEW_BX, k]
            balls.state[BY, k] = contacts.motion[NEW_BY, k]
            _twist(balls, contacts, k, duration)
        if not stopping(balls, k):
            contacts.motion[MOVED, k] = 1.0
        balls.own_kind[k] = OWN_REST if _comes_to_rest(balls, k, duration) else OWN_CONTACT
        predict_cushion(balls, k, laws, duration, _held_cushions(contacts, count, k))
        contacts.motion[STEP, k] = step
        contacts.changed[k] = True


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
        if duration <= shortest:
            return False, duration
        duration *= 0.5


@kernel
def _held_cushions(contacts: Contacts, count: int, k: int) -> int:
    """Return the cushions that the step holds ball k off, one bit each."""
    held = 0
    for c in range(count):
        if contacts.ends[FIRST, c] == k and contacts.ends[SECOND, c] < 0:
            held |= 1 << (-1 - contacts.ends[SECOND, c])
    return held


@kernel
def _moves(balls: Balls, contacts: Contacts, members: int) -> bool:
    """Whether any member moves: what rests may be under pressure, but nothing comes of it."""
    for m in range(members):
        k = contacts.member[m]
        driven = contacts.motion[NEW_AX, k] != 0.0 or contacts.motion[NEW_AY, k] != 0.0
        if driven or not at_rest(balls, k):
            return True
    return False


@kernel
def _any_force(contacts: Contacts, count: int) -> bool:
    for c in range(count):  # noqa: SIM110 - the compiler takes no generator
        if contacts.forces[FORCE, c] > 0.0:
            return True
    return False


@kernel
def _twist(balls: Balls, contacts: Contacts, k: int, duration: float) -> None:
    """Turn member k about the vertical: what its contacts do, and the cloth against that."""
    spin = balls.state[WZ, k]
    slowed = duration * balls.state[SPIN, k]
    gain = 2.5 * contacts.motion[TWIST_Z, k] / (balls.state[MASS, k] * balls.state[RADIUS, k])
    if gain == 0.0:
        return
    driven = spin + duration * gain
    end = max(abs(driven) - slowed, 0.0)
    end = end if driven > 0.0 else -end
    alone = max(abs(spin) - slowed, 0.0)
    alone = alone if spin > 0.0 else -alone
    balls.state[BZ, k] = (end - alone) / duration


@kernel
def _comes_to_rest(balls: Balls, k: int, duration: float) -> bool:
    """Whether member k moves, and its acceleration takes just that velocity in `duration`."""
    left_x = balls.state[VX, k] + duration * balls.state[AX, k]
    left_y = balls.state[VY, k] + duration * balls.state[AY, k]
    speed = speed_of(balls.state[VX, k], balls.state[VY, k])
    if balls.state[PHASE, k] == SLIDING:
        return False  # it rolls first
    return speed > 0.0 and speed_of(left_x, left_y) <= 4.0 * EPS * speed


@kernel
def _stop_approach(balls: Balls, laws: Laws, contacts: Contacts, members: int, count: int) -> bool:
    """Take away what approach is left at the contacts, plastically: each is a negligible hop.

    A ball at rest stays so if the cloth would stop it again within `CAPTURE_HEIGHT`. False where no
    impulses did it.
    """
    for m in range(members):
        k = contacts.member[m]
        # For now: that it moves. It may have been stopped at this very instant before.
        contacts.stopped[k] = contacts.stopped[k] or not at_rest(balls, k)
    if not _approaches(balls, laws, contacts, count):
        solved = True
    else:
        _let_answer(balls, contacts, members, True)
        solved = end_approach(contacts, count)
        if not _absorbs(balls, contacts, members, count):
            _let_answer(balls, contacts, members, False)
            solved = end_approach(contacts, count)
        for m in range(members):
            k = contacts.member[m]
            balls.state[VX, k] += gained(contacts, count, k, PUSH_X)
            balls.state[VY, k] += gained(contacts, count, k, PUSH_Y)
    for m in range(members):
        k = contacts.member[m]
        contacts.stopped[k] = contacts.stopped[k] and at_rest(balls, k)
    return solved


@kernel
def _approaches(balls: Balls, laws: Laws, contacts: Contacts, count: int) -> bool:
    """Whether any contact approaches by more than is left to its force; set normals and rates."""
    found = False
    for c in range(count):
        a, b = contacts.ends[FIRST, c], contacts.ends[SECOND, c]
        nx, ny, _ = gap_after(balls, laws, contacts, c, 0.0)
        contacts.forces[NX, c] = nx
        contacts.forces[NY, c] = ny
        rate = gap_rate(balls, contacts, c)
        contacts.forces[RATE, c] = rate
        size = abs(balls.state[VX, a]) + abs(balls.state[VY, a])
        if b >= 0:
            size += abs(balls.state[VX, b]) + abs(balls.state[VY, b])
        other = b if b >= 0 else a
        height = _RESIDUE * contact_tolerance(balls, a, other)
        residue = negligible_hop(rate, max(grip(balls, a), grip(balls, other)), height)
        found = found or (rate < -APPROACH_ROUNDING * size and not residue)
    return found


@kernel
def _let_answer(balls: Balls, contacts: Contacts, members: int, firm: bool) -> None:
    """Set with which mass each member answers to impulses; `firm`: one at rest doesn't."""
    for m in range(members):
        k = contacts.member[m]
        stays = firm and at_rest(balls, k)
        contacts.motion[ANSWERING, k] = math.inf if stays else _moved_mass(balls, k)


@kernel
def _absorbs(balls: Balls, contacts: Contacts, members: int, count: int) -> bool:
    """Whether the cloth takes the impulses on members at rest, each within `CAPTURE_HEIGHT`."""
    for m in range(members):
        k = contacts.member[m]
        if not at_rest(balls, k):
            continue
        pushed = speed_of(
            sum_at(contacts, count, k, PUSH_X, -1.0), sum_at(contacts, count, k, PUSH_Y, -1.0)
        )
        height = capture_height(balls, k, k)
        if not negligible_hop(pushed / balls.state[MASS, k], grip(balls, k), height):
            return False
    return True


@kernel
def _moved_mass(balls: Balls, k: int) -> float:
    """Mass [kg] with which member k answers to a negligible impulse.

    One that rolls goes on rolling: the cloth ends so small a slip within part of `CAPTURE_HEIGHT`.
    """
    rolls = balls.state[PHASE, k] != SLIDING and balls.state[SLIDE, k] > 0.0
    mass: float = 1.4 * balls.state[MASS, k] if rolls else balls.state[MASS, k]
    return mass


@kernel
def _next_step(contacts: Contacts, members: int, fresh: float) -> float:
    """Return the step to try [s]: somewhat more than the members' last one was good for."""
    step = math.inf
    for m in range(members):
        last = contacts.motion[STEP, contacts.member[m]]
        step = min(step, _GROWTH * last if last > 0.0 else fresh)
    return step


@kernel
def _own_time(balls: Balls, contacts: Contacts, members: int) -> float:
    """Return the least time [s] in which the cloth can move a member by its radius.

    Finite: without friction on the cloth no ball would press another.
    """
    least = math.inf
    for m in range(members):
        k = contacts.member[m]
        if grip(balls, k) > 0.0:
            least = min(least, math.sqrt(2.0 * balls.state[RADIUS, k] / grip(balls, k)))
    return least
