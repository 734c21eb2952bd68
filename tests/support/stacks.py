"""Random stacks: balls that lie on, or fall on, other balls, each from its kind and its number.

A kind says what must become of the uppermost ball: whether it stays on the balls below, or falls
off them.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any, Final

from shots import R, ball, scene_of

from ghostball.model import Scene, Table

H: Final = 0.0357
"""Height of a nose of the preset [m]."""

_MASS: Final = 0.17

_ROLLING_FRICTION: Final = 0.01
"""Of the preset: a rolling ball slows by this times gravity."""


class _Stack:
    """Balls as they are laid, of sizes and masses that are equal or not."""

    def __init__(self, chance: random.Random) -> None:
        self.chance = chance
        self.unequal = chance.random() < 0.5
        self.balls: list[dict[str, Any]] = []

    def size(self) -> float:
        return R * self.chance.uniform(0.8, 1.25) if self.unequal else R

    def mass(self, radius: float) -> float:
        heavy = self.chance.choice((0.3, 1.0, 3.0)) if self.unequal else 1.0
        return heavy * _MASS * (radius / R) ** 3

    def lay(self, radius: float, mass: float, *places: tuple[float, float]) -> None:
        """Lay equal balls on the cloth."""
        for x, y in places:
            self._add(radius, mass, (x, y, radius))

    def drop(
        self,
        x: float,
        y: float,
        radius: float | None = None,
        height: float = 0.0,
        mass: float | None = None,
    ) -> None:
        """Put a ball on the balls that lie below, or let it fall on them.

        `height`: of its centre at least [m].
        """
        radius = radius or self.size()
        for below in self.balls:
            reach = radius + below["radius"]
            square = (x - below["position"][0]) ** 2 + (y - below["position"][1]) ** 2
            if square < reach * reach:
                height = max(height, below["position"][2] + math.sqrt(reach * reach - square))
        above = self.chance.choice((0.0, 10.0 ** self.chance.uniform(-8.0, -2.0)))
        self._add(radius, mass or self.mass(radius), (x, y, height + above))

    def aside(self, least: float, most: float) -> float:
        """Return a distance in balls' radii, between two powers of ten [m]."""
        return R * 10.0 ** self.chance.uniform(least, most) * self.chance.choice((-1.0, 1.0))

    def _add(self, radius: float, mass: float, position: tuple[float, float, float]) -> None:
        self.balls.append(ball(position, (0.0, 0.0, 0.0), radius=radius, mass=mass))


def _reach(radius: float) -> float:
    """Return how far from a cushion a ball on the cloth touches the nose [m]."""
    return math.sqrt(H * (2.0 * radius - H))


def _on_one(stack: _Stack) -> Table | None:
    """A ball on top of another one, on the open cloth or between cushions."""
    x, y = stack.chance.uniform(0.3, 0.9), stack.chance.uniform(0.2, 0.5)
    stack.lay(R, _MASS, (x, y))
    stack.drop(x + stack.chance.choice((0.0, stack.aside(-9.0, 0.0))), y)
    return stack.chance.choice((None, Table(length=1.2, width=0.7)))


def _on_loose(stack: _Stack) -> Table | None:
    """A ball on two or three balls that touch, or nearly, and that nothing holds."""
    x, y, above, held = _on_touching(stack)
    mass = held * 10.0 ** stack.chance.uniform(0.5, 2.0)
    x += stack.chance.choice((0.0, stack.aside(-6.0, -0.5)))
    stack.drop(x, y, above, mass=mass)
    return stack.chance.choice((None, Table(length=1.2, width=0.7)))


def _on_heavy(stack: _Stack) -> Table | None:
    """A light ball on two or three heavy balls, which rolling friction holds."""
    x, y, above, held = _on_touching(stack)
    mass = held * stack.chance.uniform(0.1, 0.5)
    x += stack.chance.choice((0.0, stack.aside(-6.0, -4.0)))
    stack.drop(x, y, above, mass=mass)
    return None


