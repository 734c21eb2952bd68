"""Make the rows of `Laws.obstacles`: cushions, posts and holes on a scene's table."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ghostball.engine.core import state as st
from ghostball.engine.core.rows import OBSTACLE_COLUMNS
from ghostball.engine.core.state import FloatArray
from ghostball.engine.running.skips import Skip, has_frame
from ghostball.model import (
    CUSHIONS,
    INWARD,
    Disc,
    Hole,
    Obstacle,
    Physics,
    Scene,
    Segment,
    Table,
)
from ghostball.model.impact_laws import CUSHION_LAW_NAMES, CUSHION_LAWS

_FAR = 1e150
"""Distance of a cushion that no ball reaches [m]; its square is finite, so no result is NaN."""


def obstacles_of(scene: Scene, off: frozenset[Skip] = frozenset()) -> FloatArray:
    """Return the rows of a scene's obstacles, (k, OBSTACLE_COLUMNS).

    First, a line for each cushion, through its nose. A side without a cushion has no row, or, if
    the skip "cushions" is switched off, a line too far away to be reached. Then the rows of posts,
    then those of the obstacles along the sides and behind them, in the order of the table.
    """
    return _rows_of(scene.table, scene.physics, Skip.CUSHIONS in off)


@lru_cache(maxsize=32)
def _rows_of(table: Table | None, physics: Physics, everywhere: bool) -> FloatArray:
    """Return the rows of a table's obstacles; with `everywhere`, with a cushion on each side.

    The array is read-only, because calls share it: rows of the last tables are cached, since a
    table with pockets has dozens.
    """
    law, coefficients = CUSHION_LAW_NAMES.index(physics.cushion), coefficients_of(physics)
    rows: list[tuple[float, ...]] = []
    sides = {} if table is None else {side.name: side for side in table.sides}
    for index, name in enumerate(CUSHIONS):
        normal = INWARD[name]
        if name in sides:
            point = sides[name].point
        elif everywhere:
            point = (-_FAR * normal[0], -_FAR * normal[1])
        else:
            continue
        rows.append((st.LINE, *point, *normal, 0.0, law, index, *coefficients))
    posts, others = _obstacles_in_order(table)
    rows += [(*_place_of(one, law), *coefficients) for one in (*posts, *others)]
    found = np.array(rows, dtype=np.float64).reshape(-1, OBSTACLE_COLUMNS)
    found.flags.writeable = False
    return found


def _obstacles_in_order(table: Table | None) -> tuple[Sequence[Obstacle], Sequence[Obstacle]]:
    """Return a table's posts, and its other obstacles except the lines of cushions."""
    obstacles = () if table is None else table.obstacles
    posts = [one for one in obstacles if isinstance(one, Disc) and one.inward is None]
    return posts, [one for one in obstacles if one not in posts]


def outer_of(scene: Scene, count: int, off: frozenset[Skip]) -> int:
    """Return the index of the first of the `count` rows that is outside the table's rectangle.

    On a table with pockets, all obstacles except posts and lines are outside: noses lie along the
    sides, the other obstacles behind the noses. The result is `count` if the kernels must always
    check all rows.
    """
    if not has_frame(scene) or Skip.FAR_OBSTACLES in off:
        return count
    _, others = _obstacles_in_order(scene.table)
    return count - len(others)


def _place_of(one: Obstacle, law: int) -> tuple[float, ...]:
    """Return the first numbers of an obstacle's `ObstacleRow`, up to `index`."""
    if isinstance(one, Segment):
        return (st.SEGMENT, *one.start, *one.end, 0.0, law, one.obstacle)
    normal = one.inward or (0.0, 0.0)
    if isinstance(one, Hole):
        return (st.DISC, *one.centre, *normal, one.radius, st.TAKES_OUT, one.pocket)
    return (st.DISC, *one.centre, *normal, one.radius, law, one.obstacle)


def coefficients_of(physics: Physics) -> tuple[float, ...]:
    """Return the last numbers of an `ObstacleRow`, from `turns` on: those of the cushion's law."""
    mirror = physics.cushion == "mirror"
    return (
        CUSHION_LAWS[CUSHION_LAW_NAMES.index(physics.cushion)].turns,
        1.0 if mirror else physics.cushion_restitution,
        0.0 if mirror else physics.cushion_restitution_loss,
        1.0 if mirror else physics.cushion_tangential_restitution,
        physics.cushion_friction,
        physics.cushion_height,
        physics.cushion_frequency_ratio if physics.cushion == "stronge2000" else 0.0,
    )
