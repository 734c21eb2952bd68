"""Paths of an island's balls while it is integrated: polynomials, and the pieces along them.

Between the ends of a step a path is the polynomial of fifth degree with the positions, velocities
and accelerations at both ends. A ball moves along it in pieces of constant acceleration. Each pair
of pieces ends with the position and the velocity of the polynomial, and pieces are short enough to
keep the gaps within their tolerance, too.
"""

from __future__ import annotations

from ghostball.engine.core import state as st
from ghostball.engine.core.kernel import kernel
from ghostball.engine.core.rows import STAGES, StageRow, column_of
from ghostball.engine.core.state import Contacts, World
from ghostball.engine.motion.geometry import at_rest, contact_tolerance
from ghostball.engine.motion.next_piece import mark, predict_obstacles
from ghostball.engine.motion.position import slowed_spin, straighten
from ghostball.engine.resting_contact.gaps import balls_of, gap_between

DISPLACEMENT_X = column_of(StageRow, "displacement_x")

_SHARE_OF_GAP = 0.25
"""Allowed error of a gap, relative to the rest of its tolerance: at the end of the motion before it
is corrected, and along the polynomial."""

_SHARE_OF_PIECES = 0.625
"""Allowed error of a gap from the pieces along the polynomial, relative to the rest of its
tolerance.
"""

_LOOKED_AT = 0.9
"""The same error at the times at which two pieces are checked: a third, a half and two thirds.

At other times the error is at most 11 % larger, if the rate of change of the acceleration changes
uniformly.
"""

_PIECE_ERROR = 1.0 / 40.5
"""Largest deviation of two pieces from a motion whose acceleration changes at a constant rate, in
units of this rate times the cube of a piece's duration."""

_POSITION_ERROR = 2.0**-26
"""Largest error [radii] of positions within a piece that isn't limited by a gap: 4e-10 m.

The ends of pieces don't have this error.
"""

_MOST_PIECES = 4096
"""Largest number of pieces of a motion; if more are needed, the step is halved. 104 is the most
seen so far."""


@kernel(inline=True)
def find_paths(contacts: Contacts, members: int, duration: float) -> None:
    """Put the polynomials between the start and the end of a step into `contacts.paths`."""
    start, end_state = contacts.start, contacts.numbers
    first, last = contacts.slopes[:, 0], contacts.slopes[:, STAGES - 1]
    for m in range(members):
        k = contacts.member[m]
        for axis in range(2):
            path = contacts.paths[k, axis]
            x, v = start[m, axis], duration * start[m, 2 + axis]
            a = duration * duration * first[m, 2 + axis]
            end = end_state[m, DISPLACEMENT_X + axis] - v - 0.5 * a
            end_v = duration * end_state[m, 2 + axis] - v - a
            end_a = duration * duration * last[m, 2 + axis] - a
            path[0], path[1], path[2] = x, v, 0.5 * a
            path[3] = 10.0 * end - 4.0 * end_v + 0.5 * end_a
            path[4] = -15.0 * end + 7.0 * end_v - end_a
            path[5] = 6.0 * end - 3.0 * end_v + 0.5 * end_a
        for axis in range(3):
            spin = contacts.spins[k, axis]
            w = start[m, 4 + axis]
            b = duration * first[m, 4 + axis]
            end = end_state[m, 4 + axis] - w - b
            end_b = duration * last[m, 4 + axis] - b
            spin[0], spin[1] = w, b
            spin[2] = 3.0 * end - end_b
            spin[3] = end_b - 2.0 * end


@kernel(inline=True)
def _displacement_at(contacts: Contacts, k: int, axis: int, part: float) -> tuple[float, float]:
    """Return ball k's displacement along an axis after a part of its motion, and its rate.

    Both are in [m]; the rate is a displacement per duration of the whole motion.
    """
    path = contacts.paths[k, axis]
    c1, c2, c3, c4, c5 = path[1], path[2], path[3], path[4], path[5]
    far = part * (c1 + part * (c2 + part * (c3 + part * (c4 + part * c5))))
    fast = c1 + part * (2.0 * c2 + part * (3.0 * c3 + part * (4.0 * c4 + part * 5.0 * c5)))
    return far, fast


