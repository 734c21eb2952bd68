"""Jaws, holes, posts and sharp corners: obstacles on tables that aren't rectangles."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.stress.grazing import PATH, SHALLOWEST, SPEED, grazes
from ghostball.validation.stress.shots import (
    StressFamily,
    StressShot,
    StressSize,
    limit,
    scene_of,
    shot,
)

_RADIUS = Ball(id="any", position=(0.0, 0.0)).radius
_FREE = Physics(rolling_friction=0.0, cushion="mirror")
_POOL = Table.model_validate("wpa-9ft")
_CORNER = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0))
"""An L, with a corner at (1, 1) that points into the table."""

_POST = 0.04
"""Radius of the post in grazing shots [m]."""


def passing(depth: float, turn: float, *, post: bool) -> Scene:
    """Return a straight shot past a post, or a corner, with an overlap of `depth` diameters.

    The line is rotated by an angle [rad] from the diagonal.
    """
    way = math.radians(-45.0) + turn
    c, s = math.cos(way), math.sin(way)
    aside = _RADIUS - 2.0 * _RADIUS * depth + (_POST if post else 0.0)
    # The obstacle is at (1, 1), on the right of the path.
    x, y = 1.0 + s * aside - c * PATH, 1.0 - c * aside - s * PATH
    table = {"length": 2.0, "width": 2.0, "posts": [{"centre": (1.0, 1.0), "radius": _POST}]}
    shape = Table.model_validate(table if post else {"vertices": _CORNER})
    cue = Ball(id="cue", position=(x, y), velocity=(SPEED * c, SPEED * s))
    return scene_of(cue, physics=_FREE, t_max=2.0 * PATH / SPEED, table=shape)


def wedge(angle: float) -> tuple[Scene, int]:
    """Return a ball that rolls into a corner and back, and the number of its bounces there.

    `angle` [rad]: of the corner.

    The lines that its centre bounces off meet at R / sin(angle / 2) from the corner. Unfolded
    there, its path is a straight line. It crosses a line at every multiple of `angle` between the
    directions to its start and to its end.
    """
    reach, back = _RADIUS / math.sin(angle / 2.0), 1.0
    length = reach + 3.0 * back
    height = length * math.tan(angle / 2.0)
    off = 0.1 * angle
    vertices = ((0.0, height), (length, 0.0), (length, 2.0 * height))
    table = Table.model_validate({"vertices": vertices})
    velocity = (-SPEED * math.cos(off), -SPEED * math.sin(off))
    cue = Ball(id="cue", position=(reach + back, height), velocity=velocity)
    scene = scene_of(cue, physics=_FREE, t_max=2.0 * back / SPEED, table=table)
    start, end = 0.5 * angle, math.pi + 0.5 * angle + off
    return scene, math.floor(end / angle) - math.floor(start / angle)


def _on_pool(*balls: dict[str, Any], **fields: Any) -> Scene:
    """Return a shot on a pool table of 9 ft without friction."""
    data = [{"id": f"b{i}", **ball} for i, ball in enumerate(balls)]
    return Scene.model_validate(
        {"name": "pool", "table": _POOL, "physics": _FREE, "t_max": 2.0, "balls": data, **fields}
    )


def _falls(count: int) -> Criterion:
    return limit(
        "pocketed_count", "This is the number of balls beyond the edge of a hole.", equals=count
    )


def _bounces(count: int) -> Criterion:
    why = "Unfolded, the path is a straight line that crosses this number of side images."
    return limit("ball_cushion_count", why, equals=count)


def _grazes(size: StressSize) -> Iterator[StressShot]:
    powers = range(1, SHALLOWEST + 1, 1 if size.full else 4)
    turns = (0.0, 0.1, -0.3, 0.5) if size.full else (0.0, 0.1)
    for kind in ("post", "corner"):
        make = partial(passing, post=kind == "post")
        yield from grazes(kind, make, powers, turns, "ball_cushion_count")


def _at_holes() -> Iterator[StressShot]:
    """Yield balls at the edge of a hole, balls frozen between jaws, and two that fall together."""
    (hole,) = (one for one in _POOL.holes if one.pocket == 1)  # of the bottom side
    x, edge = hole.centre[0], hole.centre[1] + hole.radius
    for power in (3, 6, 9, 12):
        place = (x, edge + 10.0**-power)
        yield shot(f"hanging-1e-{power:02d}", _on_pool({"position": place}), _falls(0))
        pushed = {"position": place, "velocity": (0.0, -1e-3 - 10.0**-power)}
        yield shot(f"falling-1e-{power:02d}", _on_pool(pushed), _falls(1))
    pair = [
        {"position": (x + side * 0.03, edge + 0.2), "velocity": (0.0, -1.0)} for side in (-1.0, 1.0)
    ]
    yield shot("two-at-once", _on_pool(*pair), _falls(2))
    # A ball too large for the mouth touches both jaws. A ball that hits it bounces back.
    large, jaws = 0.1, [one for one in _POOL.obstacles if getattr(one, "inward", None)]
    jaw = min(
        (one for one in jaws if one not in _POOL.holes),
        key=lambda one: math.dist(one.centre, hole.centre),  # type: ignore[union-attr]
    )
    across = x - jaw.centre[0]  # type: ignore[union-attr]
    up = math.sqrt((large + jaw.radius) ** 2 - across**2)  # type: ignore[union-attr]
    frozen = {"position": (x, jaw.centre[1] + up), "radius": large}  # type: ignore[union-attr]
    still = limit("ball_cushion_count", "No ball moves.", equals=0)
    yield shot("frozen-in-the-jaws", _on_pool(frozen), still)
    for speed in (0.01, 1.0, 5.0):
        cue = {"position": (x, 0.635), "velocity": (0.0, -speed)}
        # Ends before the ball comes back to the opposite pocket.
        scene = _on_pool(frozen, cue, t_max=0.9 / speed)
        yield shot(f"into-the-jaws-{speed:g}", scene, _falls(0), stepped=True)


def _rattles(size: StressSize) -> Iterator[StressShot]:
    """Yield balls that rattle between the jaws of a corner pocket; certified."""
    most = 59 if size.full else 5
    for k in range(most + 1):
        y = 1.185 + 0.02 * k / most
        ball = {"position": (1.9, y), "velocity": (2.0, 0.04)}
        scene = _on_pool(ball, physics=Physics(preset="pool"), t_max=None)
        yield shot(f"rattle-{y:.5f}", scene)


def _corners(size: StressSize) -> Iterator[StressShot]:
    """Yield corners with smaller and smaller angles, until the sides are nearly parallel."""
    for degrees in (90.5, 31.0, 7.0, 1.0, 0.3, 0.1, 0.03) if size.full else (90.5, 31.0, 7.0, 1.0):
        scene, count = wedge(math.radians(degrees))
        yield shot(f"needle-{degrees:g}", scene, _bounces(count), angle=degrees)


def _shots(size: StressSize) -> Iterator[StressShot]:
    yield from _grazes(size)
    yield from _at_holes()
    yield from _rattles(size)
    yield from _corners(size)


FAMILY = StressFamily(
    "pockets",
    "Jaws, holes and sharp corners",
    "A path that goes 1e-1 to 1e-13 of a diameter into a post or a corner hits it once. A ball "
    "that hangs at the edge of a hole stays, and falls if it is pushed. A ball too large for a "
    "mouth never falls. A ball that rattles between jaws follows its certified motion. A ball "
    "leaves a corner of 90 to 0.03 degrees after as many bounces as its unfolded path, a straight "
    "line, crosses images of the sides.",
    _shots,
)
