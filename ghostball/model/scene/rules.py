"""The rules between the fields of a scene; each rejects a scene with one sentence.

The values that a single field may have are defined in `scene.fields`.
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
from ghostball.model.scene.initial_states import InitialStates, initial_states_of
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
from ghostball.model.scene.quick_check import certainly_valid
from ghostball.model.scene.table import Table


def check_scene(scene: SceneContents) -> None:
    """Check a scene whose fields are each valid.

    Raises `PydanticCustomError` for the first rule that is broken.
    """
    if certainly_valid(scene):
        check_laws_in_scene(scene)
    else:
        check_each_rule(scene)


def check_each_rule(scene: SceneContents) -> None:
    """Check a scene with every rule, in order, without the fast check.

    Raises `PydanticCustomError` for the first rule that is broken.
    """
    starts = initial_states_of(scene)
    _check_ids(scene)
    check_places(scene, starts)
    check_laws_in_scene(scene)
    check_motions(scene, starts)


def check_places(scene: SceneContents, starts: InitialStates) -> None:
    """Check the initial positions of all balls of a scene, in one shot, or shot after shot in many.

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
                f"`balls[{i}].id` must be unique, but `balls[{seen[ball.id]}]` is called "
                f'"{ball.id}" too',
                at=("balls", i, "id"),
            )
        seen[ball.id] = i


def _check_height(scene: SceneContents, starts: InitialStates) -> None:
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
            f"{radius - z:.6g} m below the cloth. Raise it, or remove z"
            if flies
            else f"must be the radius, {radius} m, got {z} m: the ball must lie on the cloth. "
            "Remove z"
        )
    else:
        rule = (
            f"must be at least 0 for a ball that lies on the cloth, got {speed} m/s. Remove z, "
            "or give the upward velocity after the bounce"
            if flies
            else f"must be 0, got {speed} m/s: the ball must stay on the cloth. Remove z"
        )
    raise starts.problem(k, "position" if wrong[k] else "velocity", f"z {rule}")


def _first(wrong: BoolArray) -> int | None:
    """Return the index of the first true element of (m,), or None."""
    found = np.flatnonzero(wrong)
    return int(found[0]) if len(found) else None


def _check_resolved(starts: InitialStates) -> None:
    # Otherwise balls at the same position would count as touching, and collisions would be missed.
    rounding = position_rounding(starts.position[:, 0], starts.position[:, 1])
    radii = starts.radius
    k = _first(rounding >= radii)
    if k is not None:
        x, y = starts.position[k, :2].tolist()
        raise starts.problem(
            k,
            "position",
            f"is too far from the origin: at ({x}, {y}) m doubles round by up to "
            f"{rounding[k]:.2g} m, more than the radius, {radii[k]} m. Move the scene closer to "
            "the origin",
        )


def _check_inside(scene: SceneContents, starts: InitialStates) -> None:
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
        far = "its radius" if reach[k] == radii[k] else "its reach at the height of the nose"
        raise starts.problem(
            k,
            "position",
            f'must be inside the table: ball "{scene.balls[starts.ball[k]].id}" at '
            f"({float(x[k])}, {float(y[k])}) m reaches {-gaps[side, k]:.6g} m beyond the "
            f"{table.sides[side].name} cushion. Its centre must be at least {far}, "
            f"{float(reach[k])} m, from each cushion",
        )


def _check_obstacles(scene: SceneContents, starts: InitialStates) -> None:
    """Check that balls are inside a table that isn't a plain rectangle, clear of obstacles."""
    table = scene.table
    if table is None or not table.obstacles:
        return
    x, y, radii = starts.position[:, 0], starts.position[:, 1], starts.radius
    to_nose = _reach_of_nose(scene, starts)
    permitted = _permitted_beyond(table, x, y, radii)
    if not table.is_rectangle:
        _reject_where(
            ~is_inside(table.outline, x, y),
            scene,
            starts,
            "must be inside the table. Move the ball",
        )
    for one in table.obstacles:
        gap = gap_to(one, x, y)
        if isinstance(one, Hole):
            _reject_where(
                gap <= 0.0,
                scene,
                starts,
                f'must be outside the hole of pocket "{POCKETS[one.pocket]}", around '
                f"{one.centre} m with a radius of {one.radius:g} m. Remove the ball, or move it",
            )
            continue
        is_post = isinstance(one, Disc) and one.inward is None  # a post is higher than any flight
        at = (
            f"around {one.centre} m with a radius of {one.radius:g} m"
            if isinstance(one, Disc)
            else f"between {one.start} and {one.end} m"
        )
        what = {Disc: ", a post " if is_post else ", a jaw ", Segment: " "}[type(one)]
        nose = not is_post and scene.physics.airborne
        clear = "clear of the nose of" if nose else "at least the radius from"
        _reject_where(
            gap < (radii if is_post else to_nose) - permitted,
            scene,
            starts,
            f'must be {clear} "{obstacle_name(one.obstacle)}"{what}{at}. Move the ball',
        )


