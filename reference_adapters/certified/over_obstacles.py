"""A ball in the air above pockets, or a polygon: the holes and obstacles that it may meet.

Seen from above it moves in a straight line, so geometry shows which obstacles it certainly doesn't
meet. Near a jaw, or the end of a nose, whose gap to a ball in the air isn't polynomial, nothing is
decided, and the proof ends when the ball takes off.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterator, Sequence

from flint import arb

from ghostball.model import EventKind
from ghostball.model.scene.obstacles import FIRST_HOLE
from ghostball.reference_adapters.certified.arithmetic import Vector, exactly
from ghostball.reference_adapters.certified.certificate import Choice
from ghostball.reference_adapters.certified.flight import FlyingBody
from ghostball.reference_adapters.certified.meetings import Meeting
from ghostball.reference_adapters.certified.obstacle_gaps import choice_at
from ghostball.reference_adapters.certified.obstacles import RoundPiece, StraightPiece

HIGHEST_AT_BACK = 1.4
"""Largest height of a ball's centre, in radii, at which it falls into a hole at its far edge.

This is a rule of the model, with the same double as in the engine.
"""

_MARGIN = 2.0**-20
"""Margin for passing an obstacle, relative to a ball's radius, position and path.

It is far larger than the error of doubles for positions known to `motion.EXACT_ENOUGH`.
"""

Point = tuple[float, float]


class Nearness(enum.Enum):
    """Position of a ball in the air relative to an obstacle with ends."""

    FAR = enum.auto()  # the ball neither touches the obstacle nor passes above it
    IN_FRONT = enum.auto()  # always in front of a face, which then counts as a line
    UNDECIDED = enum.auto()


def hole_below(
    body: FlyingBody, pieces: Sequence[StraightPiece | RoundPiece]
) -> tuple[RoundPiece | None, bool]:
    """Return the hole in which a ball lands, or None; and whether this is decided."""
    assert body.duration is not None
    place = body.position_after(body.duration)
    for piece in pieces:
        if isinstance(piece, RoundPiece) and piece.takes_out:
            gap = _square_from(piece, place) - piece.radius * piece.radius
            if not gap > 0:
                return piece, bool(gap < 0)
    return None, True


def past_hole(i: int, body: FlyingBody, hole: RoundPiece) -> Iterator[tuple[Choice, Meeting]]:
    """Yield the event of ball i at the far edge of a hole that it flies over, if any."""
    vx, vy = body.vx, body.vy
    undecided = (choice_at(i, hole), Meeting(None, body.t))
    dx, dy = body.x - hole.centre[0], body.y - hole.centre[1]
    square, along = vx * vx + vy * vy, dx * vx + dy * vy
    away = dx * vy - dy * vx
    chord = square * hole.radius * hole.radius - away * away
    if square.is_zero() or chord < 0:
        return
    if not (chord > 0 and square > 0):
        yield undecided
        return
    s = (chord.sqrt() - along) / square
    assert body.duration is not None
    if s < 0 or s > body.duration:
        return
    height = body.vertical_after(s)[0] - exactly(HIGHEST_AT_BACK) * body.constants.radius
    if not (s > 0 and s < body.duration and (height > 0 or height < 0)):
        yield undecided
        return
    found = Meeting(s, body.t + s)
    if height < 0:
        yield choice_at(i, hole), found
        return
    x, y = body.position_after(s)
    behind = (x - hole.centre[0]) * hole.inward[0] + (y - hole.centre[1]) * hole.inward[1]
    if behind < 0:
        yield Choice(EventKind.LEAVES_TABLE, i, FIRST_HOLE + hole.obstacle), found
    elif not behind > 0:
        yield undecided


def nearness(body: FlyingBody, piece: StraightPiece | RoundPiece, last: float) -> Nearness:
    """Return how close a ball comes to a face, a jaw, or the end of a nose in `last` seconds."""
    state = body.doubles
    if not state.exact_enough:
        return Nearness.UNDECIDED
    start = (state.x, state.y)
    end = (state.x + last * state.vx, state.y + last * state.vy)
    radius = float(body.constants.radius)
    margin = _MARGIN * (radius + state.place + last * state.speed)
    if isinstance(piece, RoundPiece):
        x, y, size = piece.doubles
        is_far = _from_way((x, y), start, end) > size + radius + margin
        return Nearness.FAR if is_far else Nearness.UNDECIDED
    x, y, nx, ny, extent = piece.doubles
    corner = (x + extent * ny, y - extent * nx)
    if not _cross(start, end, (x, y), corner):
        ends = (
            (start, (x, y), corner),
            (end, (x, y), corner),
            ((x, y), start, end),
            (corner, start, end),
        )
        if min(_from_way(*three) for three in ends) > radius + margin:
            return Nearness.FAR
    feet = [ny * (p[0] - x) - nx * (p[1] - y) for p in (start, end)]
    in_front = min(feet) > margin and max(feet) < extent - margin
    return Nearness.IN_FRONT if in_front else Nearness.UNDECIDED


def _square_from(piece: RoundPiece, place: Vector) -> arb:
    dx, dy = place[0] - piece.centre[0], place[1] - piece.centre[1]
    return dx * dx + dy * dy


def _from_way(point: Point, start: Point, end: Point) -> float:
    """Return the distance of a point from a straight path [m]."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    rx, ry = point[0] - start[0], point[1] - start[1]
    square = dx * dx + dy * dy
    part = min(max((rx * dx + ry * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(rx - part * dx, ry - part * dy)


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Return True if two straight paths cross.

    If rounding hides a crossing, `nearness` still finds that an end is near the other path.
    """

    def side(p: Point, q: Point, r: Point) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0
