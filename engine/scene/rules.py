"""The rules between the fields of a scene: each refuses what breaks it with one sentence.

What a single field may hold is in `scene.fields`. The rules of how balls begin to move are asked
about many motions at once: those of a scene's balls, or those of one ball in the shots of a sweep.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.engine.core.tolerances import position_rounding
from ghostball.engine.scene.end_rules import check_drag, check_ends, size
from ghostball.engine.scene.fields import LARGEST, problem
from ghostball.engine.scene.law_rules import check_laws_in_scene

if TYPE_CHECKING:
    from ghostball.engine.scene.model import Scene
    from ghostball.engine.scene.parts import Ball


class Motions(NamedTuple):
    """First motions: of each of a scene's balls, or of one of them in each shot of a sweep."""

    ball: NDArray[np.int64]  # (m,) whose it is: index in the scene
    velocity: NDArray[np.float64]  # (m, 3) [m/s]
    spin: NDArray[np.float64]  # (m, 3) angular velocity [rad/s]
    rolling: NDArray[np.float64]  # (m, 3) what that of rolling without slip would be [rad/s]
    given: NDArray[np.bool_]  # (m,) whether the spin is given; else it is that of rolling
    in_sweep: bool = False

    def name(self, k: int, field: str = "") -> str:
        """Return how a message calls the ball of motion k, or a field of it."""
        return f"`balls[{self.ball[k]}]{field}`" + f" in shot {k}" * self.in_sweep


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
    given = np.array([ball.angular_velocity is not None for ball in scene.balls])
    each = np.arange(len(scene.balls))
    motions = Motions(each, scene.velocities, scene.angular_velocities, rolling, given)
    _check_rolling(scene, motions)
    _check_spin(scene, motions)
    check_laws_in_scene(scene)
    check_drag(scene, motions)
    check_ends(scene, motions)


def check_motions(scene: Scene, motions: Motions) -> None:
    """Check motions that balls of a scene, which is in order itself, would begin with instead.

    Raises
    ------
    PydanticCustomError
        For the first rule that a scene with one of these motions would break.
    """
    _check_rolling(scene, motions)
    _check_spin(scene, motions)
    check_drag(scene, motions)
    check_ends(scene, motions)


def _check_ids(scene: Scene) -> None:
    seen: dict[str, int] = {}
    for i, ball in enumerate(scene.balls):
        if ball.id in seen:
            raise problem(
                "duplicate_id",
                '`balls[{i}].id` must be unique, but `balls[{j}]` is called "{id}" too',
                at=("balls", i, "id"),
                i=i,
                j=seen[ball.id],
                id=ball.id,
            )
        seen[ball.id] = i


def _check_on_cloth(scene: Scene) -> None:
    if scene.physics.airborne:
        _check_above_cloth(scene)
        return
    for i, ball in enumerate(scene.balls):
        if ball.position[2] != ball.radius:
            raise problem(
                "off_cloth",
                "`balls[{i}].position` z must be the radius, {radius} m, got {z} m: the ball must "
                "lie on the cloth. Leave z out",
                at=("balls", i, "position"),
                i=i,
                radius=ball.radius,
                z=ball.position[2],
            )
        if ball.velocity[2] != 0.0:
            raise problem(
                "off_cloth",
                "`balls[{i}].velocity` z must be 0, got {z} m/s: the ball must stay on the cloth. "
                "Leave z out",
                at=("balls", i, "velocity"),
                i=i,
                z=ball.velocity[2],
            )


