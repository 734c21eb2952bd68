"""Steps of resting contact: balls that friction holds in contact move as one island.

Two balls that roll side by side in contact, in slightly different directions, decelerate along
different lines, and so may stay in contact. If the engine let them bounce, they would collide again
and again with decreasing speed, endlessly for a restitution below 1. Instead, a contact force keeps
each gap of the island closed while the force has to push.

The motion of an island isn't polynomial, because the lines of centres and the directions of
friction turn. While every contact pushes and no slip ends, the motion is integrated over long steps
with high order (`resting_contact.integrate`). When a contact parts or sticks, or a ball stops or
starts to slip, the island moves in short steps with constant accelerations. Such a step is as long
as possible with every gap within `CONTACT_TOLERANCE` diameters (4e-13 m for pool balls). The gaps
are checked along the polynomials that the balls follow, at the end of the step and at seven times
within it. Normals and friction are those at mid-step, so the error of a step is third order in its
length. The forces are computed by `impacts.contact_solver` from the gaps at the end of the step.
The method never shifts a ball. Impulses are inelastic, and a contact force acts on a gap that stays
within the tolerance: the energy that this force could add is far below the energy that friction
takes in the same step.

A ball so slow that the cloth would stop it within `CAPTURE_HEIGHT` is brought to rest by the end of
its step, unless a force above mu m g pushes it.

`work["contact_steps"]` counts the steps. An integrated motion is divided into pieces, for which no
forces are computed; `work["contact_pieces"]` counts the pieces after the first of each step.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Contacts, World
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.motion.geometry import at_rest, speed_of, stands_before
from ghostball.engine.motion.next_piece import (
    friction_against,
    keep_spin,
    mark,
    predict_again,
    predict_obstacles,
    slip,
)
from ghostball.engine.motion.position import advance, slowed_spin, straighten
from ghostball.engine.resting_contact.capture import stop_approach, wedge_pushes
from ghostball.engine.resting_contact.cloth_response import (
    end_slip,
    keep_still,
    spin_after,
    stopping,
)
from ghostball.engine.resting_contact.continuation import (
    FIRST_STEP,
    continue_island,
    next_step,
    own_time_of,
    shortest_step,
    start_motion,
    time_to_half,
)
from ghostball.engine.resting_contact.forces import solve
from ghostball.engine.resting_contact.islands import (
    gather_contacts,
    gather_members,
    mark_again,
    release,
)
from ghostball.engine.resting_contact.paths import held_obstacles

_GROWTH = 1.25
"""Length of the next step tried, in units of the last successful one. Longer steps mostly fail."""


_FACING = -1.0 + 2.0**-8
"""Cosine between the normals of two obstacles below which a ball between them is wedged.

The two obstacles face each other within 5 degrees. The smaller this angle, the shorter the steps
that forces and friction need.
"""


@kernel
def end_step(contacts: Contacts, i: int) -> None:
    """Mark in `contacts.again` every ball of ball i's island, because the contact step ends."""
    k = i
    while True:
        mark_again(contacts, k)
        k = contacts.ring[k]
        if k == i:
            return


@kernel
def start_steps(world: World, listed: int, t: float) -> None:
    """End the contact steps of all balls marked in `contacts.again`; start new steps if balls push.

    Also start steps for the first `listed` contacts of `balls.touching`, whether they push or not.
    In these rows FIRST is a ball, and SECOND is a ball or -1 minus the row of an obstacle.

    Only whole islands are checked, and all islands that an event changed are checked together. In a
    chain, only the ball behind may push the two balls in front together, so checking pairs of free
    balls isn't enough. If two balls collide, both may belong to islands. A step of one island may
    bring another island in contact, so islands are handled in the order of positions, not of
    indices.

    Contract: every ball that is marked or listed fulfils the contract of `_start_step`.
    """
    balls, contacts = world.balls, world.contacts
    for c in range(listed):
        for row in (st.FIRST, st.SECOND):
            k = balls.touching[c, row]
            if k >= 0:
                mark_again(contacts, k)
                contacts.motion[k].step = 0.0
                contacts.motion[k].ahead = 0.0
                if contacts.island[k] != st.FREE:
                    end_step(contacts, k)
    for m in range(1, contacts.waiting[0] + 1):
        k = contacts.waiting[m]
        counter = st.CONTACT_PIECES if contacts.motion[k].pieces_left > 0.0 else st.CONTACT_STEPS
        if contacts.again[k] and continue_island(world, k, t):
            world.log.counters[counter] += 1
    for m in range(1, contacts.waiting[0] + 1):
        k = contacts.waiting[m]
        if contacts.again[k]:
            release(world, k, t)
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
        _start_step(world, first, listed, t)


