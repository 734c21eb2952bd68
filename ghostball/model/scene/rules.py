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
                f"`balls[{i}].id` must be unique, but `balls[{seen[ball.id]}]` is called "
                f'"{ball.id}" too',
                at=("balls", i, "id"),
            )
        seen[ball.id] = i


def _check_on_cloth(scene: SceneContents) -> None:
    if scene.physics.airborne:
        _check_above_cloth(scene)
        return
    for i, ball in enumerate(scene.balls):
        z, up = ball.position[2], ball.velocity[2]
        if z != ball.radius:
            raise problem(
                "off_cloth",
                f"`balls[{i}].position` z must be the radius, {ball.radius} m, got {z} m: the ball "
                "must lie on the cloth. Leave z out",
                at=("balls", i, "position"),
            )
        if up != 0.0:
            raise problem(
                "off_cloth",
                f"`balls[{i}].velocity` z must be 0, got {up} m/s: the ball must stay on the "
                "cloth. Leave z out",
                at=("balls", i, "velocity"),
            )


def _check_above_cloth(scene: SceneContents) -> None:
    for i, ball in enumerate(scene.balls):
        z, up = ball.position[2], ball.velocity[2]
        if z < ball.radius:
            raise problem(
                "below_cloth",
                f"`balls[{i}].position` z must be at least the radius, {ball.radius} m, got {z} m: "
                "the ball would be inside the table. Raise it, or leave z out",
                at=("balls", i, "position"),
            )
        if z == ball.radius and up < 0.0:
            raise problem(
                "below_cloth",
                f"`balls[{i}].velocity` z must be at least 0 of a ball that lies on the cloth, got "
                f"{up} m/s. Leave z out, or say how the ball comes up again",
                at=("balls", i, "velocity"),
            )


def _check_resolved(scene: SceneContents) -> None:
    # Else balls in one place would count as touching, and their collisions would be missed.
    for i, ball in enumerate(scene.balls):
        x, y = ball.position[:2]
        rounding = position_rounding(x, y)
        if rounding >= ball.radius:
            raise problem(
                "unresolved",
                f"`balls[{i}].position` must be known to better than the radius, {ball.radius} m, "
                f"but at ({x}, {y}) m double precision rounds by up to {rounding:.2g} m. Move the "
                "scene to the origin",
                at=("balls", i, "position"),
            )


def _check_inside(scene: SceneContents) -> None:
    table = scene.table
    if table is None:
        return
    for i, ball in enumerate(scene.balls):
        x, y = ball.position[0], ball.position[1]
        reach = _reach_of_nose(scene, ball)
        permitted = position_rounding(x, y, table.length, table.width)
        for side in table.sides:
            gap = side.distance(x, y) - reach
            if gap < -permitted:
                far = "its radius" if reach == ball.radius else "so far at this height"
                raise problem(
                    "outside",
                    f'`balls[{i}].position` must be inside the table: ball "{ball.id}" at '
                    f"({x}, {y}) m reaches {-gap:.6g} m beyond the {side.name} cushion. Its "
                    f"centre must be at least {far}, {reach} m, from each cushion",
                    at=("balls", i, "position"),
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
    for i, j, overlap in overlapping_pairs(centres, radii):
        if overlap > position_rounding(*centres[i], *centres[j], radii[i], radii[j]):
            one, other = scene.balls[j].id, scene.balls[i].id
            distance = np.sqrt(np.sum((centres[j] - centres[i]) ** 2))
            raise problem(
                "overlap",
                f'`balls[{j}]` ("{one}") and `balls[{i}]` ("{other}") must not overlap, but do by '
                f"{overlap:.6g} m: their centres are {distance:.9g} m apart and their radii add up "
                f"to {radii[i] + radii[j]:.9g} m. Move one of them",
                at=("balls", i, "position"),
            )


_MOST_OVERLAPS = 100_000
"""Overlaps after which no others are sought: thousands of balls at one place have millions."""


def overlapping_pairs(
    centres: NDArray[np.float64], radii: NDArray[np.float64]
) -> list[tuple[int, int, float]]:
    """Return the pairs i > j that overlap, and by how much [m]: in order of i, the largest first.

    Not all of them where there are hundreds of thousands.

    Balls are sorted along x, so that each is compared with those that follow within reach, and no
    others: the first with the next, with the one after that ..., all at once.
    """
    order = np.argsort(centres[:, 0], kind="stable")
    sorted_centres, sorted_radii = centres[order], radii[order]
    reach = 2.0 * float(np.max(radii, initial=0.0))
    found: list[tuple[int, int, float]] = []
    for lag in range(1, len(order)):
        between = sorted_centres[lag:] - sorted_centres[:-lag]
        if np.min(between[:, 0]) > reach:
            break
        overlap = sorted_radii[lag:] + sorted_radii[:-lag] - np.sqrt(np.sum(between**2, axis=1))
        for k in np.flatnonzero(overlap > 0.0):
            i, j = int(order[k]), int(order[k + lag])
            found.append((max(i, j), min(i, j), float(overlap[k])))
        if len(found) > _MOST_OVERLAPS:
            break
    return sorted(found, key=lambda pair: (pair[0], -pair[2], pair[1]))
