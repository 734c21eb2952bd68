"""What stands on a table that isn't a plain rectangle: rails, jaws, posts, and the holes.

Engines, checks and pictures get it from `Table.obstacles`, by these types. Where the pieces of a
pocket are, `scene.pockets` says.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ghostball.model.arrays import BoolArray, FloatArray
from ghostball.model.events import EventKind
from ghostball.model.scene.sides import CUSHIONS, Point

POCKETS = ("bottom-left", "bottom", "bottom-right", "top-right", "top", "top-left")
"""Names of pockets in the order of their index, round the table."""

FIRST_SIDE = len(CUSHIONS)
"""Index of the first side of a polygon; the next ones follow."""

FIRST_POST = 1 << 16
"""Index of the first post."""

FIRST_HOLE = 1 << 17
"""Index by which `leaves-table` names the first pocket; others follow as in `POCKETS`."""


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


def obstacle_name(index: int) -> str:
    """Return what files and reports call a cushion, a side, a post, or a pocket flown over."""
    if index < FIRST_SIDE:
        return CUSHIONS[index]
    if index < FIRST_POST:
        return f"side-{index - FIRST_SIDE + 1}"
    if index < FIRST_HOLE:
        return f"post-{index - FIRST_POST + 1}"
    return f"{POCKETS[index - FIRST_HOLE]}-pocket"


def obstacle_index(name: str) -> int:
    """Return the index of an obstacle of that name.

    Raises `ValueError` where nothing can be called so.
    """
    if name in CUSHIONS:
        return CUSHIONS.index(name)
    if name.endswith("-pocket") and name.removesuffix("-pocket") in POCKETS:
        return FIRST_HOLE + POCKETS.index(name.removesuffix("-pocket"))
    kind, dash, number = name.partition("-")
    if dash and number.isdecimal() and int(number) > 0:
        if kind == "side" and int(number) <= FIRST_POST - FIRST_SIDE:
            return FIRST_SIDE + int(number) - 1
        if kind == "post" and int(number) <= FIRST_HOLE - FIRST_POST:
            return FIRST_POST + int(number) - 1
    raise ValueError(f'"{name}" is no cushion, side, post or pocket')


def partner_name(kind: EventKind, index: int) -> str:
    """Return what files and reports call what a ball meets: a pocket, or an obstacle."""
    return POCKETS[index] if kind is EventKind.POCKETED else obstacle_name(index)


def partner_index(kind: EventKind, name: str) -> int:
    """Return the index in events of what is called so; what `partner_name` is the inverse of.

    Raises `ValueError` where nothing can be called so.
    """
    index = POCKETS.index(name) if kind is EventKind.POCKETED else obstacle_index(name)
    if index >= FIRST_HOLE and kind is not EventKind.LEAVES_TABLE:
        raise ValueError(f'a ball leaves the table over "{name}", and doesn\'t hit it')
    return index


def obstacles_of_polygon(vertices: Sequence[Point]) -> list[Obstacle]:
    """Return the sides of a polygon whose vertices go round counterclockwise [m]."""
    ends = pairwise([*vertices, vertices[0]])
    return [Segment(FIRST_SIDE + k, *side) for k, side in enumerate(ends)]


def gap_to(obstacle: Obstacle, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return how far points are from an obstacle's surface, or from a hole's edge, (m,) [m].

    Negative inside of one.
    """
    dx, dy, radius = _from_nearest(obstacle, x, y)
    away: FloatArray = np.hypot(dx, dy)
    return away - radius


def facing(obstacle: Obstacle, x: float, y: float) -> tuple[Point, float]:
    """Return an obstacle's unit normal towards a place off it, and how far that is from it [m]."""
    (dx,), (dy,), radius = _from_nearest(obstacle, np.array([x]), np.array([y]))
    away = math.hypot(dx, dy)
    return (float(dx / away), float(dy / away)), away - radius


def turns_about(obstacle: Obstacle, x: float, y: float) -> Point | None:
    """Return the point about which an obstacle's normal turns, towards a place [m].

    None in front of a straight piece, where it doesn't turn.
    """
    if not isinstance(obstacle, Segment):
        return obstacle.centre
    (x0, y0), (x1, y1) = obstacle.start, obstacle.end
    along = (x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)
    if along < 0.0:
        return obstacle.start
    return obstacle.end if along > (x1 - x0) ** 2 + (y1 - y0) ** 2 else None


def _from_nearest(
    obstacle: Obstacle, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray, float]:
    """Return the way to points from the nearest one of a segment, or from a centre; the radius."""
    if not isinstance(obstacle, Segment):
        return x - obstacle.centre[0], y - obstacle.centre[1], obstacle.radius
    (x0, y0), (x1, y1) = obstacle.start, obstacle.end
    dx, dy = x1 - x0, y1 - y0
    part = np.clip(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
    return x - x0 - part * dx, y - y0 - part * dy, 0.0


def is_inside(outline: Sequence[Point], x: FloatArray, y: FloatArray) -> BoolArray:
    """Whether points are inside a polygon, (m,): a line from them to the left crosses it oddly."""
    inside = np.zeros(len(x), dtype=np.bool_)
    for (x0, y0), (x1, y1) in pairwise([*outline, outline[0]]):
        if y0 != y1:
            beside = (y0 > y) != (y1 > y)
            inside ^= beside & (x > x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return inside


def distance_to_box(place: Point, low: Point, high: Point) -> float:
    """Return how far a place is from the box between two of its corners [m]; 0 inside of it."""
    dx, dy = (
        max(least - at, at - most, 0.0) for at, least, most in zip(place, low, high, strict=True)
    )
    return math.hypot(dx, dy)
