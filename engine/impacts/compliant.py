"""Impacts that last: balls that push each other at the same time, integrated over their contacts.

A contact of two pool balls lasts 0.2 to 0.3 ms and closes up to 0.9 mm, so the gaps of a rack close
while its first contact still lasts. Impacts at one instant, or one after another, are a poor model
there. Here the balls of a cluster move by the forces of their contacts: along the normal by
`impacts.hertz`, across the normal by Coulomb's friction mu F s / sqrt(s^2 + s0^2), where s is the
slip. The limit s0 is 0.0075 of the fastest approach, or as much as the step needs to stay
stable. Contacts turn the balls, and don't lift them: the cloth takes an upward impulse.

The motion is integrated by the classical Runge-Kutta method, with `STEPS` steps for the duration of
the fastest impact. The force isn't smooth where a contact begins, so steps end there: a step across
a beginning contact is taken again, up to the instant at which the balls touch. A leg of the motion
lasts until then, at most `LEG_STEPS` steps. `event_loop.compression` starts legs, and records them.

Contacts push a ball a thousand times as hard as the cloth does. So the cloth acts only in legs in
which nothing touches the ball. A ball that reaches an obstacle bounces off by the obstacle's law at
the end of a leg. If other balls push the ball back, the ball stays at the obstacle.

Forces on a ball are added in the order of its contacts. So a mirrored shot has the same bits, and a
shot with renumbered balls has the same numbers to rounding.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws, World
from ghostball.engine.impacts.hertz import contact_time
from ghostball.engine.impacts.lasting_contacts import (
    APART,
    BEGINS,
    CONTACT,
    ENERGY,
    FIRST_SLOPE,
    FROM,
    IS_TOUCHED,
    LIES,
    LYING,
    NOW_X,
    PHASE,
    REACHED,
    SLOPE,
    SPEED,
    STATE,
    STIFFNESS,
    SUM,
    TOUCHING,
    find_slopes,
    gap_of,
    is_changed,
    put_apart_last,
    put_free_last,
)

STEPS = 88
"""Number of steps for the duration of the fastest impact of a cluster.

With this number, the speeds after a break at 10.7 m/s are within 1e-5 m/s of those with a tenth of
the step: see `tests/engine/impacts/test_compliant.py`.
"""

LEG_STEPS = 44
"""Largest number of steps after which the balls near a cluster are looked for again."""

_SLIP = 0.0075
"""Slip below which friction falls, in units of the fastest approach.

0.08 m/s at 10 m/s. A third less needs a quarter more steps for the same error: the friction then
changes faster where a slip reverses.
"""

_STABLE_SLIP = 6.0 / STEPS
"""Least `_SLIP` with which the integration is stable, for a coefficient of friction of 1.

