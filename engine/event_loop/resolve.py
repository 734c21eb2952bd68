"""Resolve an event: balls collide, reach an obstacle, land, start to roll, or stop.

`event_loop.find` has found the event; `impacts` has the effect of an impact. Code that changes a
ball's motion marks the ball in `balls.changed`; the loop then predicts it. A `cushion` here is any
row of `Laws.obstacles`.
"""

from __future__ import annotations

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import Balls, Laws, World
from ghostball.engine.event_loop.compression import begin_cluster, end_leg
from ghostball.engine.event_loop.in_flight import (
    collide_pair,
    fall_into,
    is_slow_impact,
    list_below,
    note_held,
    resolve_flight,
    share_loads,
)
from ghostball.engine.event_loop.obstacle_names import name_of_obstacle
from ghostball.engine.event_loop.record import (
    BALL_BALL_EVENT,
    BALL_CUSHION_EVENT,
    SLIDE_TO_ROLL_EVENT,
    note_event,
    note_rest,
)
from ghostball.engine.impacts.impact import (
    bounce,
    bounce_in_corner,
    contact_normal,
    has_collapsed,
)
from ghostball.engine.impacts.in_space import bounce_off_nose, fastest_nose
from ghostball.engine.impacts.on_table import end_bounces
from ghostball.engine.impacts.simultaneous import collide_together
from ghostball.engine.motion.flight import meets_in_space
from ghostball.engine.motion.frame import only_cushion
from ghostball.engine.motion.geometry import (
    approach_rounding,
    blocking_ball,
    capture_height,
    contact_tolerance,
    negligible_bounce,
    rounding_of,
    speed_of,
    tie_rounding,
)
from ghostball.engine.motion.next_piece import come_to_rest, mark, start_rolling
from ghostball.engine.motion.obstacles import facing, nose_reach, turning
from ghostball.engine.motion.position import advance
from ghostball.engine.resting_contact.collapse import end_collapse
from ghostball.engine.resting_contact.step import end_step
from ghostball.engine.scheduling.due_pairs import Event
from ghostball.engine.scheduling.ties import list_pair
from ghostball.engine.scheduling.time_of_impact import LASTING

_NO_CORNER = 1.0 - 2.0**-20
"""Cosine between the normals of two obstacles above which they count as one straight obstacle."""

_BOUNCES_AN_EVENT = 16
"""Number of bounces in a corner that count as one event in the limit of events at one time."""


@kernel(inline=True)
def advance_to(world: World, event: Event) -> None:
    """Move the balls of an event to its time, except pairs that will be held together.

    A ball that stops, or stops sliding, is moved by a formula that cancels no digits.
    """
    balls, laws = world.balls, world.laws
    ball, t = event.ball, event.t
    if ball < 0:
        if event.verdict != LASTING:
            for c in range(event.pairs):
                advance(balls, balls.touching[c, st.FIRST], t)
                advance(balls, balls.touching[c, st.SECOND], t)
        return
    kind = balls.own_kind[ball]
    if kind == st.OWN_REST:
        come_to_rest(balls, laws, ball, t)
    elif kind == st.OWN_ROLL:
        start_rolling(balls, laws, ball, t)
    elif balls.height is not None and kind == st.OWN_BOUNCES_END:
        end_bounces(balls.height, balls, ball, t)
    elif kind >= st.OWN_PIECE:
        advance(balls, ball, t)


@kernel(inline=True)
def resolve(world: World, event: Event) -> int:
    """Resolve an event whose balls are at its time; mark every ball whose motion it changes.

    Return the number of contacts in `balls.touching` that must be held.
    """
    if event.ball < 0:
        return _resolve_contacts(world, event)
    return _resolve_own(world, event.ball, event.t)


@kernel(inline=True)
def _resolve_own(world: World, i: int, t: float) -> int:
    """Resolve ball i's own event at the time t: rest, roll, an obstacle, or the end of a step.

    Return the number of contacts in `balls.touching` that must be held.
    """
    balls, contacts, log = world.balls, world.contacts, world.log
    kind = balls.own_kind[i]
    if resolve_flight(world, i, kind, t):
        return 0
    if kind == st.OWN_REST:
        # All members of an island that stop now are moved now. Later, a second member would move
        # with the remainder of its speed that rounding leaves.
        k = contacts.ring[i]
        while k != i:
            if balls.own_kind[k] == st.OWN_REST and balls.state[k].own_time <= t:
                come_to_rest(balls, world.laws, k, t)
                note_rest(world, k, t)
                mark(balls, k)
            k = contacts.ring[k]
        note_rest(world, i, t)
        mark(balls, i)
    elif kind == st.OWN_ROLL:
        if balls.state[i].vx == 0.0 and balls.state[i].vy == 0.0:
            note_rest(world, i, t)
        else:
            note_event(SLIDE_TO_ROLL_EVENT, i, -1, t, log)
        mark(balls, i)
    elif kind == st.OWN_PIECE:
        mark(balls, i)
    elif kind >= st.OWN_CUSHION:
        cushion = kind - st.OWN_CUSHION
        if world.laws.obstacles[cushion].law == st.TAKES_OUT:
            fall_into(world, i, cushion, t)
            mark(balls, i)
            return 0
        partner = _held_against(world, i, cushion, t)
        if partner != i:
            balls.touching[0, st.FIRST] = i
            balls.touching[0, st.SECOND] = partner
            return 1
        held = _resolve_cushion(world, i, cushion, t)
        mark(balls, i)
        return held
    elif kind == st.OWN_LEG:
        end_leg(world, t)
    else:
        end_step(contacts, i)
    return 0


