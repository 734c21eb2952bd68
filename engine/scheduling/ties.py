"""Order events of equal time, and list the pairs that collide together; for both schedulers."""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, World
from ghostball.engine.motion.geometry import capture_height, tie_rounding
from ghostball.engine.motion.position import pair_reach, position_at, relative_motion


@kernel
def takes_precedence(balls: Balls, i: int, j: int) -> bool:
    """Return whether the own event of ball i is resolved before that of ball j at the same time."""
    if balls.own_kind[i] != balls.own_kind[j]:
        return bool(balls.own_kind[i] < balls.own_kind[j])
    if balls.own_kind[i] < st.OWN_CUSHION:
        return False
    dx, dy, _, _, _, _ = relative_motion(balls, i, j, balls.state[i].own_time)
    gap = math.sqrt(dx * dx + dy * dy) - pair_reach(balls, i, j)
    open_gap = gap > capture_height(balls, i, j)
    return bool(not open_gap and (dx > 0.0 or (dx == 0.0 and dy > 0.0)))


@kernel
def comes_before(
    balls: Balls, listed: int, speed: float, fastest: float, i: int, j: int, t: float
) -> bool:
    """Return whether the impact of i and j at t [s] comes before that in row 0 of `balls.touching`.

    The faster impact comes first. Symmetric scenes have impacts of equal speed. The first is then
    the one whose balls have the greater sum of x, then of y: positions decide, not indices.
    """
    if listed == 0 or speed != fastest:
        return bool(speed > fastest)
    x, y = _sum_of_places(balls, i, j, t)
    first_x, first_y = _sum_of_places(
        balls, balls.touching[0, st.FIRST], balls.touching[0, st.SECOND], t
    )
    return bool(x > first_x or (x == first_x and y > first_y))


@kernel
def _sum_of_places(balls: Balls, i: int, j: int, t: float) -> tuple[float, float]:
    """Return the sums of the x and of the y coordinates of both balls at time t [m]."""
    (xi, yi), (xj, yj) = position_at(balls, i, t), position_at(balls, j, t)
    return xi + xj, yi + yj


@kernel
def has_room(world: World, count: int, lasting: int) -> bool:
    """Return whether `balls.touching` has a row besides `count` impacts and `lasting` contacts.

    If it has none, set NO_ROOM, which makes the loop end the run.
    """
    if count + lasting < world.balls.touching.shape[0]:
        return True
    world.log.counters[st.NO_ROOM] = 1
    return False


@kernel
def list_pair(balls: Balls, c: int, i: int, j: int) -> None:
    """Put the pair of balls i and j in row c of `balls.touching`, the lower index first.

    Requires: row c exists; see `has_room`.
    """
    balls.touching[c, st.FIRST] = min(i, j)
    balls.touching[c, st.SECOND] = max(i, j)


@kernel
def is_listed(balls: Balls, listed: int, i: int) -> bool:
    """Return whether ball i is in the first `listed` rows of `balls.touching`."""
    for c in range(listed):
        if balls.touching[c, st.FIRST] == i or balls.touching[c, st.SECOND] == i:
            return True
    return False


@kernel
def is_pair_listed(balls: Balls, start: int, stop: int, i: int, j: int) -> bool:
    """Return whether the pair of balls i and j is in rows `start` to `stop` of `balls.touching`."""
    for c in range(start, stop):
        if balls.touching[c, st.FIRST] == min(i, j) and balls.touching[c, st.SECOND] == max(i, j):
            return True
    return False


@kernel
def when_tied(balls: Balls, listed: int, t: float, speed: float) -> float:
    """Return the time [s] up to which rounding can shift the contact of a gap that closes at t [s].

    `speed` is the highest approach speed of the first `listed` pairs of `balls.touching`.
    """
    rounding = 0.0
    for c in range(listed):
        a, b = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]
        rounding = max(rounding, tie_rounding(balls, a, b, t))
    return t + rounding / speed


@kernel
def sort_pairs(balls: Balls, count: int) -> None:
    """Sort the first `count` pairs of `balls.touching` by their indices."""
    for c in range(1, count):
        a, b, index = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND], c
        while index > 0 and _is_after(balls, index - 1, a, b):
            list_pair(
                balls,
                index,
                balls.touching[index - 1, st.FIRST],
                balls.touching[index - 1, st.SECOND],
            )
            index -= 1
        list_pair(balls, index, a, b)


@kernel
def _is_after(balls: Balls, c: int, a: int, b: int) -> bool:
    first, second = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]
    return bool(first > a or (first == a and second > b))
