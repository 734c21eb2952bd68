"""A rack of balls as people make it: small gaps that aren't all equal.

Neighbouring places of a rack are one diameter and `gap` apart, and each ball lies anywhere in a
disc of radius `unevenness` gap / 2 around its place, drawn from `seed`. So gaps lie between
gap (1 - unevenness) and gap (1 + unevenness). The ball in front lies around the foot spot, three
quarters of the length from the head cushion; the other rows follow towards the foot cushion.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, Strict, model_validator

from ghostball.model.scene.ball import POOL_BALL, Ball
from ghostball.model.scene.fields import Fraction, NonNegative, problem
from ghostball.model.scene.messages import refusal
from ghostball.model.scene.part import ScenePart, with_preset
from ghostball.model.scene.table import Table

Kind = Literal["3-ball", "6-ball", "8-ball", "9-ball", "10-ball"]

ROWS: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "3-ball": (("1",), ("2", "3")),
    "6-ball": (("1",), ("2", "3"), ("4", "6", "5")),
    "8-ball": (
        ("1",),
        ("9", "2"),
        ("3", "8", "10"),
        ("11", "4", "12", "5"),
        ("6", "13", "7", "14", "15"),
    ),
    "9-ball": (("1",), ("2", "3"), ("4", "9", "5"), ("6", "7"), ("8",)),
    "10-ball": (("1",), ("2", "3"), ("4", "10", "5"), ("6", "7", "8", "9")),
}
"""Ids of the balls of each kind, row by row from the front: by the rules of the World Pool
Association, 1 in front and the ball of the game in the middle; in 8-ball, balls of both groups in
the back corners. The rules leave the other places open."""

_OVERLAP = 2.0**-40
"""Overlap of two balls, in sums of their radii, that counts as rounding."""


class Rack(ScenePart):
    """A rack of balls that a scene adds to its listed balls.

    Presets. In both, every ball is uneven by as much as its gaps allow.

    "template" (a thin sheet with holes, in which the balls settle): gaps of 0 to 30 um, mean
        15 um. Assumed: nobody has published measured gaps.
    "wooden" (a triangle of wood or plastic): gaps of 0 to 0.1 mm, mean 0.05 mm. Assumed.
    """

    PRESETS: ClassVar[dict[str, dict[str, float]]] = {
        "template": {"gap": 15e-6, "unevenness": 1.0},
        "wooden": {"gap": 50e-6, "unevenness": 1.0},
    }

    kind: Kind = Field(description="the game")
    preset: Literal["template", "wooden"] = Field(
        default="template", description="how the rack is made: sets `gap` and `unevenness`"
    )
    gap: NonNegative = Field(default=15e-6, description="mean gap of neighbouring balls [m]")
    unevenness: Fraction = Field(
        default=1.0, description="largest difference of a gap from `gap`, in units of `gap` [1]"
    )
    seed: Annotated[int, Strict(), Field(ge=0, le=2**63 - 1)] = Field(
        default=0, description="number from which the places of the balls are drawn"
    )

    @model_validator(mode="before")
    @classmethod
    def _apply_preset(cls, data: Any) -> Any:
        return with_preset(data, cls.PRESETS, "template")


def rack(
    kind: str,
    table: Table | str = "wpa-9ft",
    *,
    preset: str = "template",
    gap: float | None = None,
    unevenness: float | None = None,
    seed: int = 0,
    radius: float | None = None,
    mass: float | None = None,
) -> tuple[Ball, ...]:
    """Return the balls of a rack, to be listed in a scene after the cue ball.

    Parameters
    ----------
    kind : "3-ball", "6-ball", "8-ball", "9-ball" or "10-ball"
    table : Table or str
        A rectangular table, or the name of a standard table.
    preset : "template" or "wooden"
        Sets `gap` and `unevenness`; see `Rack`.
    gap : float, optional
        Mean gap of neighbouring balls [m].
    unevenness : float, optional
        Largest difference of a gap from `gap`, in units of `gap`, 0 to 1.
    seed : int
        Number from which the places of the balls are drawn; the same on every machine.
    radius, mass : float, optional
        Of the balls [m, kg]; default: the balls of the table's preset.

    Raises
    ------
    SceneError
        If a value breaks a rule, or the rack doesn't fit on the table.
    """
    given = {"gap": gap, "unevenness": unevenness}
    fields = {name: value for name, value in given.items() if value is not None}
    made = Rack(kind=kind, preset=preset, seed=seed, **fields)
    on = table if isinstance(table, Table) else Table.model_validate(table)
    usual = Table.BALLS.get(on.preset or "", POOL_BALL)
    size = usual["radius"] if radius is None else radius
    weight = usual["mass"] if mass is None else mass
    fault = misfit_of(made, on, size)
    if fault:
        raise refusal(f"{fault}.")
    return balls_of(made, on, size, weight)


def add_rack(
    rack: Rack, table: Table | None, listed: Sequence[Ball], size: Mapping[str, float]
) -> tuple[Ball, ...]:
    """Return the listed balls of a scene, and after them those of its rack.

    `size`: radius and mass of the balls of the rack.

    Raises `PydanticCustomError` if the rack doesn't fit on the table, or doesn't leave room for the
    listed balls.
    """
    fault = misfit_of(rack, table, size["radius"])
    if fault or table is None:
        raise problem(fault, at=("rack", "kind"))
    added = balls_of(rack, table, size["radius"], size["mass"])
    for i, ball in enumerate(listed):
        if any(ball.id == other.id for other in added):
            raise problem(
                f'`balls[{i}].id` must not be "{ball.id}": the {rack.kind} rack adds a ball with '
                "that id. Rename it",
                at=("balls", i, "id"),
            )
        for other in added:
            x, y = (other.position[k] - ball.position[k] for k in range(2))
            reach = ball.radius + other.radius
            overlap = reach - math.hypot(x, y)
            if overlap > _OVERLAP * reach:
                raise problem(
                    f"`balls[{i}].position` must leave room for the {rack.kind} rack: ball "
                    f'"{ball.id}" overlaps its ball "{other.id}" by {overlap:.3g} m. Move it',
                    at=("balls", i, "position"),
                )
    return (*listed, *added)


def misfit_of(rack: Rack, table: Table | None, radius: float) -> str:
    """Return why a rack of balls with a radius [m] can't be on a table; "" if it can."""
    if table is None or table.vertices:
        shape = "an unbounded cloth" if table is None else "a polygon"
        return f"`rack` must be on a rectangular table, got {shape}. Set `table`, or list the balls"
    for x, y in _places(rack, table, radius):
        across, along = radius <= y <= table.width - radius, radius <= x <= table.length - radius
        if not (across and along):
            return (
                f'`rack.kind` = "{rack.kind}" must fit on the table of {table.length:g} x '
                f"{table.width:g} m, but a ball would be at ({x:.4g}, {y:.4g}) m. Set a smaller "
                "rack, or a larger table"
            )
    return ""