@kernel(inline=True)
def _resolve_cushion(world: World, i: int, cushion: int, t: float) -> int:
    """Bounce ball i off a cushion; in a corner off both cushions, or list both to be held.

    Return the number of contacts in `balls.touching` that must be held.
    """
    balls, laws, log = world.balls, world.laws, world.log
    other, bounces, jams = -1, 1, False
    if balls.height is not None and laws.airborne:
        # In a corner, the first bounce may lift the ball away from the second cushion. If it
        # doesn't, the ball still approaches the second cushion, which causes a separate event.
        cushion = fastest_nose(balls.height, balls, i, cushion, laws)
    else:
        other = _corner_cushion(balls, laws, i, cushion, t)
    if other >= 0:
        bounces, jams = bounce_in_corner(balls, i, cushion, other, laws)
        log.counters[st.JOINT_IMPACTS] += 1
        log.counters[st.AT_ONCE] += bounces // _BOUNCES_AN_EVENT
    log.counters[st.BALL_CUSHION] += bounces
    for turn in range(bounces):
        off = cushion if turn % 2 == 0 else other
        note_event(BALL_CUSHION_EVENT, i, name_of_obstacle(balls, laws, i, off), t, log)
    if balls.height is not None and laws.airborne:
        bounce_off_nose(balls.height, balls, i, cushion, laws)
    elif other < 0:
        bounce(balls, i, cushion, laws)
    balls.state[i].impacts += 1.0
    if jams:
        for row, wall in enumerate((cushion, other)):
            balls.touching[row, st.FIRST] = i
            balls.touching[row, st.SECOND] = -1 - wall
        return 2
    return 0


@kernel(inline=True)
def _corner_cushion(balls: Balls, laws: Laws, i: int, cushion: int, t: float) -> int:
    """Return another obstacle that ball i touches at the same time as the given one, or -1.

    The ball approaches both, or the bounce off the given obstacle throws it towards the other one.
    """
    ball = balls.state[i]
    ox, oy, _ = facing(laws, cushion, ball.x, ball.y)
    alone = only_cushion(laws, cushion, ball.x, ball.y, 2.0 * ball.radius)
    for other in range(laws.outer if alone else len(laws.obstacles)):
        nx, ny, distance = facing(laws, other, ball.x, ball.y)
        same = nx * ox + ny * oy
        meets = nx * ball.vx + ny * ball.vy < 0.0 or same < 0.0
        if other == cushion or not meets or same > _NO_CORNER:
            continue
        met = distance - nose_reach(balls, i, laws, other) <= tie_rounding(balls, i, i, t)
        if met and laws.obstacles[other].law != st.TAKES_OUT:
            return other
    return -1


@kernel(inline=True)
def _held_against(world: World, i: int, cushion: int, t: float) -> int:
    """Return the body against which ball i is held, if a bounce wouldn't take it off the cushion.

    The result is the cushion (-1 minus its row) if friction drives the ball into it, or a ball that
    blocks the way. If nothing holds the ball, the result is i.
    """
    balls = world.balls
    ball = balls.state[i]
    nx, ny, _ = facing(world.laws, cushion, ball.x, ball.y)
    rate, along = nx * ball.vx + ny * ball.vy, nx * ball.vy - ny * ball.vx
    opening = nx * ball.ax + ny * ball.ay
    # A round obstacle recedes from a ball that moves along it, so a bounce rises higher. If it
    # recedes faster than friction drives the ball, a resting contact would end immediately.
    recedes = turning(world.laws, cushion, ball.x, ball.y) * along * along
    opening += recedes if opening + recedes < 0.0 else 0.0
    height = capture_height(balls, i, i)
    if opening < 0.0 and negligible_bounce(rate, -opening, height):
        if _bounces_across(balls, world.laws, i, nx, ny, -opening):
            return i
        return -1 - cushion
    pull = ball.slide_slowing if ball.phase == st.SLIDING else ball.roll_slowing
    if not negligible_bounce(rate, 2.0 * pull, contact_tolerance(balls, i, i)):
        return i
    blocking = blocking_ball(world, i, nx, ny, t)
    return blocking if blocking >= 0 else i


