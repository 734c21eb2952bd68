"""Contacts of balls that push each other at the same time: their list, their forces, their gaps.

The rows of `Contacts.compressed` describe the balls of a cluster, the rows of `Contacts.columns`
their contacts; `impacts.compliant` integrates the motion by these forces.
"""

from __future__ import annotations

import math

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.state import FloatArray, Laws, World
from ghostball.engine.impacts.hertz import push, stiffness
from ghostball.engine.impacts.laws.friction_curve import alciatore_friction
from ghostball.engine.motion.geometry import reduced_mass
from ghostball.engine.motion.obstacles import facing, nose_reach

LYING = 1e-12
"""Gap or overlap [m] of balls that lie against each other without a force."""

# Columns of `Contacts.compressed`: the state at a stage, at the start of the step or the end of the
# leg, sums of slopes, and slopes, STATE numbers each.
STATE = 7
NOW_X = 0
NOW_Y = 1
NOW_VX = 2
NOW_VY = 3
NOW_WX = 4
NOW_WY = 5
NOW_WZ = 6
FROM = 7
SUM = 14
SLOPE = 21  # rates of change of the numbers from NOW at this stage
SLOPE_VX = 23
SLOPE_VY = 24
SLOPE_WX = 25
SLOPE_WY = 26
SLOPE_WZ = 27
FIRST_SLOPE = 28  # the same at the start of the step
INVERSE_MASS = 35  # [1/kg]
TURN = 36  # 5 / (2 m R) [1/(kg m)]
RADIUS = 37  # [m]
IS_TOUCHED = 38  # 1: a contact acts on the ball in this leg
# The rest is kept from leg to leg.
SPEED = 39  # fastest approach in the cluster so far [m/s]
PHASE = 40  # phase of the ball when it joined the cluster; SLIDING once it was touched
HELD_AT = 41  # obstacles that the ball has bounced off in this cluster, a bit each
REACHED = 42  # 1 plus the row of an obstacle that it reaches at the end of the leg; 0: none
ENDS = 43  # 1: the cluster ends with the leg
MEETS = 44  # number of balls that it begins to touch at the end of the leg, then their indices
MOST_MEETINGS = 6

# Columns of `Contacts.columns` for the contacts of a cluster.
REACH = 0  # distance of the centres, or of a ball from an obstacle, where they touch [m]
STIFFNESS = 1  # [N/m^1.5]
ENERGY = 2  # 4/5 of STIFFNESS over the reduced mass
CONTACT = 3  # APART ...
NORMAL_X = 4  # of an obstacle that holds the ball, into the table
NORMAL_Y = 5
CONTACT_NUMBERS = 6

APART = 0.0
TOUCHING = 1.0
LIES = 2.0  # the balls lie against each other without a force
BEGINS = 3.0  # the contact begins at the end of this leg
HOLDS = 4.0  # an obstacle that holds the ball


@kernel
def list_contact(world: World, count: int, a: int, b: int, apart: float) -> int:
    """Add the contact of ball a with b to `contacts.ends` if the gap is below `apart` [m].

    b is a ball, or -1 minus the row of an obstacle. Return the number of contacts now; if there is
    no room, NO_ROOM is set.
    """
    balls, contacts, laws = world.balls, world.contacts, world.laws
    rows, columns = contacts.compressed, contacts.columns
    if b >= 0:
        dx = rows[b, FROM] - rows[a, FROM]
        dy = rows[b, FROM + 1] - rows[a, FROM + 1]
        reach = rows[a, RADIUS] + rows[b, RADIUS]
        limit = reach + apart
        square = dx * dx + dy * dy
        if square > limit * limit:
            return count
        gap = math.sqrt(square) - reach
    else:
        row = -1 - b
        nx, ny, away = facing(laws, row, rows[a, FROM], rows[a, FROM + 1])
        reach = nose_reach(balls, a, laws, row)
        gap = away - reach
        if gap > apart:
            return count
    if count == len(contacts.ends):
        balls.counters[st.NO_ROOM] = 1
        return count
    contacts.ends[count, st.FIRST], contacts.ends[count, st.SECOND] = a, b
    columns[count, REACH] = reach
    if b >= 0:
        stiff = stiffness(laws.contact_modulus, rows[a, RADIUS], rows[b, RADIUS])
        mass = reduced_mass(balls.state[a].mass, balls.state[b].mass)
        columns[count, STIFFNESS] = stiff
        columns[count, ENERGY] = 0.8 * (stiff / mass)
        columns[count, CONTACT] = APART if gap > LYING else LIES if gap >= -LYING else TOUCHING
    else:
        held = (int(rows[a, HELD_AT]) >> row) & 1 == 1 and gap <= LYING
        held = held and nx * rows[a, FROM + 2] + ny * rows[a, FROM + 3] <= 0.0
        columns[count, CONTACT] = HOLDS if held else APART
        columns[count, NORMAL_X], columns[count, NORMAL_Y] = nx, ny
    return count + 1


