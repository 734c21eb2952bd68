"""What stands on a table that isn't a plain rectangle: rails, jaws, posts, and the holes.

`obstacles_of_polygon` and `obstacles_of_pockets` say where everything is; adapters, proofs and
pictures get it from `Table.obstacles`, by these types. The geometry of a pocket is that of
Alciatore's technical proofs 3.5 and 3.6, with the corner between nose and facing rounded.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ghostball.model.events import EventKind
from ghostball.model.scene.sides import CUSHIONS, Point
from ghostball.model.sines import cosines_and_sines

FloatArray = NDArray[np.float64]

POCKETS = ("bottom-left", "bottom", "bottom-right", "top-right", "top", "top-left")
"""Names of pockets in the order of their index, round the table."""

FIRST_SIDE = len(CUSHIONS)
"""Index of the first side of a polygon; the next ones follow."""

FIRST_POST = 1 << 16
"""Index of the first post."""


class Segment(NamedTuple):
    """A straight piece of cushion, whose ends a ball meets as points.

    `obstacle` is the index by which events name it: that of its cushion, or of a polygon's side.
    """

    obstacle: int
    start: Point  # [m]; the table is on the left of the way to `end`
    end: Point


class Disc(NamedTuple):
    """A round obstacle: a jaw, between the nose of a cushion and its facing; or a post.

    A jaw lies behind the nose of its cushion: `inward` is the unit normal of that, into the table.
    A post has none.
    """

    obstacle: int
    centre: Point  # [m]
    radius: float  # [m]
    inward: Point | None = None


class Hole(NamedTuple):
    """What takes a ball whose centre enters it; `pocket` is its place in `POCKETS`."""

    pocket: int
    centre: Point  # [m]
    radius: float  # [m]
    inward: Point  # unit vector along the pocket's axis, into the table


Obstacle = Segment | Disc | Hole


class PocketShape(NamedTuple):
    """The numbers of a pocket, all that its geometry asks for; lengths [m], angle [degrees]."""

    mouth: float
    angle: float
    jaw_radius: float
    depth: float
    radius: float


class Facing(NamedTuple):
    """One side of a pocket's mouth: the jaw, and the facing behind it [m].

    In coordinates of the cushion: along it, away from the pocket's axis, and into the table.
    """

    joint: float  # where the straight nose ends and the jaw begins, along the cushion
    jaw: Point  # the jaw's centre
    start: Point  # of the facing, where the jaw ends
    end: Point  # at the middle of the hole


def obstacle_name(index: int) -> str:
    """Return what files and reports call a cushion, a side of a polygon, or a post."""
    if index < FIRST_SIDE:
        return CUSHIONS[index]
    if index < FIRST_POST:
        return f"side-{index - FIRST_SIDE + 1}"
    return f"post-{index - FIRST_POST + 1}"


def obstacle_index(name: str) -> int:
    """Return the index of an obstacle of that name.

    Raises `ValueError` where nothing can be called so.
    """
    if name in CUSHIONS:
        return CUSHIONS.index(name)
    kind, dash, number = name.partition("-")
    if dash and number.isdecimal() and int(number) > 0:
        if kind == "side" and int(number) <= FIRST_POST - FIRST_SIDE:
            return FIRST_SIDE + int(number) - 1
        if kind == "post":
            return FIRST_POST + int(number) - 1
    raise ValueError(f'"{name}" is no cushion, side or post')


def partner_name(kind: EventKind, index: int) -> str:
    """Return what files and reports call what a ball meets: a pocket, or an obstacle."""
    return POCKETS[index] if kind is EventKind.POCKETED else obstacle_name(index)


def partner_index(kind: EventKind, name: str) -> int:
    """Return the index in events of what is called so; what `partner_name` is the inverse of.

    Raises `ValueError` where nothing can be called so.
    """
    return POCKETS.index(name) if kind is EventKind.POCKETED else obstacle_index(name)


def obstacles_of_polygon(vertices: Sequence[Point]) -> list[Obstacle]:
    """Return the sides of a polygon whose vertices go round counterclockwise [m]."""
    ends = pairwise([*vertices, vertices[0]])
    return [Segment(FIRST_SIDE + k, *side) for k, side in enumerate(ends)]


def facing_of(pocket: PocketShape, is_corner: bool) -> Facing:
    """Return one half of a pocket, seen along the cushion from where its axis crosses the noses.

    A corner pocket's mouth is measured between the points where the noses of both cushions would
    meet the facings, were they not rounded: each mouth / sqrt(2) from the corner. The facing leaves
    the nose at the cut angle; a jaw of radius r touches both, at r / tan(angle / 2) from where they
    would meet.
    """
    half = pocket.mouth / (math.sqrt(2.0) if is_corner else 2.0)
    cosine, sine = _cosine_and_sine(pocket.angle)
    # The nose goes away from the axis, along (1, 0); the facing in the cut angle from it, and out.
    along: Point = (cosine, -sine)
    offset = pocket.jaw_radius * (1.0 + cosine) / sine  # r / tan(angle / 2)
    start = (half + offset * along[0], offset * along[1])
    hole = hole_of(pocket, is_corner)
    way = (hole[0] - half) * along[0] + hole[1] * along[1]
    end = (half + way * along[0], way * along[1])
    return Facing(half + offset, (half + offset, -pocket.jaw_radius), start, end)


def hole_of(pocket: PocketShape, is_corner: bool) -> Point:
    """Return the middle of a pocket's hole, in the coordinates of `Facing` [m].

    Its edge is `depth` behind the middle of the mouth.
    """
    if not is_corner:
        return 0.0, -(pocket.depth + pocket.radius)
    out = (pocket.depth + pocket.radius - pocket.mouth / 2.0) / math.sqrt(2.0)
    return -out, -out


def _cosine_and_sine(degrees: float) -> Point:
    """Return cosine and sine of an angle, the same bits on every machine."""
    cosine, sine = cosines_and_sines(np.array([degrees * math.pi / 180.0]))
    return float(cosine[0]), float(sine[0])


class _Half(NamedTuple):
    """How one half of a pocket lies on the table: where its axis meets the cushion, and how."""

    cushion: int
    origin: Point
    along: Point  # unit vector along the cushion, away from the pocket's axis
    inward: Point

    def place(self, point: Point) -> Point:
        """Return where a point of the half's own coordinates is on the table [m]."""
        u, v = point
        x, y = self.origin
        return (
            x + u * self.along[0] + v * self.inward[0],
            y + u * self.along[1] + v * self.inward[1],
        )


