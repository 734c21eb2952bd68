"""The rules between the fields of a scene: each refuses what breaks it with one sentence.

What a single field may hold is in `scene.fields`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ghostball.model.arrays import BoolArray, FloatArray, IntArray
from ghostball.model.rounding import (
    FLIGHT_CONTACT_TOLERANCE,
    permitted_overlap,
    position_rounding,
)
from ghostball.model.scene.contents import SceneContents
from ghostball.model.scene.fields import problem
from ghostball.model.scene.law_rules import check_laws_in_scene
from ghostball.model.scene.motion_rules import check_motions
from ghostball.model.scene.obstacles import (
    POCKETS,
    Disc,
    Hole,
    Segment,
    gap_to,
    is_inside,
    obstacle_name,
)
from ghostball.model.scene.plain import begins_plainly
from ghostball.model.scene.starts import Starts, starts_of
from ghostball.model.scene.table import Table


def check_scene(scene: SceneContents) -> None:
    """Check a scene whose fields are each in order.

    Raises `PydanticCustomError` for the first rule that is broken.
    """
    if begins_plainly(scene):
        check_laws_in_scene(scene)
    else:
        check_each_rule(scene)


def check_each_rule(scene: SceneContents) -> None:
    """Check the same by all rules, in order.

    Raises `PydanticCustomError` for the first rule that is broken.
    """
    starts = starts_of(scene)
    _check_ids(scene)
    check_places(scene, starts)
    check_laws_in_scene(scene)
    check_motions(scene, starts)


def check_places(scene: SceneContents, starts: Starts) -> None:
    """Check where balls begin: all of a scene, in one shot or in many, one after the other.

    Raises `PydanticCustomError` for the first rule that is broken.
    """
    _check_height(scene, starts)
    _check_resolved(starts)
    _check_inside(scene, starts)
    _check_obstacles(scene, starts)
    _check_overlaps(scene, starts)


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


def _check_height(scene: SceneContents, starts: Starts) -> None:
    heights, up = starts.position[:, 2], starts.velocity[:, 2]
    radii, flies = starts.radius, scene.physics.airborne
    wrong = heights < radii if flies else heights != radii
    wrong_speed = (heights == radii) & (up < 0.0) if flies else up != 0.0
    k = _first(wrong | wrong_speed)
    if k is None:
        return
    z, speed, radius = float(heights[k]), float(up[k]), float(radii[k])
    if wrong[k]:
        rule = (
            f"must be at least the radius, {radius} m, got {z} m: the ball would be "
            f"{radius - z:.6g} m inside the table. Raise it, or remove z"
            if flies
            else f"must be the radius, {radius} m, got {z} m: the ball must lie on the cloth. "
            "Leave z out"
        )
    else:
        rule = (
            f"must be at least 0 of a ball that lies on the cloth, got {speed} m/s. Leave z out, "
            "or say how the ball comes up again"
            if flies
            else f"must be 0, got {speed} m/s: the ball must stay on the cloth. Leave z out"
        )
    field = "position" if wrong[k] else "velocity"
    raise problem(
        "below_cloth" if flies else "off_cloth",
        f"{starts.name(k, '.' + field)} z {rule}",
        at=("balls", int(starts.ball[k]), field),
    )


def _first(wrong: BoolArray) -> int | None:
    """Return the first element of (m,) that is true, or None."""
    found = np.flatnonzero(wrong)
    return int(found[0]) if len(found) else None


def _check_resolved(starts: Starts) -> None:
    # Else balls in one place would count as touching, and their collisions would be missed.
    rounding = position_rounding(starts.position[:, 0], starts.position[:, 1])
    radii = starts.radius
    k = _first(rounding >= radii)
    if k is not None:
        x, y = starts.position[k, :2].tolist()
        raise problem(
            "unresolved",
            f"{starts.name(k, '.position')} must be known to better than the radius, {radii[k]} "
            f"m, but at ({x}, {y}) m double precision rounds by up to {rounding[k]:.2g} m. Move "
            "the scene to the origin",
            at=("balls", int(starts.ball[k]), "position"),
        )


def _check_inside(scene: SceneContents, starts: Starts) -> None:
    table = scene.table
    if table is None:
        return
    x, y, radii = starts.position[:, 0], starts.position[:, 1], starts.radius
    reach = _reach_of_nose(scene, starts)
    permitted = _permitted_beyond(table, x, y, radii)
    gaps = np.array([side.distance(x, y) - reach for side in table.sides]).reshape(-1, len(x))
    beyond = gaps < -permitted
    k = _first(np.any(beyond, axis=0))
    if k is not None:
        side = int(np.argmax(beyond[:, k]))
        far = "its radius" if reach[k] == radii[k] else "so far at this height"
        raise problem(
            "outside",
            f"{starts.name(k, '.position')} must be inside the table: ball "
            f'"{scene.balls[starts.ball[k]].id}" at ({float(x[k])}, {float(y[k])}) m reaches '
            f"{-gaps[side, k]:.6g} m beyond the {table.sides[side].name} cushion. Its centre must "
            f"be at least {far}, {float(reach[k])} m, from each cushion",
            at=("balls", int(starts.ball[k]), "position"),
        )


def _check_obstacles(scene: SceneContents, starts: Starts) -> None:
    """Check that balls begin inside a table that isn't a plain rectangle, and off what is on it."""
    table = scene.table
    if table is None or not table.obstacles:
        return
    x, y, radii = starts.position[:, 0], starts.position[:, 1], starts.radius
    to_nose = _reach_of_nose(scene, starts)
    permitted = _permitted_beyond(table, x, y, radii)
    if not table.is_rectangle:
        _refuse_where(
            ~is_inside(table.outline, x, y),
            scene,
            starts,
            "must be inside the table, which it isn't. Move the ball",
        )
    for one in table.obstacles:
        gap = gap_to(one, x, y)
        if isinstance(one, Hole):
            _refuse_where(
                gap <= 0.0,
                scene,
                starts,
                f'must be outside of the hole of the pocket "{POCKETS[one.pocket]}", round '
                f"{one.centre} m with a radius of {one.radius:g} m. Leave the ball out, or move it",
            )
            continue
        is_post = isinstance(one, Disc) and one.inward is None  # taller than any ball flies
        at = (
            f"round {one.centre} m with a radius of {one.radius:g} m"
            if isinstance(one, Disc)
            else f"between {one.start} and {one.end} m"
        )
        what = {Disc: ", a post " if is_post else ", a jaw ", Segment: " "}[type(one)]
        nose = not is_post and scene.physics.airborne
        clear = "clear of the nose of" if nose else "at least the radius from"
        _refuse_where(
            gap < (radii if is_post else to_nose) - permitted,
            scene,
            starts,
            f'must be {clear} "{obstacle_name(one.obstacle)}"{what}{at}. Move the ball',
        )