@kernel
def put_apart_last(world: World, count: int) -> int:
    """Move the contacts that are APART to the end; return how many precede them.

    A leg ends where a contact begins. So during a leg, only the contacts before them have forces.
    """
    columns, ends = world.contacts.columns, world.contacts.ends
    others = 0
    for c in range(count):
        if columns[c, CONTACT] == APART:
            continue
        for n in range(2):
            ends[c, n], ends[others, n] = ends[others, n], ends[c, n]
        for n in range(CONTACT_NUMBERS):
            columns[c, n], columns[others, n] = columns[others, n], columns[c, n]
        others += 1
    return others


@kernel
def put_free_last(world: World, members: int, active: int) -> int:
    """Move the members without an active contact to the end; return how many precede them.

    Without a contact, a ball moves straight during a leg.
    """
    contacts = world.contacts
    rows, member = contacts.compressed, contacts.member
    for m in range(members):
        rows[member[m], IS_TOUCHED] = 0.0
    for c in range(active):
        a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
        rows[a, IS_TOUCHED] = 1.0
        if b >= 0:
            rows[b, IS_TOUCHED] = 1.0
    others = 0
    for m in range(members):
        if rows[member[m], IS_TOUCHED] == 1.0:
            member[m], member[others] = member[others], member[m]
            others += 1
    return others


@kernel
def find_slopes(world: World, members: int, count: int, slip: float) -> None:
    """Set the slopes of all members by the first `count` contacts, in the present state."""
    contacts, laws = world.contacts, world.laws
    rows, columns, ends = contacts.compressed, contacts.columns, contacts.ends
    for m in range(members):
        k = contacts.member[m]
        for n in range(STATE):
            rows[k, SLOPE + n] = rows[k, NOW_VX + n] if n < 2 else 0.0
    rubs = laws.slides and (laws.speed_dependent or laws.ball_friction > 0.0)
    loss = laws.contact_loss
    holds = False
    for c in range(count):
        a, b = ends[c, st.FIRST], ends[c, st.SECOND]
        if b < 0:
            holds = holds or columns[c, CONTACT] == HOLDS
            continue
        dx, dy = rows[b, NOW_X] - rows[a, NOW_X], rows[b, NOW_Y] - rows[a, NOW_Y]
        reach = columns[c, REACH]
        square = dx * dx + dy * dy
        if square >= reach * reach:
            continue
        distance = math.sqrt(square)
        over = 1.0 / distance
        nx, ny = over * dx, over * dy
        vx, vy = rows[a, NOW_VX] - rows[b, NOW_VX], rows[a, NOW_VY] - rows[b, NOW_VY]
        force = push(
            reach - distance, vx * nx + vy * ny, columns[c, STIFFNESS], columns[c, ENERGY], loss
        )
        px, py = -force * nx, -force * ny
        if rubs:
            # The contact is nearer to the centres than the radii while the balls are pressed.
            lever = distance / reach
            along, up = _friction(rows, laws, a, b, nx, ny, vx, vy, lever, force, slip)
            px, py = px - along * ny, py + along * nx
            for k in (a, b):
                turn = lever * rows[k, TURN]
                rows[k, SLOPE_WX] += turn * (up * ny)
                rows[k, SLOPE_WY] -= turn * (up * nx)
                rows[k, SLOPE_WZ] += turn * along
        rows[a, SLOPE_VX] += rows[a, INVERSE_MASS] * px
        rows[a, SLOPE_VY] += rows[a, INVERSE_MASS] * py
        rows[b, SLOPE_VX] -= rows[b, INVERSE_MASS] * px
        rows[b, SLOPE_VY] -= rows[b, INVERSE_MASS] * py
        rows[a, IS_TOUCHED] = 1.0
        rows[b, IS_TOUCHED] = 1.0
    if holds:
        _hold_at_obstacles(world, count)


