"""A shot with renumbered balls, and mirror images of a shot: bit-identical results.

`is_promised` and `mirrored` name the shots for which the engine doesn't promise this.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from ghostball.engine.running.skips import has_drag
from ghostball.model import Ball, EventKind, Result, Scene, Table
from ghostball.validation.checks.related_shots import (
    depends_on_direction,
    depends_on_order,
    hits_two_in_turn,
)
from same.plays import play, played, with_balls

Plane = Callable[[Any, Any], tuple[Any, Any]]
"""A map of the plane onto itself that maps the axes to the axes."""

MAPS: Final[Mapping[str, tuple[Plane, float]]] = {
    "diagonal": (lambda x, y: (y, x), -1.0),
    "left-right": (lambda x, y: (-x, y), -1.0),
    "quarter turn": (lambda x, y: (-y, x), 1.0),
}
"""Maps, each with its factor on angular velocities: mirrors reverse axial vectors."""

_SWAPPED: Final = {"left": "bottom", "right": "top", "bottom": "left", "top": "right"}


def renumbered(scene: Scene) -> str | None:
    """Return the difference of the result if the balls are in another order."""
    n = len(scene.balls)
    if n < 2 or not is_promised(scene):
        return None
    order = list(range(n))[::-1]
    other = play(shuffled(scene, order), "events")
    return _difference(played(scene), other, order, lambda x, y: (x, y), "balls in reverse order")


def mirrored(scene: Scene) -> str | None:
    """Return the difference for the mirror x = y; without cushions also x = 0 and a quarter turn.

    A mirror at the middle of a table rounds, and so do mirror images of oblique or round obstacles.
    With air drag or quadratic rolling friction, cushion contacts are exact only to rounding. In all
    these cases nothing is compared, nor if the shot itself `depends_on_direction`.
    """
    bounded = scene.table is not None and scene.table.has_cushions
    if depends_on_direction(played(scene)) or hits_two_in_turn(played(scene)):
        return None
    if bounded and has_drag(scene):
        return None
    if scene.table is not None and scene.table.obstacles:
        return None
    for name in ("diagonal",) if bounded else MAPS:
        other = play(image(scene, name), "events")
        order = list(range(len(scene.balls)))
        found = _difference(played(scene), other, order, MAPS[name][0], f"image in {name}")
        if found is not None:
            return found
    return None


def is_promised(scene: Scene) -> bool:
    """Return whether the engine promises that the order of the balls changes no bit of a shot."""
    return not depends_on_order(played(scene))


def image(scene: Scene, name: str) -> Scene:
    """Return the image of a scene under a named map; with cushions, only for the diagonal."""
    table = scene.table
    if table is not None and table.cushions:
        assert name == "diagonal"
        table = Table(
            length=table.width,
            width=table.length,
            cushions=tuple(_SWAPPED[side] for side in table.cushions),
        )
    return with_balls(scene, [image_of_ball(one, name) for one in scene.balls], table=table)


def image_of_ball(one: Ball, name: str) -> Ball:
    """Return the image of a ball under a named map."""
    plane, sign = MAPS[name]
    fields = one.without_strike().model_dump(exclude_none=True)
    for field in ("position", "velocity"):
        x, y, z = fields[field]
        fields[field] = (*plane(x, y), z)
    if one.angular_velocity is not None:
        x, y, z = one.angular_velocity
        wx, wy = plane(x, y)
        fields["angular_velocity"] = (sign * wx, sign * wy, sign * z)
    return Ball(**fields)


def shuffled(scene: Scene, order: Sequence[int]) -> Scene:
    """Return the scene whose ball k is ball order[k]."""
    return with_balls(scene, [scene.balls[i] for i in order])


def rows_of(result: Result, order: Sequence[int]) -> list[tuple[float, int, int, int]]:
    """Return the sorted events, with ball k renamed to order[k]; simultaneous events have no order.

    Cushions are left out, because they have different names in an image.
    """
    assert result.events is not None
    rows = []
    for t, kind, a, b in result.events.tolist():
        first, second = order[a], -1
        if kind == EventKind.BALL_BALL:
            first, second = sorted((first, order[b]))
        rows.append((t, kind, first, second))
    return sorted(rows)


def _difference(
    base: Result, other: Result, order: Sequence[int], plane: Plane, how: str
) -> str | None:
    """Return how `other`, whose ball k is ball order[k] of `base`, differs from the image."""
    if base.status is not other.status:
        return f"{how}: {other.status.name} ({other.reason}) instead of {base.status.name}"
    ours, theirs = rows_of(base, range(len(order))), rows_of(other, order)
    for k, (one, two) in enumerate(zip(ours, theirs, strict=False)):
        if one != two:
            return f"{how}: event {k} is {two} instead of {one}"
    if len(ours) != len(theirs):
        return f"{how}: {len(theirs)} events instead of {len(ours)}"
    if base.rest_time != other.rest_time:
        return f"{how}: ends at {other.rest_time!r} s instead of {base.rest_time!r} s"
    places = base.rest_positions[list(order)]
    x, y = plane(places[:, 0], places[:, 1])
    wanted = np.column_stack((x, y, places[:, 2]))
    if not np.array_equal(other.rest_positions, wanted):
        off = float(np.max(np.abs(other.rest_positions - wanted)))
        return f"{how}: positions at the end differ by {off:.3g} m"
    return None