def _permitted_beyond(table: Table, x: FloatArray, y: FloatArray, radii: FloatArray) -> FloatArray:
    """Return the permitted initial overlap of balls with obstacles on a table, (m,) [m]."""
    return permitted_overlap(2.0 * radii, x, y, np.array(table.length), np.array(table.width))


def _refuse_where(wrong: BoolArray, scene: SceneContents, starts: Starts, rule: str) -> None:
    """Refuse the first ball whose place is wrong, (m,)."""
    k = _first(wrong)
    if k is not None:
        x, y = starts.position[k, :2].tolist()
        ball = scene.balls[starts.ball[k]]
        raise problem(
            "outside",
            f'{starts.name(k, ".position")} {rule}: ball "{ball.id}" is at ({x}, {y}) m, and its '
            f"radius is {ball.radius:g} m",
            at=("balls", int(starts.ball[k]), "position"),
        )


def _reach_of_nose(scene: SceneContents, starts: Starts) -> FloatArray:
    """Return how near balls' centres may be to a cushion, in plan, (m,) [m]."""
    if not scene.physics.airborne:
        return starts.radius
    above = starts.position[:, 2] - scene.physics.cushion_height
    reach: FloatArray = np.sqrt(np.maximum(starts.radius**2 - above**2, 0.0))
    return reach