@kernel(inline=True)
def _friction(
    rows: FloatArray,
    laws: Laws,
    a: int,
    b: int,
    nx: float,
    ny: float,
    vx: float,
    vy: float,
    lever: float,
    force: float,
    slip: float,
) -> tuple[float, float]:
    """Return the friction [N] on ball a: along t = (-ny, nx), and up.

    `lever`: distance of the contact from the centres, in radii.
    """
    ra, rb = lever * rows[a, RADIUS], lever * rows[b, RADIUS]
    along = nx * vy - ny * vx + (ra * rows[a, NOW_WZ] + rb * rows[b, NOW_WZ])
    wx = ra * rows[a, NOW_WX] + rb * rows[b, NOW_WX]
    wy = ra * rows[a, NOW_WY] + rb * rows[b, NOW_WY]
    up = ny * wx - nx * wy
    square = along * along + up * up
    friction = laws.ball_friction
    if laws.speed_dependent:
        friction = alciatore_friction(math.sqrt(square))
    part = friction * force / math.sqrt(square + slip * slip)
    return -part * along, -part * up


@kernel
def _hold_at_obstacles(world: World, count: int) -> None:
    """Let no ball accelerate into an obstacle that holds it."""
    contacts = world.contacts
    rows, columns = contacts.compressed, contacts.columns
    for c in range(count):
        if contacts.ends[c, st.SECOND] < 0 and columns[c, CONTACT] == HOLDS:
            a = contacts.ends[c, st.FIRST]
            nx, ny = columns[c, NORMAL_X], columns[c, NORMAL_Y]
            into = nx * rows[a, SLOPE_VX] + ny * rows[a, SLOPE_VY]
            if into < 0.0:
                rows[a, SLOPE_VX] -= into * nx
                rows[a, SLOPE_VY] -= into * ny


@kernel
def gap_of(world: World, c: int, at: int) -> tuple[float, float]:
    """Return the gap [m] of contact c, and its rate of change [m/s].

    `at`: NOW_X for the present state, FROM for the state at the start of the step.
    """
    contacts = world.contacts
    rows, reach = contacts.compressed, contacts.columns[c, REACH]
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    x, y, vx, vy = rows[a, at], rows[a, at + 1], rows[a, at + 2], rows[a, at + 3]
    if b < 0:
        nx, ny, away = facing(world.laws, -1 - b, x, y)
        return away - reach, nx * vx + ny * vy
    dx, dy = rows[b, at] - x, rows[b, at + 1] - y
    vx, vy = rows[b, at + 2] - vx, rows[b, at + 3] - vy
    distance = math.sqrt(dx * dx + dy * dy)
    return distance - reach, (dx * vx + dy * vy) / distance


@kernel
def is_changed(world: World, count: int) -> bool:
    """Return whether, in the present state, some contact may have begun or ended."""
    contacts = world.contacts
    rows, columns, ends = contacts.compressed, contacts.columns, contacts.ends
    for c in range(count):
        a, b, contact = ends[c, st.FIRST], ends[c, st.SECOND], columns[c, CONTACT]
        if b < 0:
            gap, _ = gap_of(world, c, NOW_X)
            if (gap < 0.0) != (contact == HOLDS):
                return True
            continue
        dx, dy = rows[b, NOW_X] - rows[a, NOW_X], rows[b, NOW_Y] - rows[a, NOW_Y]
        overlaps = dx * dx + dy * dy < columns[c, REACH] * columns[c, REACH]
        if overlaps != (contact == TOUCHING):
            return True
    return False