@kernel(inline=True)
def _place_at(contacts: Contacts, k: int, part: float) -> tuple[float, float]:
    """Return the position of ball k after a part of its whole motion [m]."""
    x, _ = _displacement_at(contacts, k, 0, part)
    y, _ = _displacement_at(contacts, k, 1, part)
    return contacts.paths[k, 0, 0] + x, contacts.paths[k, 1, 0] + y


@kernel(inline=True)
def turn_at(contacts: Contacts, k: int, axis: int, part: float) -> float:
    """Return ball k's angular velocity about an axis [rad/s] after a part of its motion."""
    spin = contacts.spins[k, axis]
    w: float = spin[0] + part * (spin[1] + part * (spin[2] + part * spin[3]))
    return w


@kernel(inline=True)
def _jerk_at(contacts: Contacts, k: int, axis: int, part: float) -> float:
    path = contacts.paths[k, axis]
    jerk: float = 6.0 * path[3] + part * (24.0 * path[4] + part * 60.0 * path[5])
    return jerk


@kernel
def gap_along(world: World, c: int, part: float) -> tuple[float, float]:
    """Return contact c's gap [m] after a part of the motion.

    The second value is the rate of change of its acceleration, in units of the whole duration [m].
    """
    contacts = world.contacts
    a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
    x, y = _place_at(contacts, a, part)
    jerk_x, jerk_y = -_jerk_at(contacts, a, 0, part), -_jerk_at(contacts, a, 1, part)
    to_x, to_y = 0.0, 0.0
    if b >= 0:
        to_x, to_y = _place_at(contacts, b, part)
        jerk_x += _jerk_at(contacts, b, 0, part)
        jerk_y += _jerk_at(contacts, b, 1, part)
    nx, ny, gap = gap_between(world.balls, world.laws, a, b, x, y, to_x, to_y)
    return gap, nx * jerk_x + ny * jerk_y


@kernel(inline=True)
def share_of_gap(world: World, c: int, start: float) -> float:
    """Return the allowed error of contact c's gap [m] for each of a step's causes of error.

    It is the fraction `_SHARE_OF_GAP` of the tolerance that remains beside the gap at the start.
    """
    a, b = balls_of(world.contacts, c)
    share: float = contact_tolerance(world.balls, a, b) - abs(start)
    return _SHARE_OF_GAP * share


@kernel(inline=True)
def find_pieces(world: World, members: int, count: int, duration: float) -> bool:
    """Divide the motion into short enough pieces; set the velocities at its start.

    The result is False, without any change, if more than `_MOST_PIECES` are needed.
    """
    balls, contacts = world.balls, world.contacts
    most = 0.0  # cube of the number of pieces
    for c in range(count):
        start, _ = gap_along(world, c, 0.0)
        permitted = _SHARE_OF_PIECES / _SHARE_OF_GAP * share_of_gap(world, c, start)
        for part in range(3):
            _, jerk = gap_along(world, c, 0.5 * part)
            most = max(most, _PIECE_ERROR * abs(jerk) / permitted)
    for part in range(3):
        for m in range(members):
            k = contacts.member[m]
            jerk = abs(_jerk_at(contacts, k, 0, 0.5 * part))
            jerk += abs(_jerk_at(contacts, k, 1, 0.5 * part))
            permitted = _POSITION_ERROR * balls.state[k].radius
            most = max(most, _PIECE_ERROR * jerk / permitted)
    if not most <= float(_MOST_PIECES * _MOST_PIECES * _MOST_PIECES):
        return False
    pieces = 2
    while float(pieces * pieces * pieces) < most:
        pieces += 2
    # The estimate assumes a constant rate along two pieces, and a normal that doesn't turn.
    while not _pieces_keep_gaps(world, count, pieces):
        pieces *= 2
        if pieces > _MOST_PIECES:
            return False
    for m in range(members):
        k = contacts.member[m]
        row = contacts.motion[k]
        row.pieces_left, row.pieces = pieces, pieces
        row.piece_time, row.whole_time = duration / pieces, duration
        row.held_off = held_obstacles(contacts, count, k)
        balls.state[k].vx = contacts.start[m, 2]
        balls.state[k].vy = contacts.start[m, 3]
    return True