@kernel
def _bounces_across(balls: Balls, laws: Laws, i: int, nx: float, ny: float, pull: float) -> bool:
    """Return whether ball i, moving into a wedge, bounces back and forth between its two sides.

    (nx, ny) is the normal of the side that it hits. If the gap to the other side is below the
    height of a bounce that isn't followed (`CAPTURE_HEIGHT`), the bounces must be followed: they
    can turn the ball back out of the wedge.
    """
    ball, height = balls.state[i], capture_height(balls, i, i)
    speed, rate = speed_of(ball.vx, ball.vy), nx * ball.vx + ny * ball.vy
    if abs(rate) <= rounding_of(speed) or negligible_bounce(speed, pull, height):
        return False
    along_x, along_y = ball.vx - rate * nx, ball.vy - rate * ny
    for other in range(len(laws.obstacles)):
        ox, oy, distance = facing(laws, other, ball.x, ball.y)
        near = distance - nose_reach(balls, i, laws, other) <= height
        into = nx * ox + ny * oy < 0.0 and along_x * ox + along_y * oy < 0.0
        if near and into and laws.obstacles[other].law != st.TAKES_OUT:
            return True
    return False


@kernel(inline=True)
def _resolve_contacts(world: World, event: Event) -> int:
    """Collide the pairs of `balls.touching` that touch now, or leave them to be held.

    A pair whose balls have no other impact now follows the scene's law; other pairs collide
    together. Return the number of contacts in `balls.touching` that must be held.
    """
    balls, log = world.balls, world.log
    count, t = event.pairs, event.t
    is_slow = event.verdict != LASTING and count == 1
    is_slow = is_slow and is_slow_impact(balls, world.laws, t)
    log.counters[st.ADVANCEMENTS] += event.judged
    if event.verdict == LASTING:
        share_loads(balls, count, t)
        return count
    for c in range(count):
        a, b = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]
        mark(balls, a)
        mark(balls, b)
        log.counters[st.BALL_BALL] += 1
        note_event(BALL_BALL_EVENT, a, b, t, log)
    left = count
    if world.laws.ball_restitution < 1.0:
        left = _end_collapses(world, count, t)
    for c in range(count):
        balls.state[balls.touching[c, st.FIRST]].impacts += 1.0
        balls.state[balls.touching[c, st.SECOND]].impacts += 1.0
    if world.laws.compliant:
        left = begin_cluster(world, left, t)
    if left == 1:
        collide_pair(world, balls.touching[0, st.FIRST], balls.touching[0, st.SECOND])
    else:
        _collide_groups(world, left)
    note_held(world, count, t)
    return list_below(world, t) if is_slow else 0


@kernel
def _collapses(world: World, c: int) -> bool:
    """Return whether pair c of `balls.touching`, on the cloth, must not rebound any more."""
    balls, laws = world.balls, world.laws
    a, b = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]
    if meets_in_space(balls, a, b):
        return False
    return has_collapsed(balls, a, laws) or has_collapsed(balls, b, laws)


@kernel
def _end_collapses(world: World, count: int, t: float) -> int:
    """End the collapses among the first `count` pairs of `balls.touching`.

    Return the number of pairs that still approach, and move them to the start of `balls.touching`.
    """
    balls = world.balls
    has_ended = False
    for c in range(count):
        if _collapses(world, c) and _approaches(balls, c, t):
            end_collapse(world, balls.touching[c, st.FIRST], t)
            has_ended = True
    if not has_ended:
        return count
    left = 0
    for c in range(count):
        if _approaches(balls, c, t):
            a, b = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]
            list_pair(balls, c, balls.touching[left, st.FIRST], balls.touching[left, st.SECOND])
            list_pair(balls, left, a, b)
            left += 1
    return left


@kernel
def _approaches(balls: Balls, c: int, t: float) -> bool:
    """Return whether pair c of `balls.touching` still approaches; True for pairs in flight."""
    a, b = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]
    if meets_in_space(balls, a, b):
        return True
    nx, ny = contact_normal(balls, a, b)
    vx, vy = balls.state[b].vx - balls.state[a].vx, balls.state[b].vy - balls.state[a].vy
    return bool(nx * vx + ny * vy < -approach_rounding(balls, a, b, t))


@kernel
def _collide_groups(world: World, count: int) -> None:
    """Collide the first `count` pairs of `balls.touching`; pairs that share balls, together."""
    balls, contacts = world.balls, world.contacts
    for c in range(count):
        contacts.motion[balls.touching[c, st.FIRST]].degree += 1.0
        contacts.motion[balls.touching[c, st.SECOND]].degree += 1.0
    joint = 0
    for c in range(count):
        a, b = balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]
        if contacts.motion[a].degree == 1.0 and contacts.motion[b].degree == 1.0:
            collide_pair(world, a, b)
            contacts.motion[a].degree = 0.0
            contacts.motion[b].degree = 0.0
        else:
            contacts.ends[joint, st.FIRST] = a
            contacts.ends[joint, st.SECOND] = b
            joint += 1
    if joint > 0:
        world.log.counters[st.JOINT_IMPACTS] += 1
        if not collide_together(world, joint):
            world.log.counters[st.UNSOLVED_JOINT_IMPACTS] += 1
    for c in range(count):
        contacts.motion[balls.touching[c, st.FIRST]].degree = 0.0
        contacts.motion[balls.touching[c, st.SECOND]].degree = 0.0