class PocketOnTable(NamedTuple):
    """A pocket at its place: the half that comes first, going round the table, and the other."""

    pocket: int
    is_corner: bool
    shape: PocketShape
    first: _Half
    second: _Half

    @property
    def hole(self) -> Hole:
        """Its hole."""
        centre = self.second.place(hole_of(self.shape, self.is_corner))
        if self.is_corner:
            inward = tuple(
                (a + b) / math.sqrt(2.0)
                for a, b in zip(self.first.inward, self.second.inward, strict=True)
            )
        else:
            inward = self.first.inward
        return Hole(self.pocket, centre, self.shape.radius, (inward[0], inward[1]))


_INDEX: dict[str, int] = {name: k for k, name in enumerate(CUSHIONS)}


def place_pockets(
    length: float, width: float, corner: PocketShape | None, side: PocketShape | None
) -> list[PocketOnTable]:
    """Return a rectangle's pockets where they are, counterclockwise from the bottom left one.

    Going round so, the table is on the left; a half's cushion is before it, or after it.
    """
    right, left, up, down = (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)
    half = length / 2.0
    # Name, where its axis meets the cushions; the cushion before it, and how that goes away from
    # it; the cushion behind it, in the same way.
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
        shape = corner if is_corner else side
        if shape is not None:
            first = _Half(_INDEX[before], origin, before_along, before_in)
            second = _Half(_INDEX[after], origin, after_along, after_in)
            found.append(PocketOnTable(POCKETS.index(name), is_corner, shape, first, second))
    return found


