"""Extremes: ordinary shots with one extreme number.

Each shot has a closed form, or is certified for its exact doubles. Large numbers affect the
conditioning of a shot: far from the origin, coordinates have larger rounding errors. A right answer
therefore is within some roundings of the coordinates, propagated along the shot. Ghostball's engine
may have 32 times the error of one rounding at each event, as in all scenes
(scenes/common.expect.toml).

Numbers above 1e50, and positive quantities below 1e-50, are refused, with the field and the rule;
so is a ball so far from the origin that doubles don't resolve its radius.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ghostball.model import (
    POOL_BALL_MASS as MASS,
    POOL_BALL_RADIUS as RADIUS,
    Ball,
    Physics,
    Scene,
    Table,
)
from ghostball.validation.stress.shots import (
    StressFamily,
    StressShot,
    StressSize,
    power_of_ten,
    scene_of,
    shot,
)

PATH = 0.0625
"""Distance of the cue ball from the other ball [m]."""

SPEED, T_MAX = 2.0, 0.15
"""Speed of a cue ball [m/s] and end of a shot [s], in shots with other extremes."""

TABLE_SIDE = 0.4
"""Side of a square table [m], in shots with other extremes."""

ROLLING, ELASTIC, SLIDING = "rolling", "elastic", "sliding"
KINDS: dict[str, dict[str, Any]] = {
    ROLLING: {},
    ELASTIC: {"rolling_friction": 0.0},
    SLIDING: {
        "motion": "sliding",
        "rolling_friction": 0.01,
        "ball_restitution": 0.95,
        "ball_friction": 0.05,
        "cushion": "han2005",
        "cushion_restitution": 0.85,
    },
}
"""The balls of the paper, the same without friction, and pool balls."""

ICE = Physics(rolling_friction=0.0)


def cut(
    physics: Physics,
    *,
    speed: float = SPEED,
    ratio: float = 1.0,
    mass_ratio: float = 1.0,
    at: tuple[float, float] = (0.0, 0.0),
    t_max: float = T_MAX,
) -> Scene:
    """Return a shot at a ball at rest, 0.4 of a full offset from its centre.

    The object ball is at `at`, with `ratio` times the radius and `mass_ratio` times the mass.
    """
    reach = (1.0 + ratio) * RADIUS
    aside = 0.4 * reach
    spin = (0.0, 0.0, 2.0 * speed) if physics.motion == "sliding" else None
    start = at[0] - math.sqrt(reach**2 - aside**2) - PATH, at[1] + aside
    cue = Ball(id="cue", position=start, velocity=(speed, 0.0), angular_velocity=spin)
    rests = Ball(id="object", position=at, radius=ratio * RADIUS, mass=mass_ratio * MASS)
    return scene_of(cue, rests, physics=physics, t_max=t_max)


def bank(
    physics: Physics,
    *,
    side: float = TABLE_SIDE,
    radius: float = RADIUS,
    speed: float = SPEED,
    t_max: float | None = 0.5,
) -> Scene:
    """Return two balls on a square table; one moves towards the other, and both reach cushions."""
    start, velocity = (0.25 * side, 0.25 * side), (speed, 0.6 * speed)
    cue = Ball(id="cue", position=start, velocity=velocity, radius=radius)
    rests = Ball(id="object", position=(0.5 * side, 0.4 * side - 0.5 * radius), radius=radius)
    return scene_of(cue, rests, physics=physics, t_max=t_max, table=Table(length=side, width=side))


def _spread(size: StressSize, values: range) -> tuple[int, ...]:
    """Return all values, or the first and the last one for the small size."""
    return tuple(values) if size.full else (values[0], values[-1])


def _speeds(size: StressSize) -> Iterator[StressShot]:
    # Without friction, a ball arrives at any speed; with friction, it may stop before.
    for power in _spread(size, range(-9, 5)):
        speed = 10.0**power
        for kind, fields in KINDS.items():
            scene = cut(Physics(**fields), speed=speed, t_max=5.0 * PATH / speed)
            yield shot(f"speed-{kind}-{power_of_ten(power)}", scene, speed=speed)
        scene = bank(ICE, speed=speed, t_max=4.0 * TABLE_SIDE / speed)
        yield shot(f"speed-bounces-{power_of_ten(power)}", scene, speed=speed)


def _differences(size: StressSize) -> Iterator[StressShot]:
    """Yield a ball that catches up with another one at almost the same speed."""
    for power in _spread(size, range(-11, 0)):
        slower = 10.0**power
        closes = slower * SPEED * 0.5 * T_MAX
        for kind, fields in KINDS.items():
            behind = Ball(id="behind", position=(0.0, 0.0), velocity=(SPEED, 0.0))
            start, velocity = (2.0 * RADIUS + closes, 0.0), (SPEED * (1.0 - slower), 0.0)
            ahead = Ball(id="ahead", position=start, velocity=velocity)
            scene = scene_of(behind, ahead, physics=Physics(**fields), t_max=T_MAX)
            name = f"speed-difference-{kind}-{power_of_ten(power)}"
            yield shot(name, scene, speed_difference=slower)


def _ratios(size: StressSize) -> Iterator[StressShot]:
    for power in _spread(size, range(-6, 7)):
        for kind, fields in KINDS.items():
            physics = Physics(**fields)
            ratio, tag = 10.0**power, f"{kind}-{power_of_ten(power)}"
            scene = cut(physics, ratio=ratio)
            yield shot(f"radius-ratio-{tag}", scene, radius_ratio=ratio)
            scene = cut(physics, mass_ratio=ratio)
            yield shot(f"mass-ratio-{tag}", scene, mass_ratio=ratio)


def _among_many(size: StressSize) -> Iterator[StressShot]:
    """Yield two large balls that collide in front of a hundred small ones.

    Two small balls collide a little later. An engine with a grid needs cells for the largest ball;
    otherwise it finds the first contact after the second, too late. Two more balls are at places
    where the first large ball would hit them, except that the other large ball stops it: an engine
    that skips pairs with later collisions must take the size of balls into account.
    """
    for ratio in (40.0, 400.0) if size.full else (40.0,):
        small = 0.25 / ratio
        step = 3.0 * small
        rest = [
            Ball(id=f"b{k}", position=(-0.5 - step * (k % 10), step * (k // 10)), radius=small)
            for k in range(99)
        ]
        others = [
            Ball(id="object", position=(0.7, 0.0), radius=0.25),
            Ball(id="late", position=(-0.5, -0.4), velocity=(0.1, 0.0), radius=small),
            Ball(id="hit", position=(-0.465 + 2.0 * small, -0.4), radius=small),
            Ball(id="beyond", position=(0.53, -0.2), radius=small),
            Ball(id="behind", position=(0.55, -0.215), radius=small),
        ]
        cue = Ball(id="cue", position=(0.0, -0.1), velocity=(SPEED, 0.0), radius=0.25)
        scene = scene_of(*others, *rest, cue, physics=ICE, t_max=0.5)
        yield shot(f"among-many-{ratio:g}", scene)


def _tables(size: StressSize) -> Iterator[StressShot]:
    rough = Physics(rolling_friction=0.5)
    for power in _spread(size, range(-3, 7)):
        side = 10.0**power
        # Without cushions, the ball would roll more than five sides before it stops.
        speed = math.sqrt(8.0 * rough.rolling_friction * rough.gravity * side)
        scene = bank(rough, side=side, radius=side / 40.0, speed=speed, t_max=None)
        yield shot(f"table-rolling-{power_of_ten(power)}", scene, table=side)
        scene = bank(ICE, side=side, radius=side / 40.0, speed=4.0 * side, t_max=1.0)
        yield shot(f"table-elastic-{power_of_ten(power)}", scene, table=side)
        if side >= 1.0:
            scene = bank(ICE, side=side, speed=4.0 * side, t_max=1.0)
            yield shot(f"table-pool-ball-{power_of_ten(power)}", scene, table=side)


def _moved(size: StressSize) -> Iterator[StressShot]:
    for power in range(7) if size.full else (6,):
        away = 10.0**power
        for kind, fields in KINDS.items():
            for sign, word in ((1.0, "there"), (-1.0, "back")):
                scene = cut(Physics(**fields), at=(sign * away, -0.7 * sign * away))
                if size.full or sign > 0.0:
                    name = f"moved-{word}-{kind}-{power_of_ten(power)}"
                    yield shot(name, scene, distance=away)
        yield shot(f"far-end-{power_of_ten(power)}", _far_end(away), distance=away)


def _far_end(away: float) -> Scene:
    """Return two balls at the far corner of a table with sides this long."""
    table = Table(length=away + 1.0, width=away + 1.0, cushions=("right", "top"))
    cue = Ball(id="cue", position=(away + 0.3, away + 0.2), velocity=(1.0, 0.7))
    other = Ball(id="object", position=(away + 0.7, away + 0.45), velocity=(-0.2, 0.1))
    return scene_of(cue, other, physics=ICE, t_max=0.7, table=table)


def _frictions(size: StressSize) -> Iterator[StressShot]:
    pool = KINDS[SLIDING]
    for friction in (0.0, 1e-6, 1e-3, 0.1, 1.0, 3.0, 10.0) if size.full else (10.0,):
        scene = cut(Physics(rolling_friction=friction), speed=8.0)
        yield shot(f"friction-rolling-{friction:g}", scene, friction=friction)
        for what in ("rolling", "sliding", "ball", "cushion"):
            scene = bank(Physics(**(pool | {f"{what}_friction": friction})))
            yield shot(f"friction-pool-{what}-{friction:g}", scene, friction=friction)
        physics = Physics(**(pool | {"cushion": "frictional", "cushion_friction": friction}))
        scene = bank(physics)
        yield shot(f"friction-flat-cushion-{friction:g}", scene, friction=friction)


def _restitutions(size: StressSize) -> Iterator[StressShot]:
    for restitution in (0.0, 1e-12, 0.5, 1.0 - 1e-12, 1.0) if size.full else (0.0,):
        for kind, fields in KINDS.items():
            scene = cut(Physics(**(fields | {"ball_restitution": restitution})))
            name = f"restitution-balls-{kind}-{restitution:.13g}"
            yield shot(name, scene, restitution=restitution)
            laws: dict[str, Any] = {"cushion_restitution": restitution}
            if kind != SLIDING:
                laws["cushion"] = "restitution"
            scene = bank(Physics(**(fields | laws)))
            # A ball stays at a cushion without restitution if its spin drives it on: this can't be
            # certified.
            least = 5 if kind == SLIDING and restitution <= 1e-12 else None
            name = f"restitution-cushions-{kind}-{restitution:.13g}"
            yield shot(name, scene, proved=least, restitution=restitution)


def _tiny(size: StressSize) -> Iterator[StressShot]:
    """Yield tiny speeds, some with squares that underflow, and speeds at the limits."""
    values = (5e-324, 1e-310, 3e-308, 1e-200, 1e-160, 1e-100, 1e-50)
    for speed in values if size.full else values[:1]:
        for kind, fields in KINDS.items():
            scene = cut(Physics(**fields), speed=speed)
            yield shot(f"tiny-{kind}-{speed:g}", scene, speed=speed)
    for power in (-49, -30, 20, 49) if size.full else (-49, 49):
        scene = cut(ICE, speed=10.0**power, t_max=5.0 * PATH / 10.0**power)
        yield shot(f"limit-elastic-{power_of_ten(power)}", scene, speed=10.0**power)


def _shots(size: StressSize) -> Iterator[StressShot]:
    parts = (
        *(_speeds, _differences, _ratios, _among_many),
        *(_tables, _moved, _frictions, _restitutions, _tiny),
    )
    for part in parts:
        yield from part(size)


FAMILY = StressFamily(
    "extremes",
    "Extremes of speed, size, mass, position and friction",
    "Shots with one extreme number (speeds 5e-324 to 1e49 m/s, two speeds that differ by 1e-11, "
    "ratios of radii and masses to 1e6, tables from 1 mm to 1e6 m, 1e6 m from the origin, friction "
    "0 to 10, restitution 0 and 1) have the certified result, within some roundings, or, for "
    "time-stepping engines, within the limits of the step.",
    _shots,
)
