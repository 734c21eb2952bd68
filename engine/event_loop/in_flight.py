"""Events in scenes with flight: balls land, hit noses, leave the table, or rest on other balls.

`impacts` computes the effects of the impacts. A bounce is the slow impact of a ball that lies on
another ball; see `impacts.slow_impacts`. The lower ball shares the impulse of a bounce with all
balls that it touches: their contacts are listed here, and a contact step begins with them.
"""

from __future__ import annotations

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, FloatArray, Laws, World
from ghostball.engine.event_loop.record import (
    BALL_CLOTH_EVENT,
    BALL_CUSHION_EVENT,
    LEAVES_TABLE_EVENT,
    POCKETED_EVENT,
    note_event,
    note_rest,
)
from ghostball.engine.impacts.impact import collide_balls
from ghostball.engine.impacts.in_space import bounce_off_nose, collide_in_space, fastest_nose
from ghostball.engine.impacts.lying_still import let_go, list_touching, load, share_load
from ghostball.engine.impacts.on_table import land
from ghostball.engine.impacts.slow_impacts import lies_on
from ghostball.engine.motion.flight import one_is_loaded
from ghostball.engine.motion.next_piece import leave, mark
from ghostball.engine.motion.obstacles import hole_at


@kernel(inline=True)
def resolve_flight(world: World, i: int, kind: int, t: float) -> bool:
    """Resolve an event of ball i alone in the air: landing, hitting a nose, or leaving the table.

    Return whether the event is one of these.
    """
    balls, laws, log = world.balls, world.laws, world.log
    height = balls.height
    if height is None:
        return False
    hole = hole_at(laws, balls.state[i].x, balls.state[i].y) if kind == st.OWN_LAND else -1
    if hole >= 0:
        height[i, st.RISE] = 0.0  # as at a landing, because the computed height is rounding
        fall_into(world, i, hole, t)
    elif kind in (st.OWN_LAND, st.OWN_BOUNCES_END):
        note_event(BALL_CLOTH_EVENT, i, -1, t, log)
        if kind == st.OWN_LAND:
            land(height, balls, i, laws)
    elif kind >= st.OWN_OVER:
        row = laws.obstacles[kind - st.OWN_OVER]
        first = st.FIRST_HOLE if row.law == st.TAKES_OUT else 0
        _take_out(world, i, LEAVES_TABLE_EVENT, first + int(row.index), t)
    elif kind >= st.OWN_CUSHION and laws.obstacles[kind - st.OWN_CUSHION].law == st.TAKES_OUT:
        fall_into(world, i, kind - st.OWN_CUSHION, t)
    elif kind >= st.OWN_CUSHION and balls.state[i].phase == st.FLYING:
        nose = fastest_nose(height, balls, i, kind - st.OWN_CUSHION, laws)
        log.counters[st.BALL_CUSHION] += 1
        note_event(BALL_CUSHION_EVENT, i, int(laws.obstacles[nose].index), t, log)
        bounce_off_nose(height, balls, i, nose, laws)
        balls.state[i].impacts += 1.0
        _note_held(height, world, i, t)
    else:
        return False
    mark(balls, i)
    return True


@kernel(inline=True)
def fall_into(world: World, i: int, k: int, t: float) -> None:
    """Let ball i fall into the hole with row k."""
    _take_out(world, i, POCKETED_EVENT, int(world.laws.obstacles[k].index), t)


@kernel(inline=True)
def _take_out(world: World, i: int, kind: int, index: int, t: float) -> None:
    """Remove ball i from the run at its position."""
    height = world.balls.height
    world.log.counters[st.BALLS_GONE] += 1
    note_event(kind, i, index, t, world.log)
    leave(world.balls, i)
    if height is not None:
        height[i, st.UP_SPEED], height[i, st.FALL], height[i, st.LASTS] = 0.0, 0.0, 0.0


@kernel(inline=True)
def collide_pair(world: World, i: int, j: int) -> None:
    """Collide two balls that have no other impact at this time."""
    balls, laws = world.balls, world.laws
    if balls.height is not None and laws.airborne:
        let_go(balls.height, balls, i)
        let_go(balls.height, balls, j)
        collide_in_space(balls.height, world, i, j)
    else:
        collide_balls(balls, i, j, laws)


@kernel(inline=True)
def is_slow_impact(balls: Balls, laws: Laws, t: float) -> bool:
    """Return whether the first pair of `balls.touching`, at t [s], is one ball on another."""
    if balls.height is None:
        return False
    a, b = balls.touching[0, st.FIRST], balls.touching[0, st.SECOND]
    return lies_on(balls.height, balls, a, b, laws, t)


@kernel(inline=True)
def list_below(world: World, t: float) -> int:
    """List in `balls.touching` the contacts closed by its first pair's bounce; count them."""
    balls = world.balls
    height = balls.height
    if height is None:
        return 0
    a, b = int(balls.touching[0, st.FIRST]), int(balls.touching[0, st.SECOND])
    load(height, balls, world.laws, a, b, t)
    count = list_touching(world, a, t, 0, True)
    count = list_touching(world, b, t, count, True)
    share_loads(balls, count, t)
    return count


@kernel(inline=True)
def share_loads(balls: Balls, count: int, t: float) -> None:
    """Mark the balls of all touching pairs as loaded that are linked to a loaded ball at t [s]."""
    height = balls.height
    if height is not None:
        for _ in range(count):  # each round reaches the next balls of a row, in any order of pairs
            is_new = False
            for c in range(count):
                i, j = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]
                if j < 0 or height[i, st.LOADED] == height[j, st.LOADED]:
                    continue
                if one_is_loaded(balls, i, j, t):
                    share_load(height, i, j)
                    is_new = True
            if not is_new:
                break


@kernel(inline=True)
def note_held(world: World, count: int, t: float) -> None:
    """Log which balls of the first `count` touching pairs came to rest on other balls."""
    if world.balls.height is not None:
        for c in range(count):
            for end in (st.FIRST, st.SECOND):
                _note_held(world.balls.height, world, int(world.balls.touching[c, end]), t)


@kernel(inline=True)
def _note_held(height: FloatArray, world: World, i: int, t: float) -> None:
    """If ball i is held on other balls, log that ball i came to rest."""
    if world.balls.state[i].phase == st.FLYING and height[i, st.HELD] == 1.0:
        note_rest(world, i, t)
