"""The table: a rectangle with cushions, with or without pockets, or any polygon; and posts."""

from __future__ import annotations

import math
from functools import cache, lru_cache
from operator import not_
from typing import Any, ClassVar, Literal, Self

from pydantic import Field, field_validator, model_validator
from pydantic_core.core_schema import ValidatorFunctionWrapHandler

from ghostball.model.scene.ball import CAROM_BALL, POOL_BALL, SNOOKER_BALL
from ghostball.model.scene.fields import LARGEST, SMALLEST, Positive, Real, problem
from ghostball.model.scene.obstacles import (
    FIRST_POST,
    Disc,
    Hole,
    Obstacle,
    distance_to_box,
    facing,
    obstacles_of_polygon,
    turns_about,
)
from ghostball.model.scene.part import ScenePart
from ghostball.model.scene.pockets import Pockets, obstacles_of_pockets, outline_of_pockets
from ghostball.model.scene.sides import CUSHIONS, CushionName, Point, Side, side_of
from ghostball.model.scene.table_rules import check_pockets, check_polygon, check_posts

_INCH = 0.0254  # [m]

_HOLE_MARGIN = 2.0**-26
"""Relative margin for the distance of a hole's centre: the square root of EPS."""

_DEGREE = math.pi / 180.0  # [rad]


class Post(ScenePart):
    """A round obstacle that stands on the table."""

    centre: tuple[Real, Real] = Field(description="centre [m]")
    radius: Positive = Field(description="radius [m]")


def _pool_pockets() -> dict[str, Any]:
    """Return pockets by the rules of the World Pool Association.

    Each value is in the middle of its range.

    Rules: mouths of 4 1/2 to 4 5/8 in and 5 to 5 1/8 in, cut angles of 142 and 104 degrees, shelves
    of 1 to 2 1/4 in and 0 to 3/8 in. The rules don't specify holes and jaws: the holes are those of
    Alciatore's technical proofs 3.6 and 3.5, the jaws those of pooltool's 7 ft table.
    """
    return {
        "corner": {
            "mouth": 4.5625 * _INCH,
            "angle": 142.0 * _DEGREE,
            "jaw_radius": 0.02095,
            "depth": 1.625 * _INCH,
            "radius": 2.75 * _INCH,
        },
        "side": {
            "mouth": 5.0625 * _INCH,
            "angle": 104.0 * _DEGREE,
            "jaw_radius": 0.00795,
            "depth": 0.1875 * _INCH,
            "radius": 3.0 * _INCH,
        },
    }