def balls_of(rack: Rack, table: Table, radius: float, mass: float) -> tuple[Ball, ...]:
    """Return the balls of a rack on a table that it fits on."""
    ids = [name for row in ROWS[rack.kind] for name in row]
    places = _places(rack, table, radius)
    return tuple(
        Ball(id=name, position=place, radius=radius, mass=mass)
        for name, place in zip(ids, places, strict=True)
    )


def _places(rack: Rack, table: Table, radius: float) -> list[tuple[float, float]]:
    """Return the centres of a rack's balls [m], in the order of `ROWS`."""
    rows, chance = ROWS[rack.kind], random.Random(rack.seed)
    apart = 2.0 * radius + rack.gap
    reach = 0.5 * rack.unevenness * rack.gap
    places = []
    for row, names in enumerate(rows):
        for place in range(len(names)):
            dx, dy = _in_unit_disc(chance)
            x = 0.75 * table.length + row * math.sqrt(0.75) * apart + reach * dx
            y = 0.5 * table.width + (place - 0.5 * (len(names) - 1)) * apart + reach * dy
            places.append((x, y))
    return places


def _in_unit_disc(chance: random.Random) -> tuple[float, float]:
    """Return a random point of the unit disc; from sums and products only, so it is portable."""
    while True:
        x, y = 2.0 * chance.random() - 1.0, 2.0 * chance.random() - 1.0
        if x * x + y * y <= 1.0:
            return x, y
