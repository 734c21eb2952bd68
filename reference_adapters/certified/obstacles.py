"""The obstacles of a run: lines, faces of straight pieces, discs and holes.

A ball meets a straight piece on its face if the foot of the perpendicular from its centre lies
between the ends; or at an end that points into the table, which is a disc of radius 0. A ball can't
meet the back of a piece, because it would first meet a different piece or a hole.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from flint import arb, fmpq

from ghostball.model.scene import CUSHIONS, INWARD, Disc, Hole, Obstacle, Segment
from ghostball.model.scene.obstacles import FIRST_POST
from ghostball.model.scene.sides import Point
from ghostball.reference_adapters.certified.arithmetic import Vector, exactly, length
from ghostball.reference_adapters.certified.problem import ExactProblem

_COVERED = 1e-9
"""Distance from a jaw's surface up to which the end of a straight piece belongs to the jaw [m].

They join there, up to the rounding of their coordinates.
"""


class StraightPiece(NamedTuple):
    """A line, or the face of a straight piece.

    `obstacle`: its index in events.
    `row`: a unique number, because several pieces may belong to one obstacle.
    `place`: a point of the line; for a face, its start [m].
    `inward`: unit normal into the table; exact if it is parallel to an axis.
    `extent`: length of the face [m]; None for an infinite line.
    `is_open`: whether the start and the end of the face don't belong to it.
    `along`: exact vector from its start to its end, or a vector along the infinite line.
    `doubles`: place, normal and extent in doubles.
    """

    obstacle: int
    row: int
    place: Vector
    inward: Vector
    extent: arb | None
    is_open: tuple[bool, bool]
    along: tuple[fmpq, fmpq]
    doubles: tuple[float, float, float, float, float]

    @property
    def is_level(self) -> bool:
        """Whether the piece is parallel to an axis, so that its normal is exact."""
        return bool(self.inward[0].is_zero() or self.inward[1].is_zero())

    def across(self, vector: Vector) -> arb:
        """Return the component of a vector into the table."""
        return self.inward[0] * vector[0] + self.inward[1] * vector[1]

    def away(self, place: Vector) -> arb:
        """Return the distance of a place in front of the line [m]."""
        return self.across((place[0] - self.place[0], place[1] - self.place[1]))

    def holds_foot_of(self, place: Vector) -> bool | None:
        """Return whether the foot of a place's perpendicular is on the face; None if undecided."""
        if self.extent is None:
            return True
        dx, dy = place[0] - self.place[0], place[1] - self.place[1]
        along = self.inward[1] * dx - self.inward[0] * dy
        answers = (
            _is_beyond(along, is_open=self.is_open[0]),
            _is_beyond(self.extent - along, is_open=self.is_open[1]),
        )
        if False in answers:
            return False
        return None if None in answers else True


class RoundPiece(NamedTuple):
    """A disc, the end of a straight piece, or a hole, in which a ball is pocketed.

    `obstacle`, `row`: as for a `StraightPiece`; for a hole, the first is the pocket.
    `centre`, `radius`: [m].
    `inward`: for a hole, the unit vector along the pocket's axis, into the table.
    `is_post`: whether it is a post, higher than any flight.
    `doubles`: centre and radius in doubles.
    """

    obstacle: int
    row: int
    centre: Vector
    radius: arb
    takes_out: bool
    is_post: bool
    inward: Vector
    doubles: tuple[float, float, float]


def obstacles_met(problem: ExactProblem) -> list[StraightPiece | RoundPiece]:
    """Return all obstacles that a ball may meet, with the present precision.

    The cushions of a rectangle come first; their rows are their indices in events.
    """
    found: list[StraightPiece | RoundPiece] = []
    for k, line in enumerate(problem.noses):
        if line is not None:
            x, y = INWARD[CUSHIONS[k]]
            place = (line, 0.0) if x else (0.0, line)
            inward = (arb(x), arb(y))
            doubles = (*place, x, y, math.inf)
            along = (exactly(y), exactly(-x))
            found.append(
                StraightPiece(k, k, _exact(place), inward, None, (False, False), along, doubles)
            )
    ends = _ends_met(problem.obstacles)
    pieces: list[Obstacle] = [*problem.obstacles]
    pieces += [Disc(obstacle, end, 0.0) for end, obstacle in ends.items()]
    for row, one in enumerate(pieces, start=len(CUSHIONS)):
        if isinstance(one, Segment):
            found.append(_face(one, row, (one.start in ends, one.end in ends)))
        else:
            takes_out = isinstance(one, Hole)
            index = one.pocket if isinstance(one, Hole) else one.obstacle
            found.append(
                RoundPiece(
                    index,
                    row,
                    _exact(one.centre),
                    arb(one.radius),
                    takes_out,
                    not takes_out and index >= FIRST_POST,
                    _exact(one.inward or (0.0, 0.0)),
                    (*one.centre, one.radius),
                )
            )
    return found


def _exact(point: Point) -> Vector:
    return (arb(point[0]), arb(point[1]))


def _face(one: Segment, row: int, is_open: tuple[bool, bool]) -> StraightPiece:
    along = _way_along(one)
    dx, dy = arb(along[0]), arb(along[1])
    size = length(dx, dy)
    inward = (-dy / size, dx / size)
    doubles = (*one.start, float(inward[0]), float(inward[1]), float(size))
    return StraightPiece(
        one.obstacle, row, _exact(one.start), inward, size, is_open, along, doubles
    )


def _ends_met(obstacles: Sequence[Obstacle]) -> dict[Point, int]:
    """Return the ends of straight pieces that a ball can meet, with their indices in events.

    The index is that of the side that ends there, in counterclockwise order.

    An end can't be met at the start of a jaw or in a hole, nor if two pieces join there with a
    convex corner of the table or in a straight line: there a ball meets the faces.
    """
    straight = [one for one in obstacles if isinstance(one, Segment)]
    rest = [one for one in obstacles if not isinstance(one, Segment)]
    before = {one.end: one for one in straight}
    after = {one.start: one for one in straight}
    found: dict[Point, int] = {}
    for one in straight:
        for end in (one.start, one.end):
            if end in found or any(_belongs_to(end, other) for other in rest):
                continue
            joined = end in before and end in after
            if not joined or _turns_right(before[end], after[end]):
                found[end] = before.get(end, one).obstacle
    return found


def _belongs_to(end: Point, other: Disc | Hole) -> bool:
    away = math.dist(end, other.centre)
    return away < other.radius if isinstance(other, Hole) else abs(away - other.radius) < _COVERED


def _turns_right(before: Segment, after: Segment) -> bool:
    """Return whether two pieces turn right, so that their corner points into the table."""
    (ax, ay), (bx, by) = _way_along(before), _way_along(after)
    return bool(ax * by - ay * bx < 0)


def _way_along(one: Segment) -> tuple[fmpq, fmpq]:
    (x0, y0), (x1, y1) = one.start, one.end
    return exactly(x1) - exactly(x0), exactly(y1) - exactly(y0)


def _is_beyond(along: arb, *, is_open: bool) -> bool | None:
    """Return whether a foot is on the face's side of one of its ends; None if undecided.

    `along`: distance from this end, positive towards the other end [m].
    """
    if along > 0:
        return True
    if along < 0:
        return False
    return not is_open if along.is_zero() else None
