"""Obstacles of tables that aren't plain rectangles: rails, jaws, posts, and holes.

`Table.obstacles` returns these types to engines, checks and pictures. The positions of the pieces
of a pocket are computed in `scene.pockets`.
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
"""Names of pockets in the order of their index, counterclockwise."""

FIRST_SIDE = len(CUSHIONS)
"""Index of the first side of a polygon; the next sides follow."""

FIRST_POST = 1 << 16
"""Index of the first post."""

FIRST_HOLE = 1 << 17
"""Index of the first pocket in a `leaves-table` event; the next pockets follow as in `POCKETS`."""


class Segment(NamedTuple):
    """A straight piece of cushion; a ball meets each of its ends as a point.

    `obstacle` is its index in events: that of its cushion, or of a side of a polygon.
    """

    obstacle: int
    start: Point  # [m]; the table is on the left of the direction from `start` to `end`
    end: Point


class Disc(NamedTuple):
    """A round obstacle: a jaw between the nose of a cushion and its facing, or a post.

    A jaw lies behind the nose of its cushion: `inward` is the unit normal of the cushion into the
    table. A post has none.
    """

    obstacle: int
    centre: Point  # [m]
    radius: float  # [m]
    inward: Point | None = None


class Hole(NamedTuple):
    """The hole of a pocket: a ball is pocketed when its centre enters it.

    `pocket` is its index in `POCKETS`.
    """

    pocket: int
    centre: Point  # [m]
    radius: float  # [m]
    inward: Point  # unit vector along the pocket's axis, into the table


Obstacle = Segment | Disc | Hole


def obstacle_name(index: int) -> str:
    """Return the name, in files and reports, of a cushion, side, post, or pocket flown over."""
    if index < FIRST_SIDE:
        return CUSHIONS[index]
    if index < FIRST_POST:
        return f"side-{index - FIRST_SIDE + 1}"
    if index < FIRST_HOLE:
        return f"post-{index - FIRST_POST + 1}"
    return f"{POCKETS[index - FIRST_HOLE]}-pocket"


def obstacle_index(name: str) -> int:
    """Return the index of the obstacle with a name.

    Raises `ValueError` if no obstacle can have this name.
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
    """Return the name, in files and reports, of the obstacle or the pocket that a ball meets."""
    return POCKETS[index] if kind is EventKind.POCKETED else obstacle_name(index)


def partner_index(kind: EventKind, name: str) -> int:
    """Return the index, in events, of the obstacle or pocket with a name.

    This is the inverse of `partner_name`.

    Raises `ValueError` if nothing can have this name.
    """
    index = POCKETS.index(name) if kind is EventKind.POCKETED else obstacle_index(name)
    if index >= FIRST_HOLE and kind is not EventKind.LEAVES_TABLE:
        raise ValueError(f'a ball leaves the table over "{name}", and doesn\'t hit it')
    return index


def obstacles_of_polygon(vertices: Sequence[Point]) -> list[Obstacle]:
    """Return the sides of a polygon whose vertices are in counterclockwise order [m]."""
    ends = pairwise([*vertices, vertices[0]])
    return [Segment(FIRST_SIDE + k, *side) for k, side in enumerate(ends)]


def gap_to(obstacle: Obstacle, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the distance of points from an obstacle or from the edge of a hole, (m,) [m].

    Negative inside.
    """
    dx, dy, radius = _from_nearest(obstacle, x, y)
    away: FloatArray = np.hypot(dx, dy)
    return away - radius


def facing(obstacle: Obstacle, x: float, y: float) -> tuple[Point, float]:
    """Return the unit normal from an obstacle to a point outside, and its distance [m]."""
    (dx,), (dy,), radius = _from_nearest(obstacle, np.array([x]), np.array([y]))
    away = math.hypot(dx, dy)
    return (float(dx / away), float(dy / away)), away - radius


def turns_about(obstacle: Obstacle, x: float, y: float) -> Point | None:
    """Return the point about which the normal of an obstacle turns, seen from a place [m].

    None in front of a straight piece, where the normal is constant.
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
    """Return the vectors from the nearest points of an obstacle, and its radius.

    The nearest point of a jaw, a post or a hole is its centre; a segment has the radius 0.
    """
    if not isinstance(obstacle, Segment):
        return x - obstacle.centre[0], y - obstacle.centre[1], obstacle.radius
    (x0, y0), (x1, y1) = obstacle.start, obstacle.end
    dx, dy = x1 - x0, y1 - y0
    part = np.clip(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy), 0.0, 1.0)
    return x - x0 - part * dx, y - y0 - part * dy, 0.0


def is_inside(outline: Sequence[Point], x: FloatArray, y: FloatArray) -> BoolArray:
    """Return whether points are inside a polygon, (m,).

    A ray to the left of an inside point crosses the polygon an odd number of times.
    """
    inside = np.zeros(len(x), dtype=np.bool_)
    for (x0, y0), (x1, y1) in pairwise([*outline, outline[0]]):
        if y0 != y1:
            beside = (y0 > y) != (y1 > y)
            inside ^= beside & (x > x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return inside


def distance_to_box(place: Point, low: Point, high: Point) -> float:
    """Return the distance of a place from the box between two corners [m]; 0 inside."""
    dx, dy = (
        max(least - at, at - most, 0.0) for at, least, most in zip(place, low, high, strict=True)
    )
    return math.hypot(dx, dy)