def _on_touching(stack: _Stack) -> tuple[float, float, float, float]:
    """Lay two or three balls that touch, or nearly.

    Return a place above their middle [m], a radius, and how heavy a ball of that radius may be
    [kg] so that rolling friction holds the balls below. A weight W pushes each of n balls aside
    with W tan(slope) / n. A ball of mass m rolls as if it had the mass 7/5 m, so it stays if the
    push is below 7/5 m times its deceleration.
    """
    radius, above, mass = stack.size(), stack.size(), _MASS * stack.chance.choice((1.0, 3.0))
    side = 2.0 * radius * (1.0 + stack.chance.choice((0.0, stack.chance.uniform(0.0, 0.3))))
    third = (0.5 + 0.5 * side, 0.3 + math.sqrt(0.75) * side)
    places = ((0.5, 0.3), (0.5 + side, 0.3), third)[: stack.chance.choice((2, 3))]
    stack.lay(radius, mass, *places)
    count = len(places)
    middle = math.sqrt(0.75) * side / 3.0 if count == 3 else 0.0
    slope = math.asin(math.hypot(0.5 * side, middle) / (radius + above))
    held = count * 1.4 * mass * _ROLLING_FRICTION / math.tan(slope)
    return 0.5 + 0.5 * side, 0.3 + middle, above, held


def _over_pocket(stack: _Stack) -> str:
    """A ball on another one at the edge of a corner pocket or of a side pocket."""
    away = stack.chance.uniform(0.05, 0.12)
    x, y = stack.chance.choice(((2.54 - away, 1.27 - away), (1.27, 1.27 - away)))
    stack.lay(R, _MASS, (x, y))
    stack.drop(x + stack.aside(-3.0, 0.2), y + stack.aside(-3.0, 0.0), R)
    return "wpa-9ft"


def _in_box(stack: _Stack) -> Table:
    """A ball in the hollow of three balls that a box holds, with some room.

    Without room, eight contacts would hold six coordinates, and leave their forces undetermined.
    """
    radius = stack.size()
    room = radius * 10.0 ** stack.chance.uniform(-6.0, -2.0)
    side, reach = 2.0 * radius + room, _reach(radius)
    depth = math.sqrt(0.75) * 2.0 * radius + room
    x = reach + 0.5 * side
    stack.lay(radius, stack.mass(radius), (reach, reach), (reach + side, reach), (x, reach + depth))
    stack.drop(x + stack.chance.choice((0.0, stack.aside(-6.0, -0.5))), reach + depth / 3.0)
    return Table(length=2.0 * reach + side, width=2.0 * reach + depth)


def _between_two(stack: _Stack) -> Table:
    """A ball in the middle between two balls that two cushions hold."""
    radius = stack.size()
    apart, reach = stack.chance.uniform(2.0, 3.0) * radius, _reach(radius)
    length = 2.0 * reach + apart
    stack.lay(radius, stack.mass(radius), (reach, 0.35), (length - reach, 0.35))
    stack.drop(0.5 * length + stack.chance.choice((0.0, stack.aside(-3.0, -0.6))), 0.35)
    return Table(length=length, width=0.7)


def _beside_two(stack: _Stack) -> Table:
    """The same, beside the middle: it falls off across the line of both."""
    table = _between_two(stack)
    top = stack.balls.pop()
    stack.drop(top["position"][0], 0.35 + stack.aside(-4.0, -0.5), top["radius"])
    return table


def _at_a_nose(stack: _Stack) -> Table:
    """A ball between a nose and a ball that the nose across holds."""
    stack.lay(R, _MASS, (0.4, _reach(R)))
    away = stack.chance.uniform(0.4, 0.8) * R
    height = H + math.sqrt(R * R - away * away)
    beside = math.sqrt(4.0 * R * R - (height - R) * (height - R))
    stack.drop(0.4, _reach(R) + beside, R, height)
    return Table(length=1.27, width=_reach(R) + beside + away)


FALLS: Final[dict[str, Callable[[_Stack], Table | str | None]]] = {
    "on-one": _on_one,
    "on-loose": _on_loose,
    "over-pocket": _over_pocket,
    "beside-two": _beside_two,
}
"""Kinds of which every ball comes down to the cloth, into a pocket, or off the table."""

STAYS: Final[dict[str, Callable[[_Stack], Table | str | None]]] = {
    "on-heavy": _on_heavy,
    "in-box": _in_box,
    "between-two": _between_two,
    "at-a-nose": _at_a_nose,
}
"""Kinds of which the uppermost ball stays where it is."""

KINDS: Final = {**FALLS, **STAYS}


def stack_of(kind: str, number: int) -> Scene:
    """Return the stack of that kind and number: the same on every machine."""
    chance = random.Random(f"stack {kind} {number}")
    stack = _Stack(chance)
    table = KINDS[kind](stack)
    physics: dict[str, Any] = {
        "preset": "pool",
        "airborne": True,
        "ball_restitution": chance.choice((0.0, 0.5, 0.95, 1.0)),
        "table_restitution": chance.choice((0.0, 0.5, 0.9)),
        "ball_friction": chance.choice((0.0, 0.05, 0.3)),
    }
    return scene_of(*stack.balls, table=table, **physics)
