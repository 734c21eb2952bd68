"""Clusters of balls that push each other: when one begins, its legs, and when it ends.

Two balls that collide form a cluster if a third ball is near: nearer to one of them than `_NEAR`
times the depth of their impact. With a larger gap, the first impact is over before the next one
begins. `impacts.compliant` integrates a leg of the cluster's motion; between its legs, the balls
and obstacles near the cluster are gathered again. The cluster ends when no two of its balls touch;
then the event loop goes on from that state.

In the log, a ball of a cluster moves along a straight line from its position at the start of a leg
to its position at the end. The schedulers ignore the ball during the leg, because all balls and
obstacles that it could meet are part of the cluster. Each contact that begins is an event of two
balls, at the end of the leg.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import World
from ghostball.engine.core.tolerances import EPS
from ghostball.engine.event_loop.in_flight import fall_into
from ghostball.engine.event_loop.obstacle_names import name_of_obstacle
from ghostball.engine.event_loop.record import BALL_BALL_EVENT, BALL_CUSHION_EVENT, note_event
from ghostball.engine.impacts.compliant import LEG_STEPS, STEPS, rub_on_cloth, run_leg, step_of
from ghostball.engine.impacts.hertz import CONTACT_TIME, deepest_overlap, stiffness
from ghostball.engine.impacts.impact import bounce
from ghostball.engine.impacts.lasting_contacts import (
    BEGINS,
    CONTACT,
    ENDS,
    FROM,
    HELD_AT,
    INVERSE_MASS,
    IS_TOUCHED,
    MEETS,
    MOST_MEETINGS,
    PHASE,
    RADIUS,
    REACHED,
    SPEED,
    TOUCHING,
    TURN,
    list_contact,
)
from ghostball.engine.motion.geometry import list_near, reduced_mass
from ghostball.engine.motion.next_piece import mark
from ghostball.engine.motion.obstacles import facing
from ghostball.engine.motion.position import (
    advance,
    impacts_after,
    position_at,
    slowed_spin,
    straighten,
    velocity,
)
from ghostball.engine.resting_contact.islands import release

_NEAR = 1.5
"""Gap to a third ball, in depths of the impact, above which the impacts are separate.