def _check_above_cloth(scene: Scene) -> None:
    for i, ball in enumerate(scene.balls):
        if ball.position[2] < ball.radius:
            raise problem(
                "below_cloth",
                "`balls[{i}].position` z must be at least the radius, {radius} m, got {z} m: the "
                "ball would be inside the table. Raise it, or leave z out",
                at=("balls", i, "position"),
                i=i,
                radius=ball.radius,
                z=ball.position[2],
            )
        if ball.position[2] == ball.radius and ball.velocity[2] < 0.0:
            raise problem(
                "below_cloth",
                "`balls[{i}].velocity` z must be at least 0 of a ball that lies on the cloth, got "
                "{z} m/s. Leave z out, or say how the ball comes up again",
                at=("balls", i, "velocity"),
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
                at=("balls", i, "position"),
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
        reach = _reach_of_nose(scene, ball)
        gaps = {
            "left": x - reach,
            "right": table.length - reach - x,
            "bottom": y - reach,
            "top": table.width - reach - y,
        }
        permitted = position_rounding(x, y, table.length, table.width)
        for name in table.cushions:
            if gaps[name] < -permitted:
                raise problem(
                    "outside",
                    '`balls[{i}].position` must be inside the table: ball "{id}" at ({x}, {y}) m '
                    "reaches {depth:.6g} m beyond the {cushion} cushion. Its centre must be at "
                    "least {reach}, {radius} m, from each cushion",
                    at=("balls", i, "position"),
                    i=i,
                    id=ball.id,
                    x=x,
                    y=y,
                    depth=-gaps[name],
                    cushion=name,
                    reach="its radius" if reach == ball.radius else "so far at this height",
                    radius=reach,
                )


def _reach_of_nose(scene: Scene, ball: Ball) -> float:
    """Return how near a ball's centre may be to a cushion, in plan [m]."""
    if not scene.physics.airborne:
        return ball.radius
    above = ball.position[2] - scene.physics.cushion_height
    return float(np.sqrt(max(ball.radius**2 - above**2, 0.0)))


def _check_overlaps(scene: Scene) -> None:
    # Balls touch at a centre distance of the sum of their radii: in the plane for balls on the
    # cloth (see "Geometry" in engine/__init__.py), in space where they may fly.
    dimensions = 3 if scene.physics.airborne else 2
    centres = scene.positions[:, :dimensions]
    radii = scene.radii
    for i, j, depth in overlapping_pairs(centres, radii):
        if depth > position_rounding(*centres[i], *centres[j], radii[i], radii[j]):
            raise problem(
                "overlap",
                '`balls[{j}]` ("{a}") and `balls[{i}]` ("{b}") must not overlap, but do by '
                "{depth:.6g} m: their centres are {distance:.9g} m apart and their radii add up to "
                "{reach:.9g} m. Move one of them",
                at=("balls", i, "position"),
                i=i,
                j=j,
                a=scene.balls[j].id,
                b=scene.balls[i].id,
                depth=depth,
                distance=float(np.sqrt(np.sum((centres[j] - centres[i]) ** 2))),
                reach=float(radii[i] + radii[j]),
            )


_MOST_OVERLAPS = 100_000
"""Overlaps after which no others are sought: thousands of balls at one place have millions."""


def overlapping_pairs(
    centres: NDArray[np.float64], radii: NDArray[np.float64]
) -> list[tuple[int, int, float]]:
    """Return the pairs i > j that overlap, and by how much [m]: in order of i, the deepest first.

    Not all of them where there are hundreds of thousands.

    Balls are sorted along x, so that each is compared with those that follow within reach, and no
    others: the first with the next, with the one after that ..., all at once.
    """
    order = np.argsort(centres[:, 0], kind="stable")
    sorted_centres, sorted_radii = centres[order], radii[order]
    reach = 2.0 * float(np.max(radii, initial=0.0))
    found: list[tuple[int, int, float]] = []
    for lag in range(1, len(order)):
        apart = sorted_centres[lag:] - sorted_centres[:-lag]
        if np.min(apart[:, 0]) > reach:
            break
        depth = sorted_radii[lag:] + sorted_radii[:-lag] - np.sqrt(np.sum(apart**2, axis=1))
        for k in np.flatnonzero(depth > 0.0):
            i, j = int(order[k]), int(order[k + lag])
            found.append((max(i, j), min(i, j), float(depth[k])))
        if len(found) > _MOST_OVERLAPS:
            break
    return sorted(found, key=lambda pair: (pair[0], -pair[2], pair[1]))


def _check_rolling(scene: Scene, motions: Motions) -> None:
    if scene.physics.motion != "rolling":
        return
    spin, rolling = motions.spin, motions.rolling
    scale = np.max(np.abs(np.hstack((rolling, spin))), axis=1, keepdims=True)
    for k in np.flatnonzero(np.any(np.abs(spin - rolling) > 1e-9 * scale, axis=1))[:1]:
        raise problem(
            "not_rolling",
            "{name} must be that of rolling without slip, {rolling}, "
            'where `motion` = "rolling", got {spin}. Leave it out, or set `motion` = "sliding"',
            at=("balls", int(motions.ball[k]), "angular_velocity"),
            name=motions.name(k, ".angular_velocity"),
            rolling=tuple(rolling[k].tolist()),
            spin=tuple(spin[k].tolist()),
        )


def _check_spin(scene: Scene, motions: Motions) -> None:
    surface = np.where(motions.given, scene.radii[motions.ball] * size(motions.spin), 0.0)
    for k in np.flatnonzero(surface > LARGEST)[:1]:
        raise problem(
            "fast_spin",
            "{name} must turn the ball's surface at no more than "
            "{largest:g} m/s, got {spin} rad/s, which make {surface:g} m/s",
            at=("balls", int(motions.ball[k]), "angular_velocity"),
            name=motions.name(k, ".angular_velocity"),
            largest=LARGEST,
            spin=tuple(motions.spin[k].tolist()),
            surface=float(surface[k]),
        )