@kernel
def _start_step(world: World, i: int, listed: int, t: float) -> None:
    """Start a contact step at time t [s] for the island that contains ball i.

    The first `listed` contacts of `balls.touching` are held, whatever their gap. The balls are
    released if nothing moves, or if no force is needed and the island has no listed contact.

    Contract: every member is advanced to t, has its accelerations and an own event no later than
    the end of the step, is marked in `balls.changed` and unmarked in `contacts.again`. A member
    whose remaining slip or speed is negligible, so that it ends here, is marked in
    `contacts.rolled` or `contacts.stopped`. No allocation: `contacts` has room.
    """
    balls, laws, contacts = world.balls, world.laws, world.contacts
    world.log.counters[st.CONTACT_STEPS] += 1
    members = gather_members(world, i, listed, t)
    for m in range(members):
        contacts.again[contacts.member[m]] = False
        contacts.motion[contacts.member[m]].pieces_left = 0.0
    count = gather_contacts(world, members, listed, t)
    if count == 0:
        release(world, i, t)
        return
    _end_slips(world, members)
    stopped = stop_approach(world, members, count, True)
    # An impulse may leave a negligible slip; ending it changes the velocities again.
    for _ in range(members):
        if not _end_slips(world, members):
            break
        stopped = stop_approach(world, members, count, True)
    for m in range(members):
        if contacts.rolled[contacts.member[m]]:
            contacts.motion[contacts.member[0]].ahead = 0.0
    if members == 1 and _hold_wedged(world, count):
        return
    if stopped and start_motion(world, members, count, t):
        return
    own_time = own_time_of(world, members)
    if own_time == math.inf:  # nothing moves, and the cloth can't move anything
        release(world, i, t)
        return
    fresh = FIRST_STEP * own_time
    shortest = shortest_step(own_time, t)
    change = time_to_half(world, members)
    step = next_step(contacts, members, False, fresh, own_time)
    longest = min(step, change)
    solved, duration = _halve(world, members, count, longest, shortest, True)
    found = solved
    if not found and laws.slides:
        longest = min(fresh, change)
        found, duration = _halve(world, members, count, longest, shortest, False)
    for m in range(members):
        k = contacts.member[m]
        paused = contacts.motion[k].ahead < 0.0
        contacts.motion[k].ahead = contacts.motion[k].ahead + 1.0 if paused else 0.0
    if not found:
        solve(world, members, 0, duration, False)  # without any forces
    if duration < longest:
        step = duration
    if not (solved and stopped):
        world.log.counters[st.UNSOLVED_STEPS] += 1
    for m in range(members):
        keep_still(world, contacts.member[m], duration)
    needed = _holds_listed(world, i, listed) or _any_force(contacts, count)
    if not needed or not _moves(world, members):
        release(world, i, t)
        return
    for m in range(members):
        k = contacts.member[m]
        balls.state[k].ax = contacts.motion[k].new_ax
        balls.state[k].ay = contacts.motion[k].new_ay
        straighten(balls, k)
        if laws.slides:
            if contacts.motion[k].slips == 1.0:
                keep_spin(balls, k)
            balls.state[k].bx = contacts.motion[k].new_bx
            balls.state[k].by = contacts.motion[k].new_by
            alone = slowed_spin(balls.state[k].wz, duration * balls.state[k].spin_slowing)
            balls.state[k].bz = (spin_after(world, k, duration) - alone) / duration
        if not stopping(balls, k):
            balls.state[k].moved = 1.0
        balls.own_kind[k] = st.OWN_REST if _comes_to_rest(balls, k, duration) else st.OWN_CONTACT
        predict_obstacles(balls, k, laws, duration, held_obstacles(contacts, count, k))
        contacts.motion[k].step = _GROWTH * step
        mark(balls, k)


