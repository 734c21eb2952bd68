"""The rules between the parts of a scene: each refuses what breaks it with one sentence.

What a single field may hold is declared with the field, in `scene`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from pydantic_core import PydanticCustomError

from engine._tolerances import position_rounding

if TYPE_CHECKING:
    from engine.scene import Scene

LARGEST = 1e50
"""Largest size of a number in a scene, and the longest run [SI units].

The engine multiplies distances by speeds and squares the product. A distance travelled is at most
a speed times a time, 1e100 m, so that square is at most 1e300: still a double. Beyond, sums become
infinite without a word.
"""

SMALLEST = 1.0 / LARGEST
"""Smallest size of what must be positive, since it divides: a spin is v / R, at most 1e100."""


def problem(kind: str, rule: str, **context: Any) -> PydanticCustomError:
    """Build the error that a validator raises; `rule` is a sentence with {placeholders}."""
    return PydanticCustomError(kind, "{sentence}", {"sentence": rule.format(**context)})


def check_scene(scene: Scene, rolling: NDArray[np.float64]) -> None:
    """Check a scene whose fields are each in order.

    Parameters
    ----------
    scene : Scene
    rolling : (n, 3) float64 [rad/s]
        Angular velocity with which each ball would roll without slip.

    Raises
    ------
    PydanticCustomError
        For the first rule that is broken.
    """
    _check_ids(scene)
    _check_on_cloth(scene)
    _check_resolved(scene)
    _check_inside(scene)
    _check_overlaps(scene)
    _check_rolling(scene, rolling)
    _check_ends(scene)


def _check_ids(scene: Scene) -> None:
    seen: dict[str, int] = {}
    for i, ball in enumerate(scene.balls):
        if ball.id in seen:
            raise problem(
                "duplicate_id",
                '`balls[{i}].id` must be unique, but `balls[{j}]` is called "{id}" too',
                i=i,
                j=seen[ball.id],
                id=ball.id,
            )
        seen[ball.id] = i


def _check_on_cloth(scene: Scene) -> None:
    if scene.physics.airborne:
        return
    for i, ball in enumerate(scene.balls):
        if ball.position[2] != ball.radius:
            raise problem(
                "off_cloth",
                "`balls[{i}].position` z must be the radius, {radius} m, got {z} m: the ball must "
                "lie on the cloth. Leave z out, or set `airborne` = true",
                i=i,
                radius=ball.radius,
                z=ball.position[2],
            )
        if ball.velocity[2] != 0.0:
            raise problem(
                "off_cloth",
                "`balls[{i}].velocity` z must be 0, got {z} m/s. Leave z out, or set "
                "`airborne` = true",
                i=i,
                z=ball.velocity[2],
            )


def _check_resolved(scene: Scene) -> None:
    # Else balls in one place would count as touching, and their collisions would be missed.
    for i, ball in enumerate(scene.balls):
        rounding = position_rounding(*ball.position[:2])
        if rounding >= ball.radius:
            raise problem(
                "unresolved",
                "`balls[{i}].position` must be known to better than the radius, {radius} m, but "
                "at ({x}, {y}) m double precision rounds by up to {rounding:.2g} m. Move the scene "
                "to the origin",
                i=i,
                radius=ball.radius,
                x=ball.position[0],
                y=ball.position[1],
                rounding=rounding,
            )


def _check_inside(scene: Scene) -> None:
    table = scene.table
    if table is None:
        return
    for i, ball in enumerate(scene.balls):
        x, y = ball.position[0], ball.position[1]
        gaps = {
            "left": x - ball.radius,
            "right": table.length - ball.radius - x,
            "bottom": y - ball.radius,
            "top": table.width - ball.radius - y,
        }
        permitted = position_rounding(x, y, table.length, table.width)
        for name in table.cushions:
            if gaps[name] < -permitted:
                raise problem(
                    "outside",
                    '`balls[{i}].position` must be inside the table: ball "{id}" at ({x}, {y}) m '
                    "reaches {depth:.6g} m beyond the {cushion} cushion. Its centre must be at "
                    "least its radius, {radius} m, from each cushion",
                    i=i,
                    id=ball.id,
                    x=x,
                    y=y,
                    depth=-gaps[name],
                    cushion=name,
                    radius=ball.radius,
                )


def _check_overlaps(scene: Scene) -> None:
    # Balls touch at a centre distance of the sum of their radii: in the plane for balls on the
    # cloth (see "Geometry" in engine/__init__.py), in space where they may fly.
    dimensions = 3 if scene.physics.airborne else 2
    centres = scene.positions[:, :dimensions]
    radii = scene.radii
    for i in range(1, len(scene.balls)):
        distance = np.sqrt(np.sum((centres[:i] - centres[i]) ** 2, axis=1))
        depth = radii[:i] + radii[i] - distance
        j = int(np.argmax(depth))
        permitted = position_rounding(*centres[i], *centres[j], radii[i], radii[j])
        if depth[j] > permitted:
            raise problem(
                "overlap",
                '`balls[{j}]` ("{a}") and `balls[{i}]` ("{b}") must not overlap, but do by '
                "{depth:.6g} m: their centres are {distance:.9g} m apart and their radii add up to "
                "{reach:.9g} m. Move one of them",
                i=i,
                j=j,
                a=scene.balls[j].id,
                b=scene.balls[i].id,
                depth=float(depth[j]),
                distance=float(distance[j]),
                reach=float(radii[i] + radii[j]),
            )


def _check_rolling(scene: Scene, rolling: NDArray[np.float64]) -> None:
    if scene.physics.motion != "rolling":
        return
    for i, ball in enumerate(scene.balls):
        spin = ball.angular_velocity
        if spin is None:
            continue
        scale = max(float(np.max(np.abs(rolling[i]))), *map(abs, spin))
        if not np.allclose(spin, rolling[i], rtol=0.0, atol=1e-9 * scale):
            raise problem(
                "not_rolling",
                "`balls[{i}].angular_velocity` must be that of rolling without slip, {rolling}, "
                'where `motion` = "rolling", got {spin}. Leave it out, or set `motion` = "sliding"',
                i=i,
                rolling=tuple(rolling[i].tolist()),
                spin=spin,
            )


def _check_ends(scene: Scene) -> None:
    if scene.t_max is not None:
        return
    # The product as the engine takes it: of two tiny factors it may round to 0.
    deceleration = scene.physics.rolling_friction * scene.physics.gravity
    for i, ball in enumerate(scene.balls):
        if ball.speed == 0.0:
            continue
        if deceleration == 0.0:
            raise problem(
                "endless",
                "`t_max` must be given where `rolling_friction` is 0 and a ball moves "
                "(`balls[{i}]`): it would never come to rest. Set `t_max` to a time in seconds",
                i=i,
            )
        if ball.speed > LARGEST * deceleration:
            raise problem(
                "endless",
                "`t_max` must be given where a ball (`balls[{i}]`) would roll for more than "
                "{longest:g} s: it has {speed:g} m/s and loses {deceleration:g} m/s each second. "
                "Set `t_max` to a time in seconds",
                i=i,
                longest=LARGEST,
                speed=ball.speed,
                deceleration=deceleration,
            )