def _check_overlaps(scene: SceneContents, starts: Starts) -> None:
    # Balls touch at a centre distance of the sum of their radii: in the plane for balls on the
    # cloth (see "Geometry" in engine/__init__.py), in space where they may fly.
    dimensions, n = 3 if scene.physics.airborne else 2, len(scene.balls)
    radii = scene.radii
    centres = starts.position[:, :dimensions].reshape(-1, n, dimensions)
    found = overlaps(centres, radii)
    if len(found) == 0:
        return
    shot, i, j, overlap = found[0]
    one, other = scene.balls[j].id, scene.balls[i].id
    distance = np.sqrt(np.sum((centres[shot, j] - centres[shot, i]) ** 2))
    raise problem(
        "overlap",
        f'`balls[{j}]` ("{one}") and {starts.name(shot * n + i)} ("{other}") must not overlap, '
        f"but do by {overlap:.6g} m: their centres are {distance:.9g} m apart and their radii add "
        f"up to {radii[i] + radii[j]:.9g} m. Move one of them",
        at=("balls", i, "position"),
    )


_MOST_OVERLAPS = 100_000
"""Overlaps after which no others are sought: thousands of balls at one place have millions."""


_MOST_AT_ONCE = 100_000
"""Pairs after which those found so far are looked at: some megabytes."""


def overlaps(centres: FloatArray, radii: FloatArray) -> list[tuple[int, int, int, float]]:
    """Return the balls that overlap more than permitted: shot, pair i > j, and overlap [m].

    In order of shot and i, the largest first; not all of them where there are hundreds of
    thousands. `centres` is (k, n, 2 or 3) [m], `radii` (n,) [m].

    The balls of a shot are sorted along x, so that each is compared with those that follow within
    reach, and no others: the first with the next, with the one after that ..., all at once.
    """
    order = np.argsort(centres[:, :, 0], axis=1, kind="stable")
    placed = np.take_along_axis(centres, order[:, :, None], axis=1)
    sizes = radii[order]
    reach = 2.0 * float(np.max(radii, initial=0.0))
    found: list[tuple[int, int, int, float]] = []
    for shot, one, other in _near(placed, reach):
        first, second = placed[shot, one], placed[shot, other]
        overlap = sizes[shot, one] + sizes[shot, other]
        overlap -= np.sqrt(np.sum((second - first) ** 2, axis=1))
        lengths = np.concatenate((first, second), axis=1)
        radius, radius_of_other = sizes[shot, one], sizes[shot, other]
        reached = radius + radius_of_other
        permitted = permitted_overlap(reached, *lengths.T, radius, radius_of_other)
        if centres.shape[2] == 3:
            in_air = (first[:, 2] > radius) | (second[:, 2] > radius_of_other)
            permitted += np.where(in_air, FLIGHT_CONTACT_TOLERANCE * reached, 0.0)
        for m in np.flatnonzero(overlap > permitted)[:_MOST_OVERLAPS]:
            i, j = int(order[shot[m], one[m]]), int(order[shot[m], other[m]])
            found.append((int(shot[m]), max(i, j), min(i, j), float(overlap[m])))
        if len(found) > _MOST_OVERLAPS:
            break
    return sorted(found, key=lambda pair: (pair[0], pair[1], -pair[3], pair[2]))


def _near(placed: FloatArray, reach: float) -> Iterator[tuple[IntArray, IntArray, IntArray]]:
    """Yield pairs of balls that are near each other along x and y: shot, one and other.

    `placed` is (k, n, 2 or 3), sorted along x. Many pairs at a time: as soon as they are more than
    `_MOST_AT_ONCE`.
    """
    x, y = np.ascontiguousarray(placed[:, :, 0]), np.ascontiguousarray(placed[:, :, 1])
    pairs: list[tuple[IntArray, IntArray, IntArray]] = []
    count = 0
    for lag in range(1, placed.shape[1]):
        if (x[:, lag:] - x[:, :-lag]).min(initial=np.inf) > reach:
            break
        shot, one = np.nonzero(np.abs(y[:, lag:] - y[:, :-lag]) < reach)  # few of many balls
        pairs.append((shot, one, one + lag))
        count += len(shot)
        if count > _MOST_AT_ONCE:
            yield _joined(pairs)
            pairs, count = [], 0
    if pairs:
        yield _joined(pairs)


def _joined(pairs: Sequence[tuple[IntArray, ...]]) -> tuple[IntArray, IntArray, IntArray]:
    shot, one, other = map(np.concatenate, zip(*pairs, strict=True))
    return shot, one, other