@kernel
def _pieces_keep_gaps(world: World, count: int, pieces: int) -> bool:
    """Return whether gaps stay within their tolerance while balls move along these pieces."""
    contacts = world.contacts
    for c in range(count):
        a, b = contacts.ends[c, st.FIRST], contacts.ends[c, st.SECOND]
        one, other = balls_of(contacts, c)
        start, _ = gap_along(world, c, 0.0)
        most = abs(start)
        most += _LOOKED_AT * (contact_tolerance(world.balls, one, other) - most)
        contacts.turns[0] += pieces
        for done in range(0, pieces, 2):
            x, to_x = _places_along(contacts, a, 0, done, pieces), (0.0, 0.0, 0.0)
            y, to_y = _places_along(contacts, a, 1, done, pieces), (0.0, 0.0, 0.0)
            if b >= 0:
                to_x = _places_along(contacts, b, 0, done, pieces)
                to_y = _places_along(contacts, b, 1, done, pieces)
            for look in range(3):
                _, _, gap = gap_between(
                    world.balls, world.laws, a, b, x[look], y[look], to_x[look], to_y[look]
                )
                if not abs(gap) <= most:
                    return False
    return True


@kernel(inline=True)
def _places_along(
    contacts: Contacts, k: int, axis: int, done: int, pieces: int
) -> tuple[float, float, float]:
    """Return ball k's coordinate [m] at a third, a half and two thirds of the next two pieces.

    Each piece has a constant acceleration: see `start_piece`.
    """
    part = 1.0 / pieces
    start, fast = _displacement_at(contacts, k, axis, done * part)
    end, fast_end = _displacement_at(contacts, k, axis, (done + 2) * part)
    fast, fast_end = part * fast, part * fast_end
    first = (end - start) - 2.0 * fast - 0.5 * (fast_end - fast)
    second = (fast_end - fast) - first
    origin = contacts.paths[k, axis, 0]
    return (
        origin + (start + (2.0 * fast + (2.0 / 3.0) * first) / 3.0),
        origin + (start + fast + 0.5 * first),
        origin + (end - (2.0 * fast_end - (2.0 / 3.0) * second) / 3.0),
    )


@kernel
def held_obstacles(contacts: Contacts, count: int, k: int) -> int:
    """Return the obstacles that an island's contacts hold ball k off, one bit each."""
    held = 0
    for c in range(count):
        if contacts.ends[c, st.FIRST] == k and contacts.ends[c, st.SECOND] < 0:
            held |= 1 << (-1 - contacts.ends[c, st.SECOND])
    return held


@kernel
def start_piece(world: World, k: int) -> None:
    """Let ball k move along the next piece of its motion, from its epoch on.

    The acceleration of the first of two pieces follows from the displacement to the end of the
    second. (Positions instead of displacements gave large accelerations: their rounding, over the
    square of a short time.)
    """
    balls, contacts = world.balls, world.contacts
    straighten(balls, k)  # its previous piece, alone in air, may have a higher degree
    ball, row = balls.state[k], contacts.motion[k]
    pieces, time = row.pieces, row.piece_time
    done = pieces - row.pieces_left
    is_first = int(done) % 2 == 0
    part = (done + 2.0) / pieces if is_first else (done + 1.0) / pieces
    x, fast_x = _displacement_at(contacts, k, 0, part)
    y, fast_y = _displacement_at(contacts, k, 1, part)
    ax = (fast_x / row.whole_time - ball.vx) / time
    ay = (fast_y / row.whole_time - ball.vy) / time
    if is_first:
        from_x, _ = _displacement_at(contacts, k, 0, done / pieces)
        from_y, _ = _displacement_at(contacts, k, 1, done / pieces)
        ax = ((x - from_x) - 2.0 * time * ball.vx) / (time * time) - 0.5 * ax
        ay = ((y - from_y) - 2.0 * time * ball.vy) / (time * time) - 0.5 * ay
    ball.ax, ball.ay = ax, ay
    if world.laws.slides:
        part = (done + 1.0) / pieces
        if ball.phase == st.SLIDING:
            ball.bx = (turn_at(contacts, k, 0, part) - ball.wx) / time
            ball.by = (turn_at(contacts, k, 1, part) - ball.wy) / time
        alone = slowed_spin(ball.wz, time * ball.spin_slowing)
        ball.bz = (turn_at(contacts, k, 2, part) - alone) / time
    if not at_rest(balls, k):
        ball.moved = 1.0
    row.pieces_left -= 1.0
    balls.own_kind[k] = st.OWN_CONTACT
    predict_obstacles(balls, k, world.laws, time, int(row.held_off))
    mark(balls, k)
