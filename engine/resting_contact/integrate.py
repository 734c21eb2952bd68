"""Integrate the motion of an island, with high order, while every contact pushes.

An embedded pair of Runge-Kutta formulas, of orders 5 and 4 (Dormand and Prince 1980), integrates
`resting_contact.rates`. Steps are as long as the error of the motion permits: `MOTION_ERROR` of the
speeds and, for the gaps, a part of their tolerance. The remaining error at the end of a step is
then removed; between the ends, the gaps along the polynomials of `resting_contact.paths` are
checked.
"""

from __future__ import annotations

import math

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.rows import NUMBERS, STAGES
from ghostball.engine.core.state import Contacts, World
from ghostball.engine.core.tolerances import MOTION_ERROR
from ghostball.engine.impacts.contact_solver import gap_rate
from ghostball.engine.motion.geometry import (
    at_rest,
    contact_tolerance,
    friction_limit,
    gap_rounding,
    negligible_bounce,
)
from ghostball.engine.resting_contact.cloth_response import effective_mass, stopping
from ghostball.engine.resting_contact.gaps import balls_of, gap_between, gap_now
from ghostball.engine.resting_contact.paths import (
    DISPLACEMENT_X,
    find_paths,
    find_pieces,
    gap_along,
    share_of_gap,
)
from ghostball.engine.resting_contact.rates import find_rates

