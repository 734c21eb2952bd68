"""Whether a scene of few balls plainly keeps the rules of how balls begin: sooner than by arrays.

Each condition here suffices for some of the rules in `scene.rules` and `scene.motion_rules`, with
their limits and tolerances, and none says more: where one isn't met, those rules decide, and word
what they refuse.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence

from ghostball.model.rounding import CONTACT_TOLERANCE, position_rounding
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.fields import FASTEST_DRAG, FASTEST_FALL, LARGEST, MOST_IMPACTS
from ghostball.model.scene.table import Table

FEW = 64
"""Balls up to which this is faster than arrays."""

_TOUCHING = 1.0 - CONTACT_TOLERANCE
"""How near two balls may be, in the sum of their radii, at least: see `permitted_overlap`."""

_BESIDE = 1.0 - 2.0 * CONTACT_TOLERANCE
"""How near a ball may be to a cushion, in its radius, at least."""

_MARGIN = 2.0
"""How much too large speeds are taken: more than the formulas of the rules round."""


def begins_plainly(scene: SceneContents) -> bool:
    """Whether balls plainly begin in order, by name, place and motion; False: ask the rules."""
    balls, flies = scene.balls, scene.physics.airborne
    if len(balls) > FEW or len({ball.id for ball in balls}) < len(balls):
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
        and _move_well(scene)
    )


def _are_inside(x: Sequence[float], y: Sequence[float], radius: float, table: Table | None) -> bool:
    """Whether balls no wider are between the lines of four cushions, with nothing else there."""
    if table is None:
        return True
    if table.vertices or table.posts:
        return False
    reach = radius * _BESIDE
    across = reach <= x[0] and x[-1] <= table.length - reach
    along = reach <= min(y) and max(y) <= table.width - reach
    return across and along and table.has_holes_beyond(reach)


def _are_apart(x: Sequence[float], y: Sequence[float], radii: Sequence[float]) -> bool:
    """Whether balls don't overlap as seen from above; x ascends."""
    widest = 2.0 * max(radii)
    for k in range(1, len(x)):
        for j in range(k - 1, -1, -1):
            dx, dy = x[k] - x[j], y[k] - y[j]
            if dx >= widest:
                break
            away = dx * dx + dy * dy
            if away < widest * widest and away < ((radii[k] + radii[j]) * _TOUCHING) ** 2:
                return False
    return True


def _move_well(scene: SceneContents) -> bool:
    """Whether balls aren't too fast for doubles, and come to rest unless `t_max` is given."""
    balls, physics = scene.balls, scene.physics
    fastest = max([math.hypot(*ball.velocity) for ball in balls])
    for ball in balls:
        if ball.angular_velocity is not None:
            if physics.motion == "rolling":
                return False
            fastest = max(fastest, ball.radius * math.hypot(*ball.angular_velocity))
    fastest *= _MARGIN
    drag = max(physics.air_drag, physics.rolling_friction_quadratic)
    falls = physics.airborne and physics.air_drag * physics.gravity > FASTEST_FALL
    if fastest > LARGEST or drag * fastest > FASTEST_DRAG or falls:
        return False
    return scene.t_max is not None or _come_to_rest(scene, fastest)


def _come_to_rest(scene: SceneContents, fastest: float) -> bool:
    """Whether balls no faster than that [m/s] rest before too long, however they collide."""
    balls, physics, table = scene.balls, scene.physics, scene.table
    if physics.airborne and physics.table_restitution == 1.0:
        return False
    rolls = _least(physics.rolling_friction, [ball.rolling_friction for ball in balls])
    if fastest > LARGEST * (rolls * physics.gravity):
        return False
    if physics.motion == "rolling":
        # Balls that hit four elastic cushions rest when rolling has taken all of their energy.
        masses = [ball.mass for ball in balls]
        energy, slowing = 0.5 * max(masses) * fastest**2, min(masses) * rolls * physics.gravity
        return table is None or energy <= MOST_IMPACTS * slowing * table.length
    slides = _least(physics.sliding_friction, [ball.sliding_friction for ball in balls])
    spins = _least(
        physics.spinning_friction_rate or LARGEST,  # whose spin nothing slows isn't waited for
        [ball.spinning_friction_rate or None for ball in balls],
    )
    least = min([ball.radius for ball in balls])
    return fastest <= LARGEST * min(slides * physics.gravity, least * spins)


def _least(shared: float, own: Sequence[float | None]) -> float:
    """Return the least of a number for all balls, and of the numbers that some have."""
    return min([shared, *[one for one in own if one is not None]])