Friction ends a slip at the rate 7 mu F / m s0, and the force F of an impact is at most 1.84 m v
over its duration. So that rate times the step is at most 2.2; the method is stable up to 2.78.
"""

_LOCATIONS = 4
"""Largest number of tries to end a step where a contact begins; one or two are enough."""

_WORK_OF_STEP = 8
_WORK_OF_CONTACT = 4
"""Units of work of a step, and of each of its contacts and balls."""


@kernel
def step_of(world: World, count: int, speed: float) -> float:
    """Return the step [s] for the first `count` contacts, at `speed` [m/s]; inf: no two balls."""
    columns, stiffest, energy = world.contacts.columns, 0.0, 0.0
    for c in range(count):
        if world.contacts.ends[c, st.SECOND] >= 0 and columns[c, ENERGY] > energy:
            stiffest, energy = columns[c, STIFFNESS], columns[c, ENERGY]
    if energy == 0.0:
        return math.inf
    return contact_time(speed, stiffest, 0.8 * (stiffest / energy)) / STEPS


@kernel
def run_leg(world: World, members: int, count: int, step: float, longest: int) -> float:
    """Integrate the first `members` balls of `contacts.member` over one leg; return its duration.

    The leg ends when a contact begins, a ball reaches an obstacle, or no balls touch any more, and
    after `longest` steps at the latest. The state at its end is in the columns from FROM on.
    CONTACT marks contacts that begin, and REACHED balls that reach an obstacle.

    Contract: no allocation; every member's columns up to RADIUS and from SPEED on are set, and the
    first `count` contacts of `contacts.ends` include all pairs and obstacles that can touch during
    the leg.
    """
    contacts = world.contacts
    rows = contacts.compressed
    slip = _least_slip(world.laws, rows[contacts.member[0], SPEED])
    active = put_apart_last(world, count)
    pushed = put_free_last(world, members, active)
    for m in range(members):
        k = contacts.member[m]
        rows[k, IS_TOUCHED] = 0.0
        for n in range(STATE):
            rows[k, n] = rows[k, FROM + n]
    find_slopes(world, pushed, active, slip)
    lasted = 0.0
    for _ in range(longest):
        world.balls.counters[st.WORK] += _WORK_OF_STEP + _WORK_OF_CONTACT * (count + members)
        for m in range(pushed):
            k = contacts.member[m]
            for n in range(STATE):
                rows[k, FIRST_SLOPE + n] = rows[k, SLOPE + n]
        duration, ends = step, False
        _take_step(world, members, pushed, active, duration, slip)
        if is_changed(world, count):
            for _ in range(_LOCATIONS):
                shorter = _until_contact(world, count, duration)
                if shorter == duration:
                    break
                duration = shorter
                _take_step(world, members, pushed, active, duration, slip)
            ends = _update_contacts(world, count)
        lasted += duration
        for m in range(members):
            k = contacts.member[m]
            for n in range(STATE if m < pushed else 2):
                rows[k, FROM + n] = rows[k, n]
        if ends:
            break
        find_slopes(world, pushed, active, slip)
    return lasted


@kernel
def _least_slip(laws: Laws, speed: float) -> float:
    """Return s0 [m/s], for a fastest approach at `speed` [m/s]."""
    friction = 0.12 if laws.speed_dependent else laws.ball_friction
    return speed * max(_SLIP, _STABLE_SLIP * friction)


@kernel
def _take_step(world: World, members: int, pushed: int, active: int, h: float, slip: float) -> None:
    """Set the state to the state h seconds after the start of the step.

    Only the first `pushed` members are in one of the first `active` contacts.
    """
    contacts = world.contacts
    rows = contacts.compressed
    for m in range(pushed, members):
        k = contacts.member[m]
        for n in range(2):
            rows[k, n] = rows[k, FROM + n] + h * rows[k, FROM + 2 + n]
    for m in range(pushed):
        k = contacts.member[m]
        for n in range(STATE):
            slope = rows[k, FIRST_SLOPE + n]
            rows[k, SUM + n] = slope
            rows[k, n] = rows[k, FROM + n] + 0.5 * h * slope
    find_slopes(world, pushed, active, slip)
    _next_stage(world, pushed, 0.5 * h)
    find_slopes(world, pushed, active, slip)
    _next_stage(world, pushed, h)
    find_slopes(world, pushed, active, slip)
    sixth = h / 6.0
    for m in range(pushed):
        k = contacts.member[m]
        for n in range(STATE):
            rows[k, n] = rows[k, FROM + n] + sixth * (rows[k, SUM + n] + rows[k, SLOPE + n])


@kernel
def _next_stage(world: World, pushed: int, h: float) -> None:
    """Add the slopes of a middle stage to the sums, and set the state h seconds along them."""
    contacts = world.contacts
    rows = contacts.compressed
    for m in range(pushed):
        k = contacts.member[m]
        for n in range(STATE):
            slope = rows[k, SLOPE + n]
            rows[k, SUM + n] += 2.0 * slope
            rows[k, n] = rows[k, FROM + n] + h * slope


@kernel
def _until_contact(world: World, count: int, duration: float) -> float:
    """Return the step [s] to the first contact that begins, or `duration` if none does.

    The step is shortened if a contact that begins has an overlap of more than four times LYING at
    its end, for balls that lie against each other, too. The gap between both ends of a step is the
    cubic with the same values and rates.
    """
    shortest = duration
    for c in range(count):
        gap, rate = gap_of(world, c, NOW_X)
        contact = world.contacts.columns[c, CONTACT]
        if contact not in (APART, LIES) or gap >= -4.0 * LYING:
            continue
        before, rate_before = gap_of(world, c, FROM)
        low, high = 0.0, 1.0
        for _ in range(48):
            u = 0.5 * (low + high)
            v = 1.0 - u
            cubic = v * v * ((1.0 + 2.0 * u) * before + u * (rate_before * duration))
            cubic += u * u * ((3.0 - 2.0 * u) * gap - v * (rate * duration))
            if cubic > -2.0 * LYING:
                low = u
            else:
                high = u
        shortest = min(shortest, high * duration)
    return shortest


@kernel
def _update_contacts(world: World, count: int) -> bool:
    """Update CONTACT after a step; return whether the leg ends here."""
    contacts = world.contacts
    columns, touching, begins = contacts.columns, 0, False
    for c in range(count):
        contact = columns[c, CONTACT]
        gap, _ = gap_of(world, c, NOW_X)
        is_ball = contacts.ends[c, st.SECOND] >= 0
        if contact == APART and gap < 0.0:
            columns[c, CONTACT], begins = BEGINS, True
            if not is_ball:
                first = contacts.ends[c, st.FIRST]
                contacts.compressed[first, REACHED] = -contacts.ends[c, st.SECOND]
        elif contact == LIES and gap < -LYING:
            columns[c, CONTACT], begins = BEGINS, True
        elif gap > LYING:
            columns[c, CONTACT] = APART
        if is_ball and columns[c, CONTACT] in (TOUCHING, BEGINS) and gap < 0.0:
            touching += 1
    return begins or touching == 0


@kernel
def rub_on_cloth(balls: Balls, rows: FloatArray, laws: Laws, k: int, lasted: float) -> None:
    """Let the cloth and the air slow ball k for the duration of a leg [s] in which nothing hits it.

    A slide or a roll that would end within the leg isn't slowed: it ends after the cluster.
    """
    ball = balls.state[k]
    vx, vy = rows[k, FROM + 2], rows[k, FROM + 3]
    if rows[k, PHASE] == st.SLIDING:
        ux = vx - ball.radius * rows[k, FROM + 5]
        uy = vy + ball.radius * rows[k, FROM + 4]
        slip, part = math.sqrt(ux * ux + uy * uy), ball.slide_slowing * lasted
        if 3.5 * part < slip:
            cx, cy = -part * (ux / slip), -part * (uy / slip)
            vx, vy = vx + cx, vy + cy
            rows[k, FROM + 4] += 2.5 * cy / ball.radius
            rows[k, FROM + 5] -= 2.5 * cx / ball.radius
    else:
        square = vx * vx + vy * vy
        speed = math.sqrt(square)
        part = (ball.roll_slowing + laws.roll_quadratic * square) * lasted
        if part < speed:
            vx, vy = vx - part * (vx / speed), vy - part * (vy / speed)
    if laws.air_drag > 0.0:
        slower = 1.0 / (1.0 + laws.air_drag * math.sqrt(vx * vx + vy * vy) * lasted)
        vx, vy = slower * vx, slower * vy
    rows[k, FROM + 2], rows[k, FROM + 3] = vx, vy
    spin, loss = rows[k, FROM + 6], ball.spin_slowing * lasted
    if abs(spin) > loss:
        rows[k, FROM + 6] = spin - math.copysign(loss, spin)
