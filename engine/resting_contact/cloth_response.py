"""How a ball of an island responds to the forces on it, with the cloth's friction, over one step.

The cloth acts too. A member that rolls is given the friction with which it continues rolling, so
that it reacts with 7/5 of its mass, for as long as that is within the limit of sliding friction (or
of rolling friction, if that is greater: what resists rolling also keeps the ball from slipping);
beyond, and where it slides, sliding friction acts against the slip at mid-step.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Laws, World
from ghostball.engine.motion.air import rolling_deceleration, slowed_by_air
from ghostball.engine.motion.geometry import (
    capture_height,
    contact_tolerance,
    friction_limit,
    negligible_bounce,
    rolls_on,
    speed_of,
    stop_distance,
)
from ghostball.engine.motion.next_piece import friction_against, slip

_LEFT_OPEN = 0.125
"""What forces may leave of a gap, in units of its tolerance."""

_LEFT_OVER = 2.0**-6
"""And in units of what the cloth's own force, the whole step long, would make of a gap."""

_BEYOND_INTEGRATION = 2.0**-10
"""Distance, in units of `STOP_DISTANCE`, in which the cloth can end a slip that is integrated no
further: what contacts do meanwhile is left out, and was 1e-5 of the speeds along a cushion."""

_TURN = 0.125
"""Largest change in a step of the velocity that gives friction its direction, over its size."""


@kernel
def accelerate(world: World, k: int, duration: float) -> None:
    """Set member k's accelerations from LOAD_* and TWIST_*, and the cloth's response to them."""
    balls, laws, contacts = world.balls, world.laws, world.contacts
    mass = balls.state[k].mass
    fx, fy = contacts.motion[k].load_x / mass, contacts.motion[k].load_y / mass
    contacts.motion[k].compliance = 1.0 / mass
    # At mid-step, too: as far as the forces so far have it.
    vx = balls.state[k].vx + 0.5 * duration * contacts.motion[k].new_ax
    vy = balls.state[k].vy + 0.5 * duration * contacts.motion[k].new_ay
    fx, fy = slowed_by_air(balls.powers, laws, vx, vy, fx, fy)
    limit = rolling_deceleration(balls.powers, laws, balls.state[k].roll_slowing, vx, vy)
    if not laws.slides:
        _roll(world, k, duration, fx, fy, limit)
        return
    radius = balls.state[k].radius
    gx = 2.5 * contacts.motion[k].twist_x / (mass * radius)
    gy = 2.5 * contacts.motion[k].twist_y / (mass * radius)
    ux, uy = slip(balls, k)
    # Without the cloth the slip would change so [m/s^2]; its friction over the mass changes it by
    # 7/2 of itself.
    dux, duy = fx - radius * gy, fy + radius * gx
    cx, cy = -(ux / duration + dux) / 3.5, -(uy / duration + duy) / 3.5
    size = speed_of(cx, cy)
    rolls = ux == 0.0 and uy == 0.0 and size <= friction_limit(balls, k)
    contacts.motion[k].slips = 0.0 if rolls else 1.0
    if rolls:
        contacts.motion[k].compliance /= 1.4
        _roll(world, k, duration, fx + cx, fy + cy, limit)
        contacts.motion[k].new_bx = -contacts.motion[k].new_ay / radius
        contacts.motion[k].new_by = contacts.motion[k].new_ax / radius
        return
    if size > balls.state[k].slide_slowing:
        mid_x, mid_y = ux + 0.5 * duration * dux, uy + 0.5 * duration * duy
        cx, cy = _resist(mid_x, mid_y, balls.state[k].slide_slowing, 1.75 * duration)
    contacts.motion[k].new_ax = fx + cx
    contacts.motion[k].new_ay = fy + cy
    contacts.motion[k].new_bx = gx + 2.5 * cy / radius
    contacts.motion[k].new_by = gy - 2.5 * cx / radius


@kernel
def _roll(world: World, k: int, duration: float, fx: float, fy: float, limit: float) -> None:
    """Set the acceleration of a member that rolls or rests: drive less rolling friction.

    `limit` is the most that this slows it by [m/s^2].
    """
    balls, contacts = world.balls, world.contacts
    vx, vy = balls.state[k].vx, balls.state[k].vy
    if stopping(balls, k):
        # So slow, or at rest: the cloth brings it to rest by the end of the step if mu m g can,
        # else it resists with that.
        ux, uy = vx / duration + fx, vy / duration + fy
        size = speed_of(ux, uy)
        if size <= limit:
            contacts.motion[k].new_ax = -vx / duration
            contacts.motion[k].new_ay = -vy / duration
            contacts.motion[k].compliance = 0.0
        else:
            contacts.motion[k].new_ax = fx - limit * (ux / size)
            contacts.motion[k].new_ay = fy - limit * (uy / size)
        return
    mid_x, mid_y = vx + 0.5 * duration * fx, vy + 0.5 * duration * fy
    rx, ry = _resist(mid_x, mid_y, limit, 0.5 * duration)
    contacts.motion[k].new_ax = fx + rx
    contacts.motion[k].new_ay = fy + ry


