"""What happens at an event where balls may leave the cloth: they land, hop, meet noses, lie still.

What an impact does is in `impacts`. A hop is the slow impact of a ball that lies on another; see
`impacts.slow_impacts`. What it kicks the lower one by is ended together with all balls that this
touches: those contacts are listed here, for a contact step to begin with.
"""

from __future__ import annotations

from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import (
    BALL_CUSHION,
    BALLS_GONE,
    FALL,
    FIRST,
    FLYING,
    HELD,
    OWN_CUSHION,
    OWN_LAND,
    OWN_OVER,
    OWN_SETTLE,
    SECOND,
    UP_SPEED,
    Balls,
    Cells,
    Contacts,
    FloatArray,
    Laws,
    Log,
)
from ghostball.engine.event_loop.record import (
    BALL_CLOTH_EVENT,
    BALL_CUSHION_EVENT,
    LEAVES_TABLE_EVENT,
    note_event,
    note_rest,
)
from ghostball.engine.impacts.impact import collide_balls
from ghostball.engine.impacts.in_space import bounce_off_nose, collide_in_space, fastest_nose
from ghostball.engine.impacts.on_table import end_bounces, land
from ghostball.engine.impacts.slow_impacts import (
    let_go,
    lies_on,
    list_touching,
    load,
    share_load,
)
from ghostball.engine.motion.flight import one_is_loaded
from ghostball.engine.motion.next_piece import leave, mark


@kernel(inline=True)
def has_settled(height: FloatArray | None, balls: Balls, i: int, kind: int, t: float) -> bool:
    """Move ball i to where its bounces end, if that is what happens."""
    if height is None:
        return False
    if kind != OWN_SETTLE:
        return False
    end_bounces(height, balls, i, t)
    return True


@kernel(inline=True)
def resolve_flight(
    height: FloatArray | None,
    balls: Balls,
    laws: Laws,
    contacts: Contacts | None,
    i: int,
    kind: int,
    t: float,
    log: Log,
) -> bool:
    """Resolve what ball i does alone in the air: it lands, meets a nose, leaves the table.

    Return whether it is that.
    """
    if height is None:
        return False
    if kind in (OWN_LAND, OWN_SETTLE):
        note_event(BALL_CLOTH_EVENT, i, -1, t, log)
        if kind == OWN_LAND:
            land(height, balls, i, laws)
    elif kind >= OWN_OVER:
        log.counters[BALLS_GONE] += 1
        note_event(LEAVES_TABLE_EVENT, i, int(laws.obstacles[kind - OWN_OVER].index), t, log)
        leave(balls, i)
        height[i, UP_SPEED], height[i, FALL] = 0.0, 0.0
    elif kind >= OWN_CUSHION and balls.state[i].phase == FLYING:
        nose = nose_of(height, balls, laws, i, kind - OWN_CUSHION)
        log.counters[BALL_CUSHION] += 1
        note_event(BALL_CUSHION_EVENT, i, int(laws.obstacles[nose].index), t, log)
        bounce_off_nose(height, balls, i, nose, laws)
        _note_held(height, balls, contacts, i, t, log)
    else:
        return False
    mark(balls, i)
    return True


@kernel(inline=True)
def collide_pair(
    height: FloatArray | None, balls: Balls, i: int, j: int, laws: Laws, cells: Cells | None
) -> None:
    """Collide two balls neither of which has another impact now."""
    if height is None:
        collide_balls(balls, i, j, laws)
        return
    if laws.airborne:
        let_go(height, balls, i)
        let_go(height, balls, j)
        collide_in_space(height, balls, i, j, laws, cells)
    else:
        collide_balls(balls, i, j, laws)


@kernel(inline=True)
def nose_of(height: FloatArray | None, balls: Balls, laws: Laws, i: int, cushion: int) -> int:
    """Return which cushion ball i meets first, of those that it meets with the given one."""
    if height is None:
        return cushion
    return fastest_nose(height, balls, i, cushion, laws) if laws.airborne else cushion


@kernel(inline=True)
def bounces_in_space(
    height: FloatArray | None, balls: Balls, laws: Laws, i: int, cushion: int
) -> bool:
    """Bounce ball i off a nose, where balls may fly.

    Off one alone: in a corner, the first may lift the ball away from the second. Where it doesn't,
    the ball still approaches that, which is an event of its own.
    """
    if height is None:
        return False
    if not laws.airborne:
        return False
    bounce_off_nose(height, balls, i, cushion, laws)
    return True


@kernel(inline=True)
def is_hop(height: FloatArray | None, balls: Balls, laws: Laws, t: float) -> bool:
    """Whether the pair that touches at t [s], the first of `balls.hits`, is one ball on another."""
    if height is None:
        return False
    return lies_on(height, balls, balls.hits[0, FIRST], balls.hits[0, SECOND], laws, t)


@kernel
def touches_more(balls: Balls, cells: Cells | None, t: float) -> bool:
    """Whether one of the first pair of `balls.hits`, on the cloth, touches anything there."""
    a, b = int(balls.hits[0, FIRST]), int(balls.hits[0, SECOND])
    count = list_touching(balls, cells, a, t, 0, False)
    count = list_touching(balls, cells, b, t, count, False)
    balls.hits[0, FIRST], balls.hits[0, SECOND] = a, b
    return count > 0


@kernel(inline=True)
def press_below(
    height: FloatArray | None,
    balls: Balls,
    laws: Laws,
    cells: Cells | None,
    t: float,
) -> int:
    """List what the hop of the first pair of `balls.hits` presses together; return how many."""
    if height is None:
        return 0
    a, b = int(balls.hits[0, FIRST]), int(balls.hits[0, SECOND])
    load(height, balls, laws, a, b, t)
    count = list_touching(balls, cells, a, t, 0, True)
    count = list_touching(balls, cells, b, t, count, True)
    share_loads(height, balls, count, t)
    return count


@kernel(inline=True)
def share_loads(height: FloatArray | None, balls: Balls, count: int, t: float) -> None:
    """Note that what loads a ball at t [s] loads all that it touches in `balls.hits`."""
    if height is not None:
        for c in range(count):
            i, j = balls.hits[c, FIRST], balls.hits[c, SECOND]
            if j >= 0 and one_is_loaded(height, i, j, t):
                share_load(height, i, j)


@kernel(inline=True)
def note_held(
    height: FloatArray | None,
    balls: Balls,
    contacts: Contacts | None,
    count: int,
    t: float,
    log: Log,
) -> None:
    """Log which balls of the first `count` pairs of `balls.hits` came to rest on others."""
    if height is not None:
        for c in range(count):
            for end in (FIRST, SECOND):
                _note_held(height, balls, contacts, int(balls.hits[c, end]), t, log)


@kernel(inline=True)
def _note_held(
    height: FloatArray, balls: Balls, contacts: Contacts | None, i: int, t: float, log: Log
) -> None:
    """Log that ball i came to rest on others, if that is what happened."""
    if balls.state[i].phase == FLYING and height[i, HELD] == 1.0:
        note_rest(balls, contacts, i, t, log)
