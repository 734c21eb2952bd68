"""The rules between the fields of a scene: each refuses what breaks it with one sentence.

What a single field may hold is in `scene.fields`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ghostball.model.rounding import position_rounding
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.fields import problem
from ghostball.model.scene.law_rules import check_laws_in_scene
from ghostball.model.scene.motion_rules import check_motions, motions_of
from ghostball.model.scene.parts import Ball


def check_scene(scene: SceneContents) -> None:
    """Check a scene whose fields are each in order.

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
    check_laws_in_scene(scene)
    check_motions(scene, motions_of(scene))


def _check_ids(scene: SceneContents) -> None:
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


def _check_on_cloth(scene: SceneContents) -> None:
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


def _check_above_cloth(scene: SceneContents) -> None:
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


def _check_resolved(scene: SceneContents) -> None:
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


def _check_inside(scene: SceneContents) -> None:
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


def _reach_of_nose(scene: SceneContents, ball: Ball) -> float:
    """Return how near a ball's centre may be to a cushion, in plan [m]."""
    if not scene.physics.airborne:
        return ball.radius
    above = ball.position[2] - scene.physics.cushion_height
    return float(np.sqrt(max(ball.radius**2 - above**2, 0.0)))


def _check_overlaps(scene: SceneContents) -> None:
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
