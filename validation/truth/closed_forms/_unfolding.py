"""Closed forms by unfolding: in reflected space, a path with many collisions is a straight line."""

from __future__ import annotations

from mpmath import mp

from ghostball.validation.truth.closed_forms._motion import along, cloth_of, length_of
from ghostball.validation.truth.closed_forms._setup import Collision, FormResult, OrderError, Setup


def unfolded_bounces(setup: Setup) -> FormResult:
    """Solve one ball on a table with mirror cushions, by unfolding.

    The ball's centre moves in a box of (length - 2R) by (width - 2R). Reflecting the box instead of
    the ball makes the path a straight line of length v^2 / (2 mu g). Folding its end back gives the
    rest position, and the number of box sides that it crosses gives the bounces.
    """
    (position,), (velocity,), (radius,) = setup.positions, setup.velocities, setup.radii
    if setup.length is None or setup.width is None or len(setup.cushions) != 4 or setup.slides:
        raise OrderError("unfolding needs a ball that rolls and four cushions")
    returned = setup.cushion_restitution, setup.cushion_tangential_restitution
    if setup.verify and (returned != (1, 1) or setup.cushion_restitution_loss != 0):
        raise OrderError("unfolding needs cushions that mirror")
    speed, deceleration = length_of(velocity), cloth_of(setup, 0).rolling
    end = along(position, speed / (2 * deceleration), velocity)
    sides = (("left", "right"), ("bottom", "top"))
    rest, crossings = [], []
    for axis, extent in enumerate((setup.length, setup.width)):
        box = extent - 2 * radius
        cell = int(mp.floor((end[axis] - radius) / box))
        inside = end[axis] - radius - cell * box
        rest.append(radius + (inside if cell % 2 == 0 else box - inside))
        # The side between cells k - 1 and k is the low one if k is even.
        edges = range(1, cell + 1) if cell > 0 else range(0, cell, -1)
        for edge in edges:
            ahead = (radius + edge * box - position[axis]) * speed / velocity[axis]
            crossings.append((ahead, sides[axis][edge % 2]))
    crossings.sort()
    collisions: list[Collision] = [("ball-cushion", 0, side) for _, side in crossings]
    return FormResult.at_rest([(rest[0], rest[1])], speed / deceleration, collisions)


def unfolded_masses(setup: Setup) -> FormResult:
    """Solve two balls and one cushion, without friction, by unfolding their configuration space.

    Galperin 2003, Regular and Chaotic Dynamics 8(4) 375. Let q1 be the small ball's gap to the left
    cushion, and q2 the large ball's gap to the place where both would touch. In the plane (X, Y) =
    (sqrt(M) q2, sqrt(m) q1) the energy is that of one free point, and 0 <= q1 <= q2 is a wedge of
    angle theta = atan(sqrt(m / M)). Unfolded, the point moves on a straight line. It crosses the
    angle k theta at the k-th collision (odd: ball-ball, even: cushion), so their number is the
    number of multiples of theta between its first and its last angle. If M arrives and m is at
    rest, this is ceil(pi / theta) - 1: 3, 31, 314, ... for M / m = 100^k.

    Both centres are on one line perpendicular to the cushion, and stay there in any arithmetic,
    because the normal's other component is exactly 0. Nudging one ball off the line, which
    thousands of collisions would amplify, therefore doesn't count for the conditioning: each ball
    keeps its own y.
    """
    (small, large), (v_small, v_large) = setup.positions, setup.velocities
    reach = setup.radii[0] + setup.radii[1]
    q1 = small[0] - setup.radii[0]
    q2 = large[0] - setup.radii[0] - reach
    if setup.verify and (small[1] != large[1] or v_small[1] != 0 or v_large[1] != 0):
        raise OrderError("the balls must move on one line across the cushion")
    weights = (mp.sqrt(setup.masses[1]), mp.sqrt(setup.masses[0]))
    if setup.t_max is None or any(setup.rolling_frictions) or setup.cushions != ("left",):
        raise OrderError("needs t_max, no rolling friction and the left cushion alone")
    returned = setup.ball_restitution, setup.cushion_restitution
    if setup.verify and (returned != (1, 1) or setup.cushion_restitution_loss != 0):
        raise OrderError("needs elastic collisions")
    start = (weights[0] * q2, weights[1] * q1)
    motion = (weights[0] * v_large[0], weights[1] * v_small[0])
    theta = mp.atan2(weights[1], weights[0])
    point = along(start, setup.t_max, motion)
    angle = mp.atan2(point[1], point[0])
    count = int(mp.floor(angle / theta))
    if angle < mp.atan2(start[1], start[0]):
        raise OrderError("the balls must close in on the cushion")
    # Fold the angle and, by the same reflections, the motion.
    direction = mp.atan2(motion[1], motion[0])
    if count % 2 == 0:
        angle, direction = angle - count * theta, direction - count * theta
    else:
        angle, direction = (count + 1) * theta - angle, (count + 1) * theta - direction
    radius, speed = length_of(point), length_of(motion)
    gaps = (radius * mp.cos(angle) / weights[0], radius * mp.sin(angle) / weights[1])
    rates = (speed * mp.cos(direction) / weights[0], speed * mp.sin(direction) / weights[1])
    zero = mp.mpf(0)
    return FormResult(
        ((setup.radii[0] + gaps[1], small[1]), (setup.radii[0] + reach + gaps[0], large[1])),
        ((rates[1], zero), (rates[0], zero)),
        setup.t_max,
        tuple(
            ("ball-ball", 0, 1) if k % 2 == 1 else ("ball-cushion", 0, "left")
            for k in range(1, count + 1)
        ),
    )
