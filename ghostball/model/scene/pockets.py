"""Pockets: their dimensions, and the positions of the rails, jaws, facings and holes of a table.

The geometry is that of Alciatore's technical proofs 3.5 and 3.6, with a rounded corner between nose
and facing, as in pooltool.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import AfterValidator, Field

from ghostball.model.rounding import position_rounding
from ghostball.model.scene.fields import NonNegative, Positive, Real, in_degrees, problem
from ghostball.model.scene.obstacles import POCKETS, Disc, Hole, Obstacle, Segment
from ghostball.model.scene.part import ScenePart
from ghostball.model.scene.sides import CUSHIONS, Point
from ghostball.model.sines import cosines_and_sines


def _cut_angle(value: float) -> float:
    if not 0.5 * math.pi <= value < math.pi:
        raise problem(
            f"must be an angle from pi / 2, and less than pi, got {value:g}. {in_degrees(value)}",
        )
    return value


class Pocket(ScenePart):
    """Dimensions of a pocket: mouth between two rounded jaws, facings behind the jaws, and hole."""

    mouth: Positive = Field(
        description="width of the mouth, between the (unrounded) corners of nose and facing [m]"
    )
    angle: Annotated[Real, AfterValidator(_cut_angle)] = Field(
        description="cut angle, between a cushion's nose and its facing [rad]"
    )
    jaw_radius: Positive = Field(description="radius of the rounded corner of nose and facing [m]")
    depth: NonNegative = Field(
        description="depth of the shelf, from the middle of the mouth to the edge of the hole [m]"
    )
    radius: Positive = Field(
        description="radius of the hole; a ball is pocketed when its centre enters it [m]"
    )


class Pockets(ScenePart):
    """The pockets of a rectangular table: four in its corners, two in the middle of its length."""

    corner: Pocket | None = Field(
        default=None, description="the four corner pockets; default: none"
    )
    side: Pocket | None = Field(
        default=None,
        description='the side pockets, in the cushions "bottom" and "top"; default: none',
    )


class Facing(NamedTuple):
    """One half of a pocket's mouth: the jaw and the facing behind it [m].

    Coordinates: u along the cushion, away from the pocket's axis, and v into the table.
    """

    joint: float  # u at which the straight nose ends and the jaw begins
    jaw: Point  # centre of the jaw
    start: Point  # start of the facing, where the jaw ends
    end: Point  # end of the facing, at the middle of the hole or beyond


def facing_of(pocket: Pocket, is_corner: bool) -> Facing:
    """Return one half of a pocket; the origin is where the axis of the pocket crosses the noses.

    The mouth of a corner pocket is measured between the points at which the noses of both cushions
    would meet the facings without rounding: each is mouth / sqrt(2) from the corner. The facing
    leaves the nose at the cut angle. A jaw of radius r touches both, at a distance r / tan(angle /
    2) from the point at which they would meet.
    """
    half = pocket.mouth / (math.sqrt(2.0) if is_corner else 2.0)
    cosines, sines = cosines_and_sines(np.array([pocket.angle]))
    cosine, sine = float(cosines[0]), float(sines[0])
    # The nose runs away from the axis, along (1, 0). The facing leaves the nose at the cut angle,
    # outwards.
    along: Point = (cosine, -sine)
    offset = pocket.jaw_radius * (1.0 + cosine) / sine  # r / tan(angle / 2)
    start = (half + offset * along[0], offset * along[1])
    hole = hole_of(pocket, is_corner)
    # The facing ends nearest to the middle of the hole, but at least as far out as the middle.
    distance = (hole[0] - half) * along[0] + hole[1] * along[1]
    if is_corner:
        distance = max(distance, (hole[0] + hole[1] - half) / (along[0] + along[1]))
    end = (half + distance * along[0], distance * along[1])
    return Facing(half + offset, (half + offset, -pocket.jaw_radius), start, end)


def hole_of(pocket: Pocket, is_corner: bool) -> Point:
    """Return the middle of a pocket's hole, in the coordinates of `Facing` [m].

    The edge of the hole is `depth` behind the middle of the mouth.
    """
    if not is_corner:
        return 0.0, -(pocket.depth + pocket.radius)
    out = (pocket.depth + pocket.radius - pocket.mouth / 2.0) / math.sqrt(2.0)
    return -out, -out


class _Half(NamedTuple):
    """Position of one half of a pocket: origin and axes of its coordinates on the table."""

    cushion: int
    origin: Point
    along: Point  # unit vector along the cushion, away from the pocket's axis
    inward: Point

    def place(self, point: Point) -> Point:
        """Return the position on the table of a point in the coordinates of the half [m]."""
        u, v = point
        x, y = self.origin
        return (
            x + u * self.along[0] + v * self.inward[0],
            y + u * self.along[1] + v * self.inward[1],
        )


class PocketOnTable(NamedTuple):
    """A pocket on the table: its two halves, in counterclockwise order round the table."""

    pocket: int
    is_corner: bool
    shape: Pocket
    first: _Half
    second: _Half

    @property
    def hole(self) -> Hole:
        """The hole of the pocket."""
        centre = self.second.place(hole_of(self.shape, self.is_corner))
        if self.is_corner:
            inward = tuple(
                (a + b) / math.sqrt(2.0)
                for a, b in zip(self.first.inward, self.second.inward, strict=True)
            )
        else:
            inward = self.first.inward
        return Hole(self.pocket, centre, self.shape.radius, (inward[0], inward[1]))


_CUSHION_INDEX: dict[str, int] = {name: k for k, name in enumerate(CUSHIONS)}


def place_pockets(length: float, width: float, pockets: Pockets) -> list[PocketOnTable]:
    """Return the pockets of a rectangle, counterclockwise from the bottom left pocket.

    In this direction the table is on the left. The cushion of the first half comes before the
    pocket, that of the second half after it.
    """
    right, left, up, down = (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)
    half = length / 2.0
    # Name; where the axis meets the cushions; the cushion before the pocket, the direction along it
    # away from the pocket, its inward normal; the same for the cushion after the pocket.
    places: tuple[tuple[str, Point, str, Point, Point, str, Point, Point], ...] = (
        ("bottom-left", (0.0, 0.0), "left", up, right, "bottom", right, up),
        ("bottom", (half, 0.0), "bottom", left, up, "bottom", right, up),
        ("bottom-right", (length, 0.0), "bottom", left, up, "right", up, left),
        ("top-right", (length, width), "right", down, left, "top", left, down),
        ("top", (half, width), "top", right, down, "top", left, down),
        ("top-left", (0.0, width), "top", right, down, "left", down, right),
    )
    found = []
    for name, origin, before, before_along, before_in, after, after_along, after_in in places:
        is_corner = "-" in name
        shape = pockets.corner if is_corner else pockets.side
        if shape is not None:
            first = _Half(_CUSHION_INDEX[before], origin, before_along, before_in)
            second = _Half(_CUSHION_INDEX[after], origin, after_along, after_in)
            found.append(PocketOnTable(POCKETS.index(name), is_corner, shape, first, second))
    return found


def obstacles_of_pockets(length: float, width: float, pockets: Pockets) -> list[Obstacle]:
    """Return the rails, jaws, facings and holes of a rectangle with pockets.

    Rails come first, then jaws and facings, then holes.

    A jaw is set back from the lines of its nose and its facing by twice the rounding of a position
    on the table. If its centre were rounded towards the cloth, the jaw would stick out beyond these
    lines, and a ball that glides along the rail would hit it. A ball must touch a jaw only between
    the normals of nose and facing.
    """
    placed = place_pockets(length, width, pockets)
    rails = _rails(length, width, placed)
    back = 2.0 * position_rounding(length, width)
    behind: list[Obstacle] = []
    for one in placed:
        shape = facing_of(one.shape, one.is_corner)
        # Set back by the same distance from both lines: along the bisector of their normals, (0, 1)
        # and (x, y) / radius.
        (u, v), radius = shape.jaw, one.shape.jaw_radius
        x, y = shape.start[0] - u, shape.start[1] - v
        centre = (u - back * x / (radius + y), v - back)
        for half in (one.first, one.second):
            jaw = Disc(half.cushion, half.place(centre), radius, half.inward)
            ends = half.place(shape.start), half.place(shape.end)
            behind += [jaw, Segment(half.cushion, *(ends if half is one.first else ends[::-1]))]
    return [*rails, *behind, *(one.hole for one in placed)]


def _rails(length: float, width: float, pockets: Sequence[PocketOnTable]) -> list[Obstacle]:
    """Return the straight noses, counterclockwise from the bottom left corner."""
    corners = _corners(length, width)
    rails: list[Obstacle] = []
    for k, name in enumerate(("bottom", "right", "top", "left")):
        cushion, begin, end = _CUSHION_INDEX[name], corners[k], corners[(k + 1) % 4]
        starts, ends = [], []
        for one in pockets:
            joint = (facing_of(one.shape, one.is_corner).joint, 0.0)
            if one.second.cushion == cushion:
                starts.append(one.second.place(joint))
            if one.first.cushion == cushion:
                ends.append(one.first.place(joint))
        if not any(one.is_corner and one.second.cushion == cushion for one in pockets):
            starts.append(begin)
        if not any(one.is_corner and one.first.cushion == cushion for one in pockets):
            ends.append(end)
        for start, stop in zip(
            sorted(starts, key=lambda point: math.dist(begin, point)),
            sorted(ends, key=lambda point: math.dist(begin, point)),
            strict=True,
        ):
            rails.append(Segment(cushion, start, stop))
    return rails


def _corners(length: float, width: float) -> list[Point]:
    """Return the corners of a rectangle, counterclockwise [m]."""
    return [(0.0, 0.0), (length, 0.0), (length, width), (0.0, width)]


def outline_of_pockets(
    length: float, width: float, pockets: Pockets, *, arc: int = 0
) -> list[Point]:
    """Return the polygon of noses and facings, to the middle of each hole, counterclockwise [m].

    `arc` is the number of straight pieces of each jaw. With 0, jaws aren't rounded, and the polygon
    is slightly smaller than the table.
    """
    placed = {one.pocket: one for one in place_pockets(length, width, pockets)}
    at_corners = [name for name in POCKETS if "-" in name]
    corners = dict(zip(at_corners, _corners(length, width), strict=True))
    points: list[Point] = []
    for k, name in enumerate(POCKETS):
        one = placed.get(k)
        if one is None:
            points += [corners[name]] if name in corners else []
            continue
        shape = facing_of(one.shape, one.is_corner)
        jaw = _rounded(one.shape, shape, one.is_corner, arc)
        points += [one.first.place(point) for point in (*jaw, shape.end)]
        points += [one.second.place(point) for point in (shape.end, *reversed(jaw))]
    return points


def _rounded(pocket: Pocket, facing: Facing, is_corner: bool, arc: int) -> list[Point]:
    """Return the points from a nose to its facing, in the coordinates of `Facing` [m]."""
    if arc == 0:
        return [(pocket.mouth / (math.sqrt(2.0) if is_corner else 2.0), 0.0)]
    centre, points = facing.jaw, []
    for k in range(arc + 1):
        part = k / arc
        x = part * (facing.start[0] - centre[0])
        y = (1.0 - part) * pocket.jaw_radius + part * (facing.start[1] - centre[1])
        longer = pocket.jaw_radius / math.hypot(x, y)
        points.append((centre[0] + longer * x, centre[1] + longer * y))
    return points
