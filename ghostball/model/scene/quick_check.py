"""Fast check for scenes with few balls: whether the initial state certainly keeps the rules.

Each condition here is sufficient for some of the rules in `scene.rules` and `scene.motion_rules`,
with the same limits and tolerances. If a condition fails, the rules decide, and make the message.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence

from ghostball.model.rounding import CONTACT_TOLERANCE, position_rounding
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.fields import LARGEST, MAX_DRAG_RATE, MAX_FALL_DRAG, MAX_IMPACTS
from ghostball.model.scene.table import Table

MAX_BALLS = 64
"""Number of balls up to which this check is faster than the rules, which use arrays."""

_LEAST_DISTANCE = 1.0 - CONTACT_TOLERANCE
"""Smallest distance of two balls, in sums of their radii; see `permitted_overlap`."""

_LEAST_CUSHION_DISTANCE = 1.0 - 2.0 * CONTACT_TOLERANCE
"""Smallest distance of a ball from a cushion, in radii."""

_SPEED_MARGIN = 2.0
"""Factor on speeds, larger than the rounding in the formulas of the rules."""


def certainly_valid(scene: SceneContents) -> bool:
    """Return whether names, places and motions of balls certainly keep the rules.

    If False, the rules must decide.
    """
    balls, flies = scene.balls, scene.physics.airborne
    if len(balls) > MAX_BALLS or len({ball.id for ball in balls}) < len(balls):
        return False
    places = sorted([(*ball.position, ball.radius) for ball in balls])  # along x
    x, y, z, radii = zip(*places, strict=True)
    if z != radii and not (flies and all(map(operator.ge, z, radii))):
        return False
    up = [ball.velocity[2] for ball in balls]
    if min(up) < 0.0 or (max(up) > 0.0 and not flies):
        return False
    return (
        _are_inside(x, y, max(radii), scene.table)
        and position_rounding(max(x[-1], -x[0]), max(*y, -min(y))) < min(radii)
        and _are_apart(x, y, radii)
        and _has_valid_motion(scene)
    )


def _are_inside(x: Sequence[float], y: Sequence[float], radius: float, table: Table | None) -> bool:
    """Return whether balls of at most this radius are inside four cushions, away from pockets.

    False if the table is a polygon or has posts.
    """
    if table is None:
        return True
    if table.vertices or table.posts:
        return False
    reach = radius * _LEAST_CUSHION_DISTANCE
    across = reach <= x[0] and x[-1] <= table.length - reach
    along = reach <= min(y) and max(y) <= table.width - reach
    return across and along and table.has_holes_beyond(reach)


def _are_apart(x: Sequence[float], y: Sequence[float], radii: Sequence[float]) -> bool:
    """Return whether balls don't overlap, seen from above; `x` ascends."""
    widest = 2.0 * max(radii)
    for k in range(1, len(x)):
        for j in range(k - 1, -1, -1):
            dx, dy = x[k] - x[j], y[k] - y[j]
            if dx >= widest:
                break
            away = dx * dx + dy * dy
            if away < widest * widest and away < ((radii[k] + radii[j]) * _LEAST_DISTANCE) ** 2:
                return False
    return True


def _has_valid_motion(scene: SceneContents) -> bool:
    """Return whether the motion stays within doubles, and ends unless `t_max` is given."""
    balls, physics = scene.balls, scene.physics
    fastest = max([math.hypot(*ball.velocity) for ball in balls])
    for ball in balls:
        if ball.angular_velocity is not None:
            if physics.motion == "rolling":
                return False
            fastest = max(fastest, ball.radius * math.hypot(*ball.angular_velocity))
    fastest *= _SPEED_MARGIN
    drag = max(physics.air_drag, physics.rolling_friction_quadratic)
    falls = physics.airborne and physics.air_drag * physics.gravity > MAX_FALL_DRAG
    if fastest > LARGEST or drag * fastest > MAX_DRAG_RATE or falls:
        return False
    return scene.t_max is not None or _come_to_rest(scene, fastest)


def _come_to_rest(scene: SceneContents, fastest: float) -> bool:
    """Return whether balls of at most this speed [m/s] rest soon enough, however they collide."""
    balls, physics, table = scene.balls, scene.physics, scene.table
    if physics.airborne and physics.table_restitution == 1.0:
        return False
    rolls = _least(physics.rolling_friction, [ball.rolling_friction for ball in balls])
    if fastest > LARGEST * (rolls * physics.gravity):
        return False
    if physics.motion == "rolling":
        # Balls between four elastic cushions rest when rolling has dissipated all of their energy.
        masses = [ball.mass for ball in balls]
        energy, slowing = 0.5 * max(masses) * fastest**2, min(masses) * rolls * physics.gravity
        return table is None or energy <= MAX_IMPACTS * slowing * table.length
    slides = _least(physics.sliding_friction, [ball.sliding_friction for ball in balls])
    spins = _least(
        physics.spinning_friction_rate or LARGEST,  # the run doesn't wait for spin without friction
        [ball.spinning_friction_rate or None for ball in balls],
    )
    least = min([ball.radius for ball in balls])
    return fastest <= LARGEST * min(slides * physics.gravity, least * spins)


def _least(shared: float, own: Sequence[float | None]) -> float:
    """Return the smallest of a shared number and the numbers that some balls have."""
    return min([shared, *[one for one in own if one is not None]])