def obstacles_of_pockets(
    length: float, width: float, corner: PocketShape | None, side: PocketShape | None
) -> list[Obstacle]:
    """Return rails, jaws, facings and holes of a rectangle with pockets.

    Rails come first, then what lies behind their noses, the holes last.
    """
    pockets = place_pockets(length, width, corner, side)
    rails = _rails(length, width, pockets)
    behind: list[Obstacle] = []
    for one in pockets:
        shape = facing_of(one.shape, one.is_corner)
        for half in (one.first, one.second):
            jaw = Disc(half.cushion, half.place(shape.jaw), one.shape.jaw_radius, half.inward)
            ends = half.place(shape.start), half.place(shape.end)
            behind += [jaw, Segment(half.cushion, *(ends if half is one.first else ends[::-1]))]
    return [*rails, *behind, *(one.hole for one in pockets)]


def _rails(length: float, width: float, pockets: Sequence[PocketOnTable]) -> list[Obstacle]:
    """Return the straight noses, counterclockwise from the corner at the bottom left."""
    corners = _corners(length, width)
    rails: list[Obstacle] = []
    for k, name in enumerate(("bottom", "right", "top", "left")):
        cushion, begin, end = _INDEX[name], corners[k], corners[(k + 1) % 4]
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
    length: float,
    width: float,
    corner: PocketShape | None,
    side: PocketShape | None,
    *,
    arc: int = 0,
) -> list[Point]:
    """Return the polygon of noses and facings, to the middle of each hole, counterclockwise [m].

    Each jaw is rounded by so many straight pieces, `arc`; 0: it isn't, which takes a little less
    than there is.
    """
    pockets = {one.pocket: one for one in place_pockets(length, width, corner, side)}
    at_corners = [name for name in POCKETS if "-" in name]
    corners = dict(zip(at_corners, _corners(length, width), strict=True))
    points: list[Point] = []
    for k, name in enumerate(POCKETS):
        one = pockets.get(k)
        if one is None:
            points += [corners[name]] if name in corners else []
            continue
        shape = facing_of(one.shape, one.is_corner)
        jaw = _rounded(one.shape, shape, one.is_corner, arc)
        points += [one.first.place(point) for point in (*jaw, shape.end)]
        points += [one.second.place(point) for point in (shape.end, *reversed(jaw))]
    return points


def _rounded(pocket: PocketShape, facing: Facing, is_corner: bool, arc: int) -> list[Point]:
    """Return the way from a nose to its facing, in the coordinates of `Facing` [m]."""
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


def gap_to(obstacle: Obstacle, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return how far points are from an obstacle's surface, or from a hole's edge, (m,) [m].

    Negative inside of one.
    """
    if isinstance(obstacle, Segment):
        (x0, y0), (x1, y1) = obstacle.start, obstacle.end
        dx, dy = x1 - x0, y1 - y0
        part = np.clip(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
        away: FloatArray = np.hypot(x - x0 - part * dx, y - y0 - part * dy)
        return away
    distance: FloatArray = np.hypot(x - obstacle.centre[0], y - obstacle.centre[1])
    return distance - obstacle.radius


def facing(obstacle: Obstacle, x: float, y: float) -> tuple[Point, float]:
    """Return an obstacle's unit normal towards a place off it, and how far that is from it [m]."""
    if isinstance(obstacle, Segment):
        (x0, y0), (x1, y1) = obstacle.start, obstacle.end
        dx, dy = x1 - x0, y1 - y0
        part = ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy)
        part = min(max(part, 0.0), 1.0)
        nearest, radius = (x0 + part * dx, y0 + part * dy), 0.0
    else:
        nearest, radius = obstacle.centre, obstacle.radius
    away = math.dist(nearest, (x, y))
    return ((x - nearest[0]) / away, (y - nearest[1]) / away), away - radius


def is_inside(outline: Sequence[Point], x: FloatArray, y: FloatArray) -> NDArray[np.bool_]:
    """Whether points are inside a polygon, (m,): a line from them to the left crosses it oddly."""
    inside = np.zeros(len(x), dtype=np.bool_)
    for (x0, y0), (x1, y1) in pairwise([*outline, outline[0]]):
        if y0 != y1:
            beside = (y0 > y) != (y1 > y)
            inside ^= beside & (x > x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return inside
