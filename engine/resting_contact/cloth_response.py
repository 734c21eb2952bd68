"""Acceleration of an island's ball by contact forces and the cloth's friction, in one step.

A rolling member gets the friction with which it keeps rolling, so that it responds with 7/5 of its
mass, as long as this friction is within the limit of sliding friction (or of rolling friction, if
larger: the resistance to rolling also keeps the ball from slipping). Beyond the limit, and for a
sliding member, sliding friction acts against the slip at mid-step.
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
from ghostball.engine.motion.position import slowed_spin

_LEFT_OPEN = 0.125
"""Gap that forces may leave, relative to its tolerance."""

_LEFT_OVER = 2.0**-6
"""Gap that forces may leave, relative to the gap that the cloth's force makes in the whole step."""

_BEYOND_INTEGRATION = 2.0**-10
"""Distance, relative to `STOP_DISTANCE`, in which the cloth can end a slip that is integrated no
further. The effect of contacts during this distance is neglected; along a cushion it was 1e-5 of
the speeds.
"""

_TURN = 0.125
"""Largest relative change, in a step, of the velocity that gives friction its direction."""


@kernel
def accelerate(world: World, k: int, duration: float) -> None:
    """Set member k's accelerations from its load, its twist and the response of the cloth."""
    balls, laws, contacts = world.balls, world.laws, world.contacts
    mass = balls.state[k].mass
    fx, fy = contacts.motion[k].load_x / mass, contacts.motion[k].load_y / mass
    contacts.motion[k].compliance = 1.0 / mass
    # The velocity at mid-step, with the acceleration by the present forces.
    vx = balls.state[k].vx + 0.5 * duration * contacts.motion[k].new_ax
    vy = balls.state[k].vy + 0.5 * duration * contacts.motion[k].new_ay
    fx, fy = slowed_by_air(balls, laws, vx, vy, fx, fy)
    limit = rolling_deceleration(balls, laws, balls.state[k].roll_slowing, vx, vy)
    if not laws.slides:
        _roll(world, k, duration, fx, fy, limit)
        return
    radius = balls.state[k].radius
    gx = 2.5 * contacts.motion[k].twist_x / (mass * radius)
    gy = 2.5 * contacts.motion[k].twist_y / (mass * radius)
    ux, uy = slip(balls, k)
    # Rate of change of the slip without the cloth [m/s^2]. A friction F of the cloth changes this
    # rate by 7/2 F / m.
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
    """Set the acceleration of a member that rolls or rests: drive minus rolling friction.

    `limit`: largest deceleration by rolling friction [m/s^2].
    """
    balls, contacts = world.balls, world.contacts
    vx, vy = balls.state[k].vx, balls.state[k].vy
    if stopping(balls, k):
        # The ball is at rest or very slow. The cloth brings it to rest by the end of the step if
        # its limit permits; if not, the cloth resists with the limit.
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

    Everything is at mid-step. Friction changes the motion by `gain` [s] times itself, so both have
    the same direction. Friction is below its limit only if it ends the motion.
    """
    size = speed_of(x, y)
    if size <= gain * limit:
        return -x / gain, -y / gain
    return friction_against(x, y, limit)


@kernel(inline=True)
def spin_after(world: World, k: int, duration: float) -> float:
    """Return member k's spin about the vertical after a step, by contacts and cloth [rad/s]."""
    ball = world.balls.state[k]
    gain = 2.5 * world.contacts.motion[k].twist_z / (ball.mass * ball.radius)
    return slowed_spin(ball.wz + duration * gain, duration * ball.spin_slowing)


@kernel
def stopping(balls: Balls, k: int) -> bool:
    """Return whether ball k rests, or the cloth alone would stop its roll in `CAPTURE_HEIGHT`."""
    ux, uy = slip(balls, k)
    if ux != 0.0 or uy != 0.0:
        return False
    speed = speed_of(balls.state[k].vx, balls.state[k].vy)
    return negligible_bounce(speed, balls.state[k].roll_slowing, capture_height(balls, k, k))


@kernel
def permitted_gap(balls: Balls, i: int, j: int, duration: float) -> float:
    """Return the gap of balls i and j [m] that forces may leave at the end of a step.

    For a ball and a cushion, j is i.
    """
    cloth = 0.5 * duration * duration * max(friction_limit(balls, i), friction_limit(balls, j))
    left: float = min(_LEFT_OPEN * contact_tolerance(balls, i, j), _LEFT_OVER * cloth)
    return left


@kernel
def keep_still(world: World, k: int, duration: float) -> None:
    """Bring member k to rest, or keep it at rest, if its motion is within the error of forces."""
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
    """Return whether the cloth alone would end ball k's slip within `STOP_DISTANCE`.

    A slip that is integrated continues almost to its end.
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
    """End ball k's slip now if `slip_ends`; return whether it has ended.

    The velocity loses 2/7 of the slip, as by the friction of the cloth.
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
    """Return the longest step in which the cloth takes at most half of k's slip or speed [s]."""
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
    """Return whether the direction of member k's friction stays nearly constant over a step."""
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
        return True  # without friction, the remaining speed may be rounding, of any direction
    speed = speed_of(balls.state[k].vx, balls.state[k].vy)
    return bool(duration * speed_of(ax, ay) <= _TURN * speed or stopping(balls, k))


@kernel
def effective_mass(balls: Balls, laws: Laws, k: int) -> float:
    """Return the mass [kg] with which member k responds to a negligible impulse.

    A ball that rolls, or rests, keeps rolling: the cloth ends such a small slip within a part of
    `CAPTURE_HEIGHT`.
    """
    rolls = laws.slides and rolls_on(balls, k)
    mass: float = 1.4 * balls.state[k].mass if rolls else balls.state[k].mass
    return mass
