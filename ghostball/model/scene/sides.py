"""The sides of a table: names, normals and lines, for engines, certificates and checks."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeVar

from ghostball.model.arrays import FloatArray

CushionName = Literal["left", "right", "bottom", "top"]
CUSHIONS: tuple[CushionName, ...] = ("left", "right", "bottom", "top")
"""Cushion names in the order of their index: x = 0, x = length, y = 0, y = width."""

Point = tuple[float, float]
Number = TypeVar("Number", float, FloatArray)

INWARD: dict[CushionName, Point] = {
    "left": (1.0, 0.0),
    "right": (-1.0, 0.0),
    "bottom": (0.0, 1.0),
    "top": (0.0, -1.0),
}
"""Unit normals into the table."""


class Side(NamedTuple):
    """A cushion of a rectangular table: an infinite line through its nose."""

    name: CushionName
    cushion: int  # index in `CUSHIONS`, as used in events
    normal: Point  # unit normal into the table
    point: Point  # a corner of the table on the line [m]
    length: float  # length of the table along the line [m]

    @property
    def across(self) -> int:
        """Index of the coordinate perpendicular to the line: 0 for x, 1 for y."""
        return 0 if self.normal[0] else 1

    def distance(self, x: Number, y: Number) -> Number:
        """Return the distance of a point from the line into the table [m], elementwise.

        Exact up to the rounding of one subtraction.
        """
        return self.normal[self.across] * ((x, y)[self.across] - self.point[self.across])

    def inside(self, distance: float) -> float:
        """Return the coordinate perpendicular to the line at a distance into the table [m].

        The inverse of `distance`.
        """
        return self.point[self.across] + self.normal[self.across] * distance

    def ends(self, beyond: float = 0.0, outward: float = 0.0) -> tuple[Point, Point]:
        """Return the ends of the part of the line that extends `beyond` both corners [m].

        `outward` [m] moves the line out of the table.
        """
        (nx, ny), (x, y) = self.normal, self.point
        if nx:
            x -= outward * nx
            return (x, -beyond), (x, self.length + beyond)
        y -= outward * ny
        return (-beyond, y), (self.length + beyond, y)


def side_of(name: CushionName, length: float, width: float) -> Side:
    """Return the side with a name, for a table of a size [m]."""
    point = (length, width) if name in ("right", "top") else (0.0, 0.0)
    along = width if INWARD[name][0] else length
    return Side(name, CUSHIONS.index(name), INWARD[name], point, along)
