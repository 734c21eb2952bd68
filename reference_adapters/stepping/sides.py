"""The cushions of a scene for time-stepping engines: infinite lines, segments and discs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ghostball.model import CUSHIONS, Disc, Hole, Scene, Segment, Side
from ghostball.model.scene.sides import Point
from ghostball.reference_adapters.stepping.laws import fastest


def sides_of(scene: Scene) -> tuple[Side, ...]:
    """Return the cushions of a plain rectangle, in the order of `CUSHIONS`."""
    return () if scene.table is None else scene.table.sides


def parts_of(scene: Scene) -> tuple[Segment | Disc, ...]:
    """Return all other cushions: segments, jaws and posts.

    A ball meets the ends of a segment as points.
    """
    others = () if scene.table is None else scene.table.obstacles
    return tuple(one for one in others if not isinstance(one, Hole))


class Corner(NamedTuple):
    """A corner that points into the table; a ball meets the common point of its two sides."""

    place: Point  # [m]
    before: int  # index of the side that ends there
    after: int  # index of the side that begins there
    along: Point  # vector from the corner to the end of the side `after` [m]


def corners_of(scene: Scene) -> tuple[Corner, ...]:
    """Return the corners of a polygon that point into the table."""
    segments = [one for one in parts_of(scene) if isinstance(one, Segment)]
    corners = []
    for one, following in pairwise((*segments, *segments[:1])):
        (x0, y0), (x1, y1), (x2, y2) = one.start, one.end, following.end
        turns = (x1 - x0) * (y2 - y1) - (y1 - y0) * (x2 - x1)
        if one.end == following.start and turns < 0.0:
            along = x2 - x1, y2 - y1
            corners.append(Corner(one.end, one.obstacle, following.obstacle, along))
    return tuple(corners)


class CornerNames:
    """Names of collisions at corners: a corner belongs to the side that ends there."""

    def __init__(self, scene: Scene) -> None:
        self._corner_of = {corner.after: corner for corner in corners_of(scene)}

    def __bool__(self) -> bool:
        return bool(self._corner_of)

    def name(self, cushion: int, place: Sequence[float]) -> int:
        """Return the index in events of the cushion that the engine reports for a ball at a place.

        `cushion`: the reported index.
        `place`: centre of the ball [m].
        """
        corner = self._corner_of.get(cushion)
        if corner is None:
            return cushion
        (x, y), (along_x, along_y) = corner.place, corner.along
        before = along_x * (place[0] - x) + along_y * (place[1] - y) <= 0.0
        return corner.before if before else cushion


class Normals:
    """The normals of a scene's cushions, towards the balls that meet them."""

    def __init__(self, scene: Scene) -> None:
        self._table = scene.table
        self._fixed = {side.cushion: side.normal for side in sides_of(scene)}

    def at(self, cushion: int, place: Sequence[float]) -> Point:
        """Return the unit normal of a cushion, by its index in events, towards a place [m]."""
        fixed = self._fixed.get(cushion)
        if fixed is not None:
            return fixed
        assert self._table is not None  # a cushion was met, so there is a table
        return self._table.facing(cushion, float(place[0]), float(place[1]))[0]


def reach_beyond(scene: Scene) -> float:
    """Return how far outside an open table a ball can get [m]; 0 for a closed table.

    Outside, a ball may hit a cushion, which is an infinite line. The ball has at most the initial
    energy of all balls.
    """
    table = scene.table
    if table is None or len(table.cushions) == len(CUSHIONS):
        return 0.0
    speed = fastest(scene)
    frictions = [scene.rolling_frictions]
    if scene.physics.motion == "sliding":
        frictions.append(scene.sliding_frictions)
    deceleration = float(np.min(frictions)) * scene.physics.gravity
    distances = [speed**2 / (2.0 * deceleration)] if deceleration > 0.0 else []
    distances += [speed * scene.t_max] if scene.t_max is not None else []
    outside = float(np.max(np.abs(scene.positions)))  # a ball may start outside open sides
    return outside + min(distances, default=0.0)


def reach_beyond_corners(scene: Scene) -> float:
    """Return how far cushions must extend beyond corners [m], because balls may come from there.

    It includes the length of the table, so that the ends aren't corners for any ball.
    """
    return reach_beyond(scene) + (0.0 if scene.table is None else scene.table.length)