_WEIGHTS = np.array(
    (
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        (1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        (3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0),
        (44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0),
        (19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0),
        (9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0),
        (35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0),
    )
)
"""Weights of the slopes of earlier stages in the state at each stage; the last stage is the end."""

_ERROR_WEIGHTS = np.array(
    (
        71.0 / 57600.0,
        0.0,
        -71.0 / 16695.0,
        71.0 / 1920.0,
        -17253.0 / 339200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    )
)
"""Weights of all slopes in the difference of both formulas."""

_PARTED = 2.0**-20
"""Force, relative to the cloth's largest friction, below which a contact counts as parting."""

_MOST_OPEN = 0.875
"""Gap or overlap at the start, in tolerances, above which contact steps close the gap first."""

_PAUSE = 8.0
"""Number of steps of `resting_contact.forces` after a motion that wasn't smooth."""

_TRIALS = 24
"""Largest number of step lengths that are tried."""


@kernel
def integrate(
    world: World,
    members: int,
    count: int,
    longest: float,
    least_length: float,
    shortest: float,
    first: float,
) -> float:
    """Compute the motion of an island for a step of at most `longest` [s]; return its length.

    `first` is the first length tried. No length is below `shortest`. If the error requires less
    than `least_length`, the motion isn't smooth. If the result is positive, the motion is in
    `contacts.paths`, `contacts.spins` and `contacts.motion`, and the remaining rates of the gaps,
    which are bounces within the tolerance, are removed from the velocities. The result is 0 if a
    contact parts or sticks, or a ball stops or starts to slip.
    """
    contacts = world.contacts
    if count > st.MOST_DIRECT or members > st.MOST_DIRECT or not longest > 0.0:
        return 0.0
    moves = False
    for m in range(members):
        k = contacts.member[m]
        is_still = at_rest(world.balls, k)
        if stopping(world.balls, k) and not is_still:
            return 0.0
        contacts.stage[m].is_still = 1.0 if is_still else 0.0
        contacts.motion[k].index = m
        moves = moves or not is_still
    if not moves:
        return 0.0
    if not _rates_are_negligible(world, count):
        return 0.0
    _load(world, members)
    _end_rates(world, count, False)
    for m in range(members):
        for number in range(NUMBERS):
            contacts.start[m, number] = contacts.numbers[m, number]
    if not find_rates(world, members, count):
        return 0.0
    _choose_senses(world, members)
    least = _least_force(world, count)
    if least <= _PARTED:
        return 0.0
    _keep_slopes(contacts, members, 0)
    duration = min(first, longest)
    for _ in range(_TRIALS):
        contacts.turns[0] += 64 * (members + count)
        if duration < shortest:
            return 0.0
        error = _try(world, members, count, duration)
        if error <= 1.0:
            parting = _least_force(world, count)
            spins = _part_of_spins(world, members)
            if parting < 0.0:
                duration *= 0.9 * least / (least - parting)
            elif spins < 1.0:
                duration *= spins
            elif not find_pieces(world, members, count, duration):
                duration *= 0.5
            else:
                good = duration * min(0.85 / _fifth_root(error), 4.0)
                if duration == longest:
                    good = max(good, first)
                for m in range(members):
                    contacts.motion[contacts.member[m]].ahead = good
                return duration
        else:
            duration *= 0.25 if error > 200.0 else 0.9 / _fifth_root(error)
            if duration < least_length:
                break
    for m in range(members):
        contacts.motion[contacts.member[m]].ahead = -_PAUSE
    return 0.0


@kernel(inline=True)
def _choose_senses(world: World, members: int) -> None:
    """Decide whether contacts start a spin about the vertical of members without one."""
    stage = world.contacts.stage
    for m in range(members):
        slowing, twist = (
            world.balls.state[world.contacts.member[m]].spin_slowing,
            stage[m].twist,
        )
        if stage[m].sense == 0.0 and abs(twist) > (1.0 - MOTION_ERROR) * slowing:
            sense = 1.0 if twist > 0.0 else -1.0
            stage[m].sense = sense
            stage[m].bz = twist - sense * slowing
        stage[m].twist_from = twist


@kernel(inline=True)
def _part_of_spins(world: World, members: int) -> float:
    """Return about the fraction of the step after which a spin ends or starts; 1 if none does."""
    contacts = world.contacts
    stage = contacts.stage
    part = 1.0
    for m in range(members):
        ball, sense = world.balls.state[contacts.member[m]], stage[m].sense
        before, after = world.contacts.start[m, 6], stage[m].wz
        if sense != 0.0:
            if after * sense < 0.0 and ball.radius * abs(after) > MOTION_ERROR * _speed(
                contacts, m
            ):
                part = min(part, before / (before - after))
        else:
            was, is_now = abs(stage[m].twist_from), abs(stage[m].twist)
            if is_now > (1.0 + MOTION_ERROR) * ball.spin_slowing:
                part = min(part, (ball.spin_slowing - was) / (is_now - was))
    return part


@kernel(inline=True)
def _speed(contacts: Contacts, m: int) -> float:
    """Return the size of member m's velocity at the start of the step [m/s], in the 1-norm."""
    size: float = abs(contacts.start[m, 2]) + abs(contacts.start[m, 3])
    return size


@kernel
def _fifth_root(x: float) -> float:
    """Return about the fifth root of x, at least 1/4; the step's length needn't be optimal."""
    x = max(x, 2.0**-10)
    root = max(math.sqrt(math.sqrt(x)), 0.25)
    for _ in range(4):
        power = root * root * root * root
        root -= (root - x / power) / 5.0
    return root


@kernel(inline=True)
def _least_force(world: World, count: int) -> float:
    """Return the smallest force relative to the friction of the cloth; inf if all balls rest.

    Without friction of the cloth, the reference is the force that keeps balls on a circle of one
    radius.
    """
    balls, contacts = world.balls, world.contacts
    least = math.inf
    for c in range(count):
        if contacts.forces[c].scaled > 0.0:
            a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
            most = balls.state[a].mass * friction_limit(balls, a)
            if b >= 0:
                most += balls.state[b].mass * friction_limit(balls, b)
            if most == 0.0:
                most = _turning_force(world, a)
                if b >= 0:
                    most += _turning_force(world, b)
            if most > 0.0:
                least = min(least, contacts.forces[c].force / most)
    return least


@kernel(inline=True)
def _turning_force(world: World, k: int) -> float:
    """Return the force [N] that keeps ball k, at its initial speed, on a circle of its radius."""
    ball, speed = world.balls.state[k], _speed(world.contacts, int(world.contacts.motion[k].index))
    force: float = ball.mass * speed * speed / ball.radius
    return force


@kernel(inline=True)
def _load(world: World, members: int) -> None:
    """Put the states of the members into `contacts.stage`."""
    stage = world.contacts.stage
    for m in range(members):
        ball = world.balls.state[world.contacts.member[m]]
        stage[m].x, stage[m].y = ball.x, ball.y
        stage[m].vx, stage[m].vy = ball.vx, ball.vy
        stage[m].wx, stage[m].wy, stage[m].wz = ball.wx, ball.wy, ball.wz
        if ball.phase != st.SLIDING:
            stage[m].wx, stage[m].wy = -ball.vy / ball.radius, ball.vx / ball.radius
        sense = 1.0 if ball.wz > 0.0 else -1.0
        speed = abs(ball.vx) + abs(ball.vy)
        stage[m].sense = sense if ball.radius * abs(ball.wz) > 2.0 * MOTION_ERROR * speed else 0.0


@kernel(inline=True)
def _keep_slopes(contacts: Contacts, members: int, stage: int) -> None:
    """Store the rates of change of the members' states at a stage."""
    for m in range(members):
        row, slope = contacts.stage[m], contacts.slopes[m, stage]
        slope[0], slope[1], slope[2], slope[3] = row.vx, row.vy, row.ax, row.ay
        slope[4], slope[5], slope[6] = row.bx, row.by, row.bz


@kernel
def _try(world: World, members: int, count: int, duration: float) -> float:
    """Compute the motion over a step of `duration` [s]; return its error.

    The error is relative to the allowed error. It is inf if the motion isn't smooth.
    """
    contacts = world.contacts
    for step in range(1, STAGES):
        for m in range(members):
            for number in range(NUMBERS):
                slope = 0.0
                for earlier in range(step):
                    weight = _WEIGHTS[step, earlier]
                    slope += weight * contacts.slopes[m, earlier, number]
                contacts.numbers[m, number] = contacts.start[m, number] + duration * slope
                if number < 2:
                    contacts.numbers[m, DISPLACEMENT_X + number] = duration * slope
        if not find_rates(world, members, count):
            return math.inf
        _keep_slopes(contacts, members, step)
    error = _error_of_motion(world, members, duration)
    for c in range(count):
        _, _, gap, _ = _gap_at(world, c)
        error = max(error, abs(gap) / share_of_gap(world, c, 0.0))
    if error > 1.0:
        return error
    _end_rates(world, count, True)
    find_paths(contacts, members, duration)
    for c in range(count):
        start, _ = gap_along(world, c, 0.0)
        for part in range(1, 4):
            gap, _ = gap_along(world, c, 0.25 * part)
            left = abs(gap) - abs(start)
            error = max(error, left / share_of_gap(world, c, start))
    return error


@kernel(inline=True)
def _error_of_motion(world: World, members: int, duration: float) -> float:
    """Return the estimated error of the velocities, relative to `MOTION_ERROR` of the fastest."""
    fastest, worst = 0.0, 0.0
    for m in range(members):
        radius = world.balls.state[world.contacts.member[m]].radius
        for number in range(2, NUMBERS):
            error = 0.0
            for step in range(STAGES):
                error += _ERROR_WEIGHTS[step] * world.contacts.slopes[m, step, number]
            size = 1.0 if number < 4 else radius
            fastest = max(fastest, size * abs(world.contacts.start[m, number]))
            worst = max(worst, size * duration * abs(error))
    return worst / (MOTION_ERROR * fastest)


@kernel
def _gap_at(world: World, c: int) -> tuple[float, float, float, float]:
    """Return contact c's normal, gap [m] and its rate [m/s], for the states in `contacts.stage`."""
    contacts = world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    stage, i = contacts.stage, int(contacts.motion[a].index)
    x, y, vx, vy = stage[i].x, stage[i].y, -stage[i].vx, -stage[i].vy
    to_x, to_y = 0.0, 0.0
    if b >= 0:
        j = int(contacts.motion[b].index)
        to_x, to_y = stage[j].x, stage[j].y
        vx, vy = stage[j].vx + vx, stage[j].vy + vy
    nx, ny, gap = gap_between(world.balls, world.laws, a, b, x, y, to_x, to_y)
    return nx, ny, gap, nx * vx + ny * vy


@kernel
def _rates_are_negligible(world: World, count: int) -> bool:
    """Return whether every gap is closed, except for bounces within its tolerance."""
    balls, contacts = world.balls, world.contacts
    for c in range(count):
        a, b = balls_of(contacts, c)
        tolerance = contact_tolerance(balls, a, b)
        contacts.forces[c].nx, contacts.forces[c].ny, gap = gap_now(world, c)
        is_closed = abs(gap) <= _MOST_OPEN * tolerance
        pull = 1.5 * (friction_limit(balls, a) + friction_limit(balls, b))
        if not is_closed or not negligible_bounce(gap_rate(world, c), pull, tolerance):
            return False
    return True


@kernel
def _end_rates(world: World, count: int, gaps: bool) -> None:
    """Remove the remaining rates of the gaps, and with `gaps` the gaps, from `contacts.stage`."""
    balls, contacts = world.balls, world.contacts
    stage = contacts.stage
    for _ in range(1 if count == 1 else 4 + 4 * count):
        for c in range(count):
            nx, ny, gap, rate = _gap_at(world, c)
            a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
            # In a step of nanoseconds, removing a gap that is only rounding would need a speed.
            seen = gaps and abs(gap) > gap_rounding(balls, a, b if b >= 0 else a)
            share = 1.0
            if b >= 0:
                mass_a, mass_b = (
                    effective_mass(balls, world.laws, a),
                    effective_mass(balls, world.laws, b),
                )
                share = mass_b / (mass_a + mass_b)
                if stage[int(contacts.motion[b].index)].is_still == 1.0:
                    share = 1.0
            if stage[int(contacts.motion[a].index)].is_still == 1.0:
                share = 0.0
            for k, part in ((a, share), (b, share - 1.0)):
                if k < 0:
                    continue
                m = int(contacts.motion[k].index)
                if stage[m].is_still == 1.0:
                    continue
                stage[m].vx += part * rate * nx
                stage[m].vy += part * rate * ny
                if seen:
                    stage[m].x += part * gap * nx
                    stage[m].y += part * gap * ny
                    stage[m].displacement_x += part * gap * nx
                    stage[m].displacement_y += part * gap * ny