`tests/engine/impacts/test_compliant.py` compares three balls in a row with SciPy's integration.
"""

_REACH = CONTACT_TIME * LEG_STEPS / STEPS
"""Duration of the longest leg, in units of the depth of an impact over its speed."""


@kernel
def begin_cluster(world: World, count: int, t: float) -> int:
    """Begin a cluster with the first `count` pairs of `balls.touching`, which collide at t [s].

    Return how many pairs are left to be resolved as rigid impacts: none, or all if no third ball is
    near any of them.
    """
    balls, rows = world.balls, world.contacts.compressed
    is_near = False
    for c in range(count):
        a, b = int(balls.touching[c, st.FIRST]), int(balls.touching[c, st.SECOND])
        is_near = is_near or _has_third(world, a, b, t)
    if not is_near:
        return count
    world.log.counters[st.CLUSTERS] += 1
    members, fastest = 0, 0.0
    for c in range(count):
        a, b = int(balls.touching[c, st.FIRST]), int(balls.touching[c, st.SECOND])
        fastest = max(fastest, _approach_speed(world, a, b))
        for k in (a, b):
            if balls.own_kind[k] != st.OWN_LEG:
                members = _join(world, members, k, t)
    for m in range(members):
        rows[world.contacts.member[m], SPEED] = fastest
    _begin_leg(world, members, t, count)
    return 0


@kernel
def _has_third(world: World, a: int, b: int, t: float) -> bool:
    """Return whether a third ball is near balls a and b, so that several contacts last at once."""
    balls = world.balls
    depth = _depth(world, a, b, _approach_speed(world, a, b))
    for i in (a, b):
        near = list_near(balls, world.cells, i)
        balls.counters[st.WORK] += 1 + near // 4
        for c in range(near):
            j = int(balls.near[c])
            if j in (a, b) or balls.state[j].phase == st.GONE:
                continue
            x, y = position_at(balls, j, t)
            dx, dy = x - balls.state[i].x, y - balls.state[i].y
            limit = balls.state[i].radius + balls.state[j].radius + _NEAR * depth
            if dx * dx + dy * dy < limit * limit:
                return True
    return False


@kernel
def _approach_speed(world: World, a: int, b: int) -> float:
    """Return the approach speed [m/s] of two balls that are advanced to their impact."""
    first, second = world.balls.state[a], world.balls.state[b]
    dx, dy = second.x - first.x, second.y - first.y
    vx, vy = first.vx - second.vx, first.vy - second.vy
    speed: float = (dx * vx + dy * vy) / math.sqrt(dx * dx + dy * dy)
    return speed


@kernel
def _depth(world: World, a: int, b: int, speed: float) -> float:
    """Return the depth [m] of an impact of balls a and b alone at `speed` [m/s]."""
    first, second = world.balls.state[a], world.balls.state[b]
    stiff = stiffness(world.laws.contact_modulus, first.radius, second.radius)
    depth: float = deepest_overlap(speed, stiff, reduced_mass(first.mass, second.mass))
    return depth


@kernel
def _join(world: World, members: int, k: int, t: float) -> int:
    """Make ball k a member of the cluster: its state at t [s] goes to `contacts.compressed`.

    Return the number of members in `contacts.member` now.
    """
    balls, contacts = world.balls, world.contacts
    release(world, k, t)
    contacts.again[k] = False
    advance(balls, k, t)
    mark(balls, k)
    ball, row = balls.state[k], contacts.compressed[k]
    if ball.phase != st.SLIDING:
        ball.wx, ball.wy = -ball.vy / ball.radius, ball.vx / ball.radius
    row[FROM], row[FROM + 1] = ball.x, ball.y
    row[FROM + 2], row[FROM + 3] = ball.vx, ball.vy
    row[FROM + 4], row[FROM + 5], row[FROM + 6] = ball.wx, ball.wy, ball.wz
    row[INVERSE_MASS], row[RADIUS] = 1.0 / ball.mass, ball.radius
    row[TURN] = 2.5 / (ball.mass * ball.radius)
    row[PHASE], row[SPEED] = ball.phase, 0.0
    row[HELD_AT], row[REACHED], row[ENDS], row[MEETS] = 0.0, 0.0, 0.0, 0.0
    balls.own_kind[k] = st.OWN_LEG
    ball.phase = st.GONE
    ball.own_time = t
    contacts.member[members] = k
    return members + 1


@kernel
def _begin_leg(world: World, members: int, t: float, touching: int) -> None:
    """Integrate the next leg from t [s] of the first members in `contacts.member`; set the pieces.

    The first `touching` pairs of `balls.touching` begin to touch at t.
    """
    balls, contacts, laws = world.balls, world.contacts, world.laws
    rows = contacts.compressed
    world.log.counters[st.CLUSTER_LEGS] += 1
    members, fastest = _gather(world, members, t)
    first = int(contacts.member[0])
    pairs = _list_contacts(world, members, _longest_leg(world, first, fastest))
    for c in range(touching):
        for d in range(pairs):
            if _is_pair(world, d, balls.touching[c, st.FIRST], balls.touching[c, st.SECOND]):
                contacts.columns[d, CONTACT] = TOUCHING
    step = _longest_leg(world, first, fastest) / LEG_STEPS
    step = min(step, step_of(world, pairs, fastest))
    # If a cluster begins during the leg of another cluster, both legs end together.
    steps, latest = LEG_STEPS, _end_of_others(world, t)
    if latest - t < LEG_STEPS * step:
        steps = 1 + int((latest - t) / step)
        step = (latest - t) / steps
    lasted = run_leg(world, members, pairs, step, steps)
    end, touches = t + lasted, False
    if latest - t < lasted * (1.0 + EPS * 2.0**10):
        end = latest
    for c in range(pairs):
        a, b = int(contacts.ends[c, st.FIRST]), int(contacts.ends[c, st.SECOND])
        if b >= 0 and contacts.columns[c, CONTACT] == BEGINS:
            _note_meeting(world, a, b)
        if b >= 0 and contacts.columns[c, CONTACT] in (BEGINS, TOUCHING):
            touches = True
    for m in range(members):
        k = int(contacts.member[m])
        if rows[k, IS_TOUCHED] == 1.0:
            rows[k, PHASE] = st.SLIDING if laws.slides else st.ROLLING
            balls.state[k].moved = 1.0
        else:
            rub_on_cloth(balls, rows, laws, k, lasted)
        rows[k, ENDS] = 0.0 if touches else 1.0
        _set_piece(world, k, t, end)


@kernel
def _end_of_others(world: World, t: float) -> float:
    """Return the end [s] of a leg of balls that are in a leg at t [s], or inf."""
    balls, end = world.balls, math.inf
    for k in range(len(balls.own_kind)):
        if balls.own_kind[k] == st.OWN_LEG and balls.state[k].own_time > t:
            end = min(end, balls.state[k].own_time)
    balls.counters[st.WORK] += 1 + len(balls.own_kind) // 8
    return end


@kernel
def _longest_leg(world: World, k: int, speed: float) -> float:
    """Return the duration [s] of the longest leg, for balls like ball k and a fastest speed."""
    return _REACH * (_depth(world, k, k, speed) / speed)


@kernel
def _set_piece(world: World, k: int, t: float, end: float) -> None:
    """Let ball k move straight, and turn uniformly, from its state at t to that at `end` [s]."""
    balls, row = world.balls, world.contacts.compressed[k]
    ball, lasts = balls.state[k], end - t
    over = 1.0 / lasts if lasts > 0.0 else 0.0
    straighten(balls, k)
    ball.epoch, ball.own_time = t, end
    ball.vx, ball.vy = over * (row[FROM] - ball.x), over * (row[FROM + 1] - ball.y)
    ball.ax, ball.ay = 0.0, 0.0
    ball.bx, ball.by = over * (row[FROM + 4] - ball.wx), over * (row[FROM + 5] - ball.wy)
    left = slowed_spin(ball.wz, ball.spin_slowing * lasts)
    ball.bz = over * (row[FROM + 6] - left)
    mark(balls, k)


@kernel
def _note_meeting(world: World, a: int, b: int) -> None:
    """Store that balls a and b begin to touch at the end of the leg.

    The row of a ball has room for a few balls. If both rows are full, set NO_ROOM: no collision is
    left out of the counts.
    """
    rows = world.contacts.compressed
    if rows[a, MEETS] == MOST_MEETINGS:
        a, b = b, a
    meets = int(rows[a, MEETS])
    if meets == MOST_MEETINGS:
        world.balls.counters[st.NO_ROOM] = 1
        return
    rows[a, MEETS + 1 + meets] = b
    rows[a, MEETS] = meets + 1


@kernel
def _is_pair(world: World, c: int, a: int, b: int) -> bool:
    ends = world.contacts.ends
    same = ends[c, st.FIRST] == a and ends[c, st.SECOND] == b
    return bool(same or (ends[c, st.FIRST] == b and ends[c, st.SECOND] == a))


@kernel
def _gather(world: World, members: int, t: float) -> tuple[int, float]:
    """Add all balls to the cluster that can meet a member during a leg from t [s] on.

    Return the number of members in `contacts.member`, and the fastest speed [m/s] so far.
    """
    balls, contacts = world.balls, world.contacts
    rows, fastest = contacts.compressed, 0.0
    for m in range(members):
        fastest = max(fastest, rows[contacts.member[m], SPEED], _speed(world, contacts.member[m]))
    first = int(contacts.member[0])
    room = _NEAR * _depth(world, first, first, fastest)
    lasts = _longest_leg(world, first, fastest)
    m = 0
    while m < members:
        i = int(contacts.member[m])
        near = list_near(balls, world.cells, i)
        balls.counters[st.WORK] += 1 + near // 4
        for c in range(near):
            j = int(balls.near[c])
            if balls.state[j].phase == st.GONE:
                continue  # a member is GONE, too
            x, y = position_at(balls, j, t)
            vx, vy = velocity(balls, j, t)
            dx, dy = x - rows[i, FROM], y - rows[i, FROM + 1]
            speed = fastest + math.sqrt(vx * vx + vy * vy)
            limit = rows[i, RADIUS] + balls.state[j].radius + room + speed * lasts
            if dx * dx + dy * dy < limit * limit:
                members = _join(world, members, j, t)
        m += 1
    for m in range(members):
        fastest = max(fastest, _speed(world, contacts.member[m]))
    for m in range(members):
        rows[contacts.member[m], SPEED] = fastest
    return members, fastest


@kernel
def _speed(world: World, k: int) -> float:
    rows = world.contacts.compressed
    vx, vy = rows[k, FROM + 2], rows[k, FROM + 3]
    return math.sqrt(vx * vx + vy * vy)


@kernel
def _list_contacts(world: World, members: int, lasts: float) -> int:
    """List all contacts of the members that may begin within `lasts` [s]; return their number."""
    contacts, laws = world.contacts, world.laws
    rows, count = contacts.compressed, 0
    apart = 2.0 * rows[contacts.member[0], SPEED] * lasts
    for m in range(members):
        i = contacts.member[m]
        for n in range(m + 1, members):
            j = contacts.member[n]
            count = list_contact(world, count, min(i, j), max(i, j), apart)
        x, y, margin = rows[i, FROM], rows[i, FROM + 1], 2.0 * rows[i, RADIUS] + apart
        inside = margin < x < laws.frame_x - margin and margin < y < laws.frame_y - margin
        for k in range(laws.outer if inside else len(laws.obstacles)):
            count = list_contact(world, count, i, -1 - k, apart)
    world.balls.counters[st.WORK] += 1 + members * members // 4
    return count


@kernel
def end_leg(world: World, t: float) -> None:
    """End the leg of all balls whose leg ends at t [s]; begin the next one, or end the cluster."""
    balls, contacts = world.balls, world.contacts
    members = 0
    for k in range(len(balls.own_kind)):
        if balls.own_kind[k] != st.OWN_LEG or balls.state[k].own_time != t:
            continue
        mark(balls, k)
        _set_state(world, k, t)
        if contacts.compressed[k, REACHED] > 0.0:
            _meet_obstacle(world, k, t)
        if balls.own_kind[k] != st.OWN_LEG:
            continue  # it has fallen into a pocket
        if contacts.compressed[k, ENDS] == 1.0:
            balls.own_kind[k] = st.OWN_NONE
            balls.state[k].phase = contacts.compressed[k, PHASE]
        else:
            contacts.member[members] = k
            members += 1
    balls.counters[st.WORK] += 1 + len(balls.own_kind) // 8
    if members > 0:
        _begin_leg(world, members, t, 0)


@kernel
def _set_state(world: World, k: int, t: float) -> None:
    """Set the state of ball k to that at the end of its leg, and log the contacts that begin."""
    balls, row = world.balls, world.contacts.compressed[k]
    ball = balls.state[k]
    ball.impacts = impacts_after(balls, k, t - ball.epoch, t)
    ball.x, ball.y, ball.vx, ball.vy = row[FROM], row[FROM + 1], row[FROM + 2], row[FROM + 3]
    ball.wx, ball.wy, ball.wz = row[FROM + 4], row[FROM + 5], row[FROM + 6]
    ball.fastest, ball.epoch, ball.bz = abs(ball.vx) + abs(ball.vy), t, 0.0
    for n in range(int(row[MEETS])):
        world.log.counters[st.BALL_BALL] += 1
        note_event(BALL_BALL_EVENT, k, int(row[MEETS + 1 + n]), t, world.log)
    row[MEETS] = 0.0


@kernel
def _meet_obstacle(world: World, k: int, t: float) -> None:
    """Let ball k bounce off the obstacle that it reaches, or fall into it.

    If ball k has bounced off the obstacle before, in the same cluster, other balls hold it there.
    """
    balls, laws = world.balls, world.laws
    row, ball = world.contacts.compressed[k], balls.state[k]
    obstacle = int(row[REACHED]) - 1
    row[REACHED] = 0.0
    if laws.obstacles[obstacle].law == st.TAKES_OUT:
        balls.own_kind[k] = st.OWN_NONE
        fall_into(world, k, obstacle, t)
        return
    held_at = int(row[HELD_AT])
    if (held_at >> obstacle) & 1 == 1:
        nx, ny, _ = facing(laws, obstacle, ball.x, ball.y)
        rate = nx * ball.vx + ny * ball.vy  # > 0 if balls push it back as soon as it has left
        ball.vx, ball.vy = ball.vx - rate * nx, ball.vy - rate * ny
    else:
        row[HELD_AT] = held_at + (1 << obstacle)
        world.log.counters[st.BALL_CUSHION] += 1
        note_event(BALL_CUSHION_EVENT, k, name_of_obstacle(balls, laws, k, obstacle), t, world.log)
        ball.phase = st.SLIDING if laws.slides else st.ROLLING
        bounce(balls, k, obstacle, laws)
        row[PHASE], ball.phase = ball.phase, st.GONE
        row[FROM + 4], row[FROM + 5], row[FROM + 6] = ball.wx, ball.wy, ball.wz
    row[FROM + 2], row[FROM + 3] = ball.vx, ball.vy