class Table(ScenePart):
    """The table between the cushion noses: a rectangle or a polygon.

    It extends from (0, 0) to (length, width) [m].

    `cushions` lists the sides of a rectangle that have a cushion. A side without a cushion is open,
    and the cloth continues beyond it; the lines of the neighbouring cushions then continue to
    infinity.

    A `preset` sets the size and pockets of a standard table, and the radius and mass of balls for
    which the scene gives none. Any field overrides the preset. The name of a preset may replace the
    table in a scene. `vertices` make the table any simple polygon instead. A corner that
    points into the table acts on balls as a point.
    """

    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {
        "wpa-9ft": {"length": 2.54, "width": 1.27, "pockets": _pool_pockets()},
        "wpa-8ft": {"length": 2.337, "width": 1.168, "pockets": _pool_pockets()},
        # There are no rules: all values are those of pooltool's table "seven_foot_showood"
        # (`collection.py`, commit 13a571d).
        "bar-7ft": {
            "length": 1.9812,
            "width": 0.9906,
            "pockets": {
                "corner": {
                    "mouth": 0.118,
                    "angle": 140.3 * _DEGREE,
                    "jaw_radius": 0.02095,
                    "depth": 0.0417,
                    "radius": 0.062,
                },
                "side": {
                    "mouth": 0.137,
                    "angle": 97.14 * _DEGREE,
                    "jaw_radius": 0.00795,
                    "depth": 0.0685,
                    "radius": 0.0645,
                },
            },
        },
        # The pockets are pooltool's (`collection.py`, commit 13a571d), because the rules of snooker
        # give templates without numbers.
        "snooker-12ft": {
            "length": 3.569,
            "width": 1.778,
            "pockets": {
                "corner": {
                    "mouth": 0.083,
                    "angle": 135.0 * _DEGREE,
                    "jaw_radius": 3.6 * _INCH,
                    "depth": 0.036,
                    "radius": 0.043,
                },
                "side": {
                    "mouth": 0.075,
                    "angle": 90.0 * _DEGREE,
                    "jaw_radius": 2.5 * _INCH,
                    "depth": 0.95 * _INCH,
                    "radius": 1.68 * _INCH,
                },
            },
        },
        "carom-10ft": {"length": 2.84, "width": 1.42},
    }

    BALLS: ClassVar[dict[str, dict[str, float]]] = {
        "wpa-9ft": POOL_BALL,
        "wpa-8ft": POOL_BALL,
        "bar-7ft": POOL_BALL,
        "snooker-12ft": SNOOKER_BALL,
        "carom-10ft": CAROM_BALL,
    }
    """Radius [m] and mass [kg] of the balls of each preset."""

    # Absent fields that were added later are omitted, so that scenes stored by older versions stay
    # equal.
    preset: Literal["wpa-9ft", "wpa-8ft", "bar-7ft", "snooker-12ft", "carom-10ft"] | None = Field(
        default=None,
        exclude_if=not_,
        description="a standard table: sets the size and the pockets, and the radius and mass of "
        "balls for which the scene gives none",
    )
    length: Positive = Field(description="size along x, between the noses of the cushions [m]")
    width: Positive = Field(description="size along y, between the noses of the cushions [m]")
    cushions: tuple[CushionName, ...] = Field(
        default=CUSHIONS, description="sides with a cushion: x = 0, x = length, y = 0, y = width"
    )
    vertices: tuple[tuple[Real, Real], ...] = Field(
        default=(),
        exclude_if=not_,
        description="corners of a polygon, instead of a rectangle, counterclockwise [m]; smallest "
        "x and y must be 0; omit `length` and `width`",
    )
    pockets: Pockets | None = Field(
        default=None,
        exclude_if=not_,
        description="pockets of a rectangle with four cushions; default: none",
    )
    posts: tuple[Post, ...] = Field(
        default=(), exclude_if=not_, description="round obstacles that stand on the table"
    )

    @classmethod
    def _once_checked(cls, value: Any, check: ValidatorFunctionWrapHandler) -> Self:
        """Return the table that a preset names, made once: its pockets take longer than a scene."""
        if isinstance(value, str) and value in cls.PRESETS:
            named: Self = _preset_table(cls, value)
            return named
        return super()._once_checked(value, check)

    @model_validator(mode="before")
    @classmethod
    def _complete(cls, data: Any) -> Any:
        """Replace the name of a preset by its table, and set the size of a polygon."""
        if isinstance(data, str):
            data = {"preset": data}
        if not isinstance(data, dict):
            return data
        preset = data.get("preset")
        defaults = cls.PRESETS.get(preset, {}) if isinstance(preset, str) else {}
        if preset is not None and not defaults:
            # The name of the preset is wrong; its size must not be reported as missing too.
            defaults = {"length": 1.0, "width": 1.0}
        if data.get("vertices"):
            defaults = {**_size_of(data["vertices"]), "pockets": None}
        return {**defaults, **data}

    @field_validator("cushions")
    @classmethod
    def _each_once(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(value)) != len(value):
            raise problem(
                f"must name each cushion once, got {value}",
            )
        return tuple(name for name in CUSHIONS if name in value)

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        size = (self.length, self.width)
        if self.vertices:
            if self.preset is not None:
                raise problem(
                    f'`preset` must not be given together with `vertices`, got "{self.preset}": '
                    "vertices define the whole shape, without pockets. Remove one of them",
                    at=("preset",),
                )
            if self.pockets is not None:
                raise problem(
                    "`pockets` must not be given together with `vertices`: a polygon has no "
                    "pockets. Remove one of them",
                    at=("pockets",),
                )
            check_polygon(self.vertices, size, self.cushions)
        if self._pocketed is not None:
            check_pockets(size, self.cushions, self._pocketed)
        posts = [(post.centre, post.radius) for post in self.posts]
        check_posts(posts, self.outline, size, self._pocketed)
        return self

    @property
    def is_rectangle(self) -> bool:
        """Whether the table is a rectangle without pockets, whose cushions are infinite lines."""
        return not self.vertices and self._pocketed is None

    def has_holes_beyond(self, reach: float) -> bool:
        """Return whether no point at least `reach` [m] inside all sides is inside a hole.

        A ball with such a centre isn't beyond the outline, and jaws and facings aren't nearer than
        noses.
        """
        low, high = (reach, reach), (self.length - reach, self.width - reach)
        return all(
            distance_to_box(hole.centre, low, high) > hole.radius * (1.0 + _HOLE_MARGIN)
            for hole in self.holes
        )

    @property
    def has_cushions(self) -> bool:
        """Whether the table has a cushion or a post."""
        return bool(self.cushions or self.posts)

    def facing(self, obstacle: int, x: float, y: float) -> tuple[Point, float]:
        """Return the unit normal of an obstacle towards a place, and the distance between them [m].

        `obstacle` is its index in events; of several pieces of one cushion, the nearest counts.
        """
        for side in self.sides:
            if side.cushion == obstacle:
                return side.normal, side.distance(x, y)
        return facing(self._nearest_piece(obstacle, x, y), x, y)

    def turns_about(self, obstacle: int, x: float, y: float) -> Point | None:
        """Return the point about which the normal of `facing` turns [m]; None if it is constant."""
        if any(side.cushion == obstacle for side in self.sides):
            return None
        return turns_about(self._nearest_piece(obstacle, x, y), x, y)

    def _nearest_piece(self, obstacle: int, x: float, y: float) -> Obstacle:
        pieces = [
            one for one in self.obstacles if not isinstance(one, Hole) and one.obstacle == obstacle
        ]
        return min(pieces, key=lambda one: facing(one, x, y)[1])

    @property
    def sides(self) -> tuple[Side, ...]:
        """The sides of a rectangle without pockets that have a cushion.

        All other obstacles are in `obstacles`.
        """
        if not self.is_rectangle:
            return ()
        return tuple(side_of(name, self.length, self.width) for name in self.cushions)

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The obstacles on the table besides `sides`: rails, jaws, facings, posts and holes."""
        posts = [Disc(FIRST_POST + k, p.centre, p.radius) for k, p in enumerate(self.posts)]
        return (*_walls(self.vertices, (self.length, self.width), self._pocketed), *posts)

    @property
    def outline(self) -> tuple[Point, ...]:
        """The corners of the area inside the cushions and their facings, counterclockwise [m]."""
        if self.vertices:
            return self.vertices
        return tuple(outline_of_pockets(self.length, self.width, self._pocketed or Pockets()))

    @property
    def drawn_outline(self) -> tuple[Point, ...]:
        """The outline with rounded jaws, for pictures [m]."""
        if self._pocketed is None:
            return self.outline
        return tuple(outline_of_pockets(self.length, self.width, self._pocketed, arc=8))

    @property
    def holes(self) -> tuple[Hole, ...]:
        """The holes of the pockets."""
        return tuple(one for one in self.obstacles if isinstance(one, Hole))

    @property
    def _pocketed(self) -> Pockets | None:
        """The pockets of the table; None also if neither corner nor side pockets are given."""
        pockets = self.pockets
        return None if pockets is None or pockets.corner is pockets.side is None else pockets


@cache
def _preset_table(kind: type[Table], name: str) -> Any:
    """Return the table that a preset names; scenes may share the table, because it is frozen."""
    return kind.model_validate({"preset": name})


@lru_cache(maxsize=32)
def _walls(
    vertices: tuple[Point, ...], size: tuple[float, float], pocketed: Pockets | None
) -> tuple[Obstacle, ...]:
    """Return the obstacles of a table, without its posts."""
    if vertices:
        return tuple(obstacles_of_polygon(vertices))
    return () if pocketed is None else tuple(obstacles_of_pockets(*size, pocketed))


def _size_of(vertices: Any) -> dict[str, float]:
    """Return the size of a polygon; 1 m if it has no extent, which a later check rejects."""
    try:
        xs, ys = zip(*((float(x), float(y)) for x, y in vertices), strict=True)
    except (TypeError, ValueError, OverflowError):
        return {"length": 1.0, "width": 1.0}
    sizes = {"length": max(xs), "width": max(ys)}
    return {name: size if SMALLEST <= size <= LARGEST else 1.0 for name, size in sizes.items()}
