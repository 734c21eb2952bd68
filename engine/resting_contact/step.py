"""Resting contact, the whole of it: balls that friction holds in contact move as one island.

Two balls that roll side by side in contact, in slightly different directions, are slowed along
different lines, and so may stay in contact. Bouncing, they would meet again and again with
vanishing speed: without end for a restitution below 1. Instead a contact force holds each gap of
the island closed for as long as it has to push.

That motion isn't polynomial, because the line of centres and the direction of friction turn. While
every contact pushes and no slip ends, it is integrated far, to high order
(`resting_contact.integrate`). What happens between, where a contact parts or sticks, a ball stops
or starts to slip, is taken across in steps of constant acceleration, each as long as keeps every
gap within `CONTACT_TOLERANCE` diameters (4e-13 m for pool balls), checked on the very polynomials
that the balls then follow, at the step's end and seven times within. Normals and friction are taken
at the middle of the step, so that its error is third order in its length. The forces come from the
one solver of contacts (`impacts.contact_solver`), on the gaps at the end of the step. No ball is
displaced. Impulses are inelastic, and a force works on a gap that stays within the tolerance: what
energy that could add is far below what friction takes in the same step.

A ball so slow that the cloth would stop it within `CAPTURE_HEIGHT` is brought to rest by the end of
its step, unless it is pushed harder than mu m g.

Each step is counted in `work["contact_steps"]`. A motion that is integrated goes along its step in
pieces, for which no force is sought: those after the first are counted in `work["contact_pieces"]`.
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
from ghostball.engine.resting_contact.cloth_response import end_slip, keep_still, stopping
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
"""Next step tried, in units of the last good one; a longer one would mostly be tried in vain."""


_FACING = -1.0 + 2.0**-8
"""Cosine between the normals of two obstacles below which a ball between them is wedged.

They are within 5 degrees of facing each other. The steps that forces and friction there ask for
become ever shorter the smaller the angle is.
"""


@kernel
def end_step(contacts: Contacts, i: int) -> None:
    """Mark in `contacts.again` every ball of ball i's island, whose contact step ends."""
    k = i
    while True:
        mark_again(contacts, k)
        k = contacts.ring[k]
        if k == i:
            return


@kernel
def start_steps(world: World, listed: int, t: float) -> None:
    """End the contact steps of all balls marked in `contacts.again`; start others if they push.

    And start those of the first `listed` contacts of `balls.touching`, whether they push or not:
    FIRST is a ball, SECOND a ball or -1 minus the row of an obstacle.

    Islands are judged as wholes, and all of them that an event changed at once: in a chain, the
    ball behind may be all that pushes the two in front together, so that no pair of free balls
    would show it; and of two balls that hit each other, both may belong to an island. What one
    island does may bring another in contact: so they are interleaved by place, not by number.

    Contract: as `_start_step`, for every ball that is marked or listed.
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
    """Start a contact step, at the instant t [s], for the island that ball i belongs to.

    The first `listed` contacts of `balls.touching` are held, close or not. Where the island has
    none of them, and no force turns out to be needed, or nothing moves, the balls are free again.

    Contract: every member is advanced to t, given its accelerations and an own event no later than
    the step's end, marked in `balls.changed` and unmarked in `contacts.again`; one whose slip or
    speed ends here because what is left of it is negligible is marked in `contacts.rolled` or
    `contacts.stopped`. No allocation: `contacts` has room.
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
    # An impulse may leave so little slip that the cloth ends it at once, which changes velocities.
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
    if own_time == math.inf:  # nothing moves, and no cloth could move it
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
        solve(world, members, 0, duration, False)  # no forces at all
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
            _twist(world, k, duration)
        if not stopping(balls, k):
            balls.state[k].moved = 1.0
        balls.own_kind[k] = st.OWN_REST if _comes_to_rest(balls, k, duration) else st.OWN_CONTACT
        predict_obstacles(balls, k, laws, duration, held_obstacles(contacts, count, k))
        contacts.motion[k].step = _GROWTH * step
        mark(balls, k)


@kernel
def _hold_wedged(world: World, count: int) -> bool:
    """Hold the one member where it slips between two obstacles that all but face each other.

    Applies if the cloth's friction pushes the ball into the wedge: contact forces can balance any
    such push. The ball stays there until the cloth has ended its slip. Return whether it does.
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
    """Halve a step until it is solved, or too short; return whether it is solved, and the step."""
    duration = longest
    while True:
        if solve(world, members, count, duration, rubs):
            return True, duration
        if not duration > shortest:  # nor where one of both is NaN
            return False, duration
        duration *= 0.5


@kernel
def _end_slips(world: World, members: int) -> bool:
    """End the slips that the cloth ends at once; mark whose; return whether there was any."""
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
    """Whether one of the first `listed` contacts of `balls.touching` is of ball i's island."""
    for c in range(listed):
        if world.contacts.island[world.balls.touching[c, st.FIRST]] == world.contacts.island[i]:
            return True
    return False


@kernel
def _moves(world: World, members: int) -> bool:
    """Whether any member moves: what rests may be under pressure, but nothing comes of it."""
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
def _twist(world: World, k: int, duration: float) -> None:
    """Turn member k about the vertical: what its contacts do, and the cloth against that."""
    balls = world.balls
    spin = balls.state[k].wz
    slowed = duration * balls.state[k].spin_slowing
    gain = 2.5 * world.contacts.motion[k].twist_z / (balls.state[k].mass * balls.state[k].radius)
    if gain == 0.0:
        return
    end = slowed_spin(spin + duration * gain, slowed)
    balls.state[k].bz = (end - slowed_spin(spin, slowed)) / duration


@kernel
def _comes_to_rest(balls: Balls, k: int, duration: float) -> bool:
    """Whether member k moves, and its acceleration takes just that velocity in `duration`."""
    left_x = balls.state[k].vx + duration * balls.state[k].ax
    left_y = balls.state[k].vy + duration * balls.state[k].ay
    speed = speed_of(balls.state[k].vx, balls.state[k].vy)
    if balls.state[k].phase == st.SLIDING:
        return False  # it rolls first
    return speed > 0.0 and speed_of(left_x, left_y) <= 4.0 * EPS * speed