@kernel
def _hold_wedged(world: World, count: int) -> bool:
    """Hold the only member if it slips between two obstacles that nearly face each other.

    This applies if the cloth's friction pushes the ball into the wedge, because contact forces can
    then balance any such push. The ball stays there until the cloth has ended its slip. Return
    whether the ball is held.
    """
    balls, contacts = world.balls, world.contacts
    k = contacts.member[0]
    ball = balls.state[k]
    if ball.phase != st.SLIDING or ball.vx != 0.0 or ball.vy != 0.0:
        return False
    ux, uy = slip(balls, k)
    ax, ay = friction_against(ux, uy, ball.slide_slowing)
    for c in range(count):
        for other in range(c + 1, count):
            first, second = contacts.forces[c], contacts.forces[other]
            if first.nx * second.nx + first.ny * second.ny > _FACING:
                continue
            _, push, push_too = wedge_pushes(first, second, ax, ay)
            if push > 0.0 and push_too > 0.0:
                ball.ax, ball.ay = 0.0, 0.0
                straighten(balls, k)
                ball.bx, ball.by = 2.5 * ay / ball.radius, -2.5 * ax / ball.radius
                duration = speed_of(ux, uy) / (2.5 * ball.slide_slowing)
                balls.own_kind[k] = st.OWN_CONTACT
                held = held_obstacles(contacts, count, k)
                predict_obstacles(balls, k, world.laws, duration, held)
                contacts.motion[k].step, contacts.motion[k].ahead = 0.0, 0.0
                mark(balls, k)
                return True
    return False


@kernel
def _halve(
    world: World, members: int, count: int, longest: float, shortest: float, rubs: bool
) -> tuple[bool, float]:
    """Halve a step until forces are found or it is too short; return whether found, and the step.

    "Too short" means at most `shortest` [s].
    """
    duration = longest
    while True:
        if solve(world, members, count, duration, rubs):
            return True, duration
        if not duration > shortest:  # also ends if a value is NaN
            return False, duration
        duration *= 0.5


@kernel
def _end_slips(world: World, members: int) -> bool:
    """End every negligible slip and mark its ball; return whether there was any."""
    found = False
    for m in range(members):
        k = world.contacts.member[m]
        if world.laws.slides and end_slip(world, k):
            world.contacts.rolled[k] = True
            predict_again(world.balls, k, world.laws)
            found = True
    return found


@kernel
def _holds_listed(world: World, i: int, listed: int) -> bool:
    """Return whether ball i's island has one of the first `listed` contacts of `balls.touching`."""
    for c in range(listed):
        if world.contacts.island[world.balls.touching[c, st.FIRST]] == world.contacts.island[i]:
            return True
    return False


@kernel
def _moves(world: World, members: int) -> bool:
    """Return whether any member moves; forces on balls at rest have no effect."""
    contacts = world.contacts
    for m in range(members):
        k = contacts.member[m]
        driven = contacts.motion[k].new_ax != 0.0 or contacts.motion[k].new_ay != 0.0
        if driven or not at_rest(world.balls, k):
            return True
    return False


@kernel
def _any_force(contacts: Contacts, count: int) -> bool:
    for c in range(count):  # noqa: SIM110 - the compiler takes no generator
        if contacts.forces[c].force > 0.0:
            return True
    return False


@kernel
def _comes_to_rest(balls: Balls, k: int, duration: float) -> bool:
    """Return whether member k moves, and its acceleration stops it exactly after `duration` [s]."""
    left_x = balls.state[k].vx + duration * balls.state[k].ax
    left_y = balls.state[k].vy + duration * balls.state[k].ay
    speed = speed_of(balls.state[k].vx, balls.state[k].vy)
    if balls.state[k].phase == st.SLIDING:
        return False  # it must roll first
    return speed > 0.0 and speed_of(left_x, left_y) <= 4.0 * EPS * speed