def _permitted_beyond(table: Table, x: FloatArray, y: FloatArray, radii: FloatArray) -> FloatArray:
    """Return the permitted initial overlap of balls with the obstacles of a table, (m,) [m]."""
    return permitted_overlap(2.0 * radii, x, y, np.array(table.length), np.array(table.width))


def _reject_where(wrong: BoolArray, scene: SceneContents, starts: InitialStates, rule: str) -> None:
    """Reject the first ball for which `wrong`, (m,), is true."""
    k = _first(wrong)
    if k is not None:
        x, y = starts.position[k, :2].tolist()
        ball = scene.balls[starts.ball[k]]
        where = f'ball "{ball.id}" is at ({x}, {y}) m, and its radius is {ball.radius:g} m'
        raise starts.problem(k, "position", f"{rule}: {where}")


def _reach_of_nose(scene: SceneContents, starts: InitialStates) -> FloatArray:
    """Return the smallest distance of balls' centres from a cushion, seen from above, (m,) [m]."""
    if not scene.physics.airborne:
        return starts.radius
    above = starts.position[:, 2] - scene.physics.cushion_height
    reach: FloatArray = np.sqrt(np.maximum(starts.radius**2 - above**2, 0.0))
    return reach


def _check_overlaps(scene: SceneContents, starts: InitialStates) -> None:
    # Balls touch if the distance of their centres is the sum of their radii: in the plane for balls
    # on the cloth (see "Coordinates" in engine/__init__.py), in space for airborne balls.
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
        f'`balls[{j}]` ("{one}") and {starts.name(shot * n + i)} ("{other}") overlap by '
        f"{overlap:.6g} m: their centres are {distance:.9g} m apart and their radii add up to "
        f"{radii[i] + radii[j]:.9g} m. Move one of them",
        at=("balls", i, "position"),
    )


_MAX_OVERLAPS = 100_000
"""Number of overlaps after which the search stops; balls at one place have millions."""


_PAIRS_AT_ONCE = 100_000
"""Number of pairs that are checked together: a few megabytes."""


def overlaps(centres: FloatArray, radii: FloatArray) -> list[tuple[int, int, int, float]]:
    """Return the overlaps that are larger than permitted: shot, pair i > j, and overlap [m].

    The result is sorted by shot and i, then by decreasing overlap. It is incomplete if there are
    hundreds of thousands of overlaps. `centres` is (k, n, 2 or 3) [m], `radii` (n,) [m].

    The balls of each shot are sorted along x, so each ball is compared only with the following
    balls within reach: with the next ball, then with the one after that, for all balls at once.
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
        for m in np.flatnonzero(overlap > permitted)[:_MAX_OVERLAPS]:
            i, j = int(order[shot[m], one[m]]), int(order[shot[m], other[m]])
            found.append((int(shot[m]), max(i, j), min(i, j), float(overlap[m])))
        if len(found) > _MAX_OVERLAPS:
            break
    return sorted(found, key=lambda pair: (pair[0], pair[1], -pair[3], pair[2]))


def _near(placed: FloatArray, reach: float) -> Iterator[tuple[IntArray, IntArray, IntArray]]:
    """Yield pairs of balls that are close to each other in x and y: shot, first ball, second ball.

    `placed` is (k, n, 2 or 3), sorted along x. Each yield has many pairs: it comes as soon as there
    are more than `_PAIRS_AT_ONCE`.
    """
    x, y = np.ascontiguousarray(placed[:, :, 0]), np.ascontiguousarray(placed[:, :, 1])
    pairs: list[tuple[IntArray, IntArray, IntArray]] = []
    count = 0
    for lag in range(1, placed.shape[1]):
        if (x[:, lag:] - x[:, :-lag]).min(initial=np.inf) > reach:
            break
        shot, one = np.nonzero(
            np.abs(y[:, lag:] - y[:, :-lag]) < reach
        )  # only a few pairs are close
        pairs.append((shot, one, one + lag))
        count += len(shot)
        if count > _PAIRS_AT_ONCE:
            yield _joined(pairs)
            pairs, count = [], 0
    if pairs:
        yield _joined(pairs)


def _joined(pairs: Sequence[tuple[IntArray, ...]]) -> tuple[IntArray, IntArray, IntArray]:
    shot, one, other = map(np.concatenate, zip(*pairs, strict=True))
    return shot, one, other