@kernel
def _resist(x: float, y: float, limit: float, gain: float) -> tuple[float, float]:
    """Return the friction, over the mass [m/s^2], against a motion that is (x, y) [m/s] without it.

    All at mid-step: friction changes that motion by `gain` [s] of itself, so that both have one
    direction, and it may be less than its limit only where it ends the motion.
    """
    size = speed_of(x, y)
    if size <= gain * limit:
        return -x / gain, -y / gain
    return friction_against(x, y, limit)


@kernel
def stopping(balls: Balls, k: int) -> bool:
    """Whether the cloth alone would stop ball k, rolling, within `CAPTURE_HEIGHT`; or has."""
    ux, uy = slip(balls, k)
    if ux != 0.0 or uy != 0.0:
        return False
    speed = speed_of(balls.state[k].vx, balls.state[k].vy)
    return negligible_bounce(speed, balls.state[k].roll_slowing, capture_height(balls, k, k))


@kernel
def permitted_gap(balls: Balls, i: int, j: int, duration: float) -> float:
    """Return what forces may leave of the gap of balls i and j [m] at the end of a step.

    For a ball and a cushion, j is i.
    """
    cloth = 0.5 * duration * duration * max(friction_limit(balls, i), friction_limit(balls, j))
    left: float = min(_LEFT_OPEN * contact_tolerance(balls, i, j), _LEFT_OVER * cloth)
    return left


@kernel
def keep_still(world: World, k: int, duration: float) -> None:
    """Bring member k to rest, or leave it there, where what moves it is what forces are off by."""
    balls, contacts = world.balls, world.contacts
    if contacts.motion[k].overlaps == 1.0 or not stopping(balls, k):
        return
    x = balls.state[k].vx + duration * contacts.motion[k].new_ax
    y = balls.state[k].vy + duration * contacts.motion[k].new_ay
    if duration * speed_of(x, y) <= 2.0 * permitted_gap(balls, k, k, duration):
        contacts.motion[k].new_ax = -balls.state[k].vx / duration
        contacts.motion[k].new_ay = -balls.state[k].vy / duration


@kernel
def slip_ends(world: World, k: int) -> bool:
    """Whether the cloth alone would end ball k's slip within `STOP_DISTANCE`.

    A slip that is integrated is so nearly to the end.
    """
    balls = world.balls
    ux, uy = slip(balls, k)
    size = speed_of(ux, uy)
    distance = stop_distance(balls, k)
    if world.contacts.motion[k].ahead > 0.0:
        distance *= _BEYOND_INTEGRATION
    return size > 0.0 and negligible_bounce(size, balls.state[k].slide_slowing, distance)


@kernel
def end_slip(world: World, k: int) -> bool:
    """End ball k's slip now, if it is settling; return whether it is.

    As the cloth would: 2/7 of the slip leave the velocity.
    """
    balls = world.balls
    if not slip_ends(world, k):
        return False
    ux, uy = slip(balls, k)
    balls.state[k].vx -= ux / 3.5
    balls.state[k].vy -= uy / 3.5
    balls.state[k].phase = st.ROLLING
    return True


@kernel
def time_to_change(balls: Balls, k: int) -> float:
    """Return how long a step may be [s] so that the cloth takes half of k's slip, or speed."""
    ux, uy = slip(balls, k)
    size = speed_of(ux, uy)
    if size > 0.0:
        friction = balls.state[k].slide_slowing
        return 0.5 * size / (3.5 * friction) if friction > 0.0 else math.inf
    speed = speed_of(balls.state[k].vx, balls.state[k].vy)
    free = stopping(balls, k) or balls.state[k].roll_slowing == 0.0
    return math.inf if free else 0.5 * speed / balls.state[k].roll_slowing


@kernel
def turns_little(world: World, k: int, duration: float) -> bool:
    """Whether member k's friction keeps its direction over a step of this length."""
    balls, contacts = world.balls, world.contacts
    ax, ay = contacts.motion[k].new_ax, contacts.motion[k].new_ay
    ux, uy = slip(balls, k)
    size = speed_of(ux, uy)
    if size > 0.0:
        radius = balls.state[k].radius
        dux = duration * (ax - radius * contacts.motion[k].new_by)
        duy = duration * (ay + radius * contacts.motion[k].new_bx)
        across = abs((ux / size) * duy - (uy / size) * dux)
        left = size + (ux / size) * dux + (uy / size) * duy
        return bool(across <= _TURN * size and left > 0.25 * size)
    if balls.state[k].roll_slowing == 0.0:
        return True  # no friction: what speed is left may be but rounding, of any direction
    speed = speed_of(balls.state[k].vx, balls.state[k].vy)
    return bool(duration * speed_of(ax, ay) <= _TURN * speed or stopping(balls, k))


@kernel
def effective_mass(balls: Balls, laws: Laws, k: int) -> float:
    """Mass [kg] with which member k responds to a negligible impulse.

    One that rolls, or rests, rolls on: the cloth ends so small a slip within part of
    `CAPTURE_HEIGHT`.
    """
    rolls = laws.slides and rolls_on(balls, k)
    mass: float = 1.4 * balls.state[k].mass if rolls else balls.state[k].mass
    return mass
