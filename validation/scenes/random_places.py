"""Positions and velocities of the balls in random scenes; see `random_scenes`.

A direction is computed as a point of the unit circle, from the tangent of half its angle, because
sines differ between machines.
"""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Sequence
from typing import Final

import numpy as np

from ghostball.model import Ball, Hole, Side, Table
from ghostball.model.scene.obstacles import gap_to, is_inside
from ghostball.validation.scenes.random_parts import UNBOUNDED_SIZE, Draft, Options, reach, sized

_SPEEDS: Final = {"slow": (-20, -5), "usual": (-2, 2), "fast": (3, 4)}
"""Binary exponents of the speeds [m/s], lowest and highest."""


def placed(
    chance: random.Random, options: Options, sizes: list[Draft], table: Table | None, physics: Draft
) -> list[Ball]:
    """Return the balls with their initial positions, and the moving balls with their velocities.

    A group that touches, or is at a rail, is placed first; then a ball that rolls along a rail;
    then the other balls, as far as there is room.
    """
    place = _Places(chance, table, physics)
    layout, group = options["layout"], []
    if layout in ("rail", "corner"):
        group = place.at_rail(sizes[: 1 + (len(sizes) > 2)], corner=layout == "corner")
    elif "rack" in layout:
        gap = sized(chance, -30, -8) if layout == "loose-rack" else 0.0
        group = place.rack(sizes, gap, at_rail=layout == "rack-at-rail")
    elif layout == "touching":
        group = place.cluster(sizes[: max(2, len(sizes) - 1)])
    free = [ball for ball in sizes if ball not in group]
    movers: list[Draft] = []
    along = options["along-rail"] == "yes"
    if along:
        cue = free.pop(0) if free else group[0]
        if cue not in group and not place.at_rail([cue], corner=False):
            cue = group[0] if group else cue
        movers.append(cue)
    for ball in free:
        place.anywhere(ball)
    balls = place.balls
    _lift(chance, options["flight"], place, movers)
    still = [ball for ball in balls if ball not in movers]
    shot = [ball for ball in still if ball not in group] or still
    if not movers or (shot and chance.random() < 0.5):
        movers.append(shot[-1])
    if len(balls) > 2 and chance.random() < 0.3:
        movers += [ball for ball in balls[:1] if ball not in movers]
    for ball in movers:
        others = [other for other in balls if other is not ball]
        speed = sized(chance, *_SPEEDS[options["speed"]])
        way = place.rail_of(ball) if along and ball is movers[0] else None
        _shoot(chance, options, ball, speed, way or place.way_for(ball, others))
    if options["spin"] == "vertical" and len(balls) > 1 and chance.random() < 0.3:
        balls[0].setdefault("angular_velocity", (0.0, 0.0, chance.uniform(-60.0, 60.0)))
    chance.shuffle(balls)
    return [Ball(**ball) for ball in balls]


def _direction(chance: random.Random) -> tuple[float, float]:
    half = chance.uniform(-1.0, 1.0)
    c, s = (1.0 - half * half) / (1.0 + half * half), 2.0 * half / (1.0 + half * half)
    return (c, s) if chance.random() < 0.5 else (-c, s)


def _lift(chance: random.Random, flight: str, place: _Places, movers: list[Draft]) -> None:
    """Place a ball in the air, or on another ball."""
    still = [ball for ball in place.balls if ball not in movers] or place.balls
    ball = still[-1]
    x, y = ball["position"]
    radius = ball["radius"]
    if flight == "drop":
        ball["position"] = (*place.within(ball, x, y), radius + sized(chance, -8, -2))
        place.clear_above(ball)
    elif flight == "on-top":
        below = next(one for one in place.balls if one is not ball)
        beside = chance.choice((0.0, chance.uniform(0.0, 1.0))) * min(radius, below["radius"])
        dx, dy = (part * beside for part in _direction(chance))
        if place.table is not None and min(place.room) < 4.0 * radius:
            dy = 0.0  # a narrow table has no room beside a ball
        x, y = below["position"][0] + dx, below["position"][1] + dy
        x, y = place.within(ball, x, y)
        dx, dy = x - below["position"][0], y - below["position"][1]
        radii = radius + below["radius"]
        height = below["radius"] + math.sqrt(max(radii * radii - dx * dx - dy * dy, 0.0))
        ball["position"] = (x, y, height + chance.choice((0.0, sized(chance, -10, -4))))
        place.clear_above(ball)


def _shoot(
    chance: random.Random, options: Options, ball: Draft, speed: float, way: tuple[float, float]
) -> None:
    """Give a ball a velocity in a direction, and spin; or, on the cloth, the stroke of a cue."""
    if options["spin"] == "struck" and len(ball["position"]) == 2:
        ball["strike"] = _strike(chance, speed, way, jumps=options["flight"] == "jump")
        return
    radius = ball["radius"]
    velocity = (speed * way[0], speed * way[1])
    ball["velocity"] = velocity
    if options["flight"] == "jump" or (options["flight"] == "drop" and len(ball["position"]) > 2):
        ball["velocity"] = (*velocity, chance.uniform(0.1, 0.7) * min(speed, 6.0))
    if options["spin"] == "rolls":
        return
    top, side, turn = (chance.uniform(-1.5, 1.5) for _ in range(3))
    top = chance.choice((top, 0.0, 1.0))
    ball["angular_velocity"] = (
        (side * velocity[0] - top * velocity[1]) / radius,
        (side * velocity[1] + top * velocity[0]) / radius,
        0.0 if options["spin"] == "across" else turn * speed / radius,
    )


def _strike(chance: random.Random, speed: float, way: tuple[float, float], *, jumps: bool) -> Draft:
    """Return a cue stroke approximately in a direction, within the friction of the tip."""
    squirt = chance.choice(("end-mass", "alciatore", "none"))
    raised = chance.choice((0.0, chance.uniform(0.0, 0.2), chance.uniform(0.0, 1.4)))
    strike = {
        "speed": speed,
        # Arc tangents differ in their last bits between machines.
        "direction": round(math.atan2(way[1], way[0]), 6),
        "elevation": chance.uniform(0.4, 1.2) if jumps else raised,
        "offset_left": chance.choice((0.0, chance.uniform(-0.35, 0.35))),
        "offset_up": chance.choice((0.0, chance.uniform(-0.35, 0.35))),
        "cue_mass": chance.uniform(0.2, 0.6),
        "tip_restitution": chance.uniform(0.5, 1.0),
        "squirt": squirt,
    }
    return strike if squirt == "none" else {**strike, "end_mass": chance.uniform(0.005, 0.02)}


class _Places:
    """The positions of the balls placed so far, on the cloth, and the search for free places."""

    def __init__(self, chance: random.Random, table: Table | None, physics: Draft) -> None:
        self.chance = chance
        self.table = table
        self.physics = physics
        self.balls: list[Draft] = []
        self.room = UNBOUNDED_SIZE if table is None else (table.length, table.width)
        self.sides = () if table is None else table.sides

    def anywhere(self, ball: Draft) -> None:
        """Place a ball at a free place, if one is found."""
        for _ in range(200):
            edge = reach(ball, self.physics)
            x, y = (self.chance.uniform(edge, max(side - edge, edge)) for side in self.room)
            if self._lay(ball, x, y, apart=0.01):
                return

    def at_rail(self, balls: list[Draft], *, corner: bool) -> list[Draft]:
        """Place balls at a rail, or in a corner, so that they touch the rail and each other."""
        for _ in range(50):
            sides = self._corner() if corner else [self.chance.choice(self.sides)]
            laid = self._row(balls, sides)
            if laid:
                return laid
        return []

    def rack(self, balls: list[Draft], gap: float, *, at_rail: bool) -> list[Draft]:
        """Place balls in a triangle with gaps [m], all spaced as if they were the largest.

        At a rail, the long side of the triangle touches it.
        """
        rows = next(rows for rows in (5, 4, 3, 2) if rows * (rows + 1) // 2 < len(balls))
        spacing = 2.0 * max(ball["radius"] for ball in balls) + gap
        step = math.sqrt(0.75) * spacing
        triangle = [
            (spacing * (place - row / 2.0), (rows - 1 - row) * step)
            for row in range(rows)
            for place in range(row + 1)
        ][: len(balls)]
        for _ in range(200):
            x, y = (self.chance.uniform(0.0, side) for side in self.room)
            if at_rail:
                y = reach(balls[0], self.physics)
            spots = [(x + dx, y + dy) for dx, dy in triangle]
            if at_rail:
                spots = [self._beside_rail(spot) for spot in spots]
            if self._lay_all(balls, spots):
                return balls[: len(spots)]
        return []

    def cluster(self, balls: list[Draft]) -> list[Draft]:
        """Place balls so that each touches one or two earlier ones."""
        for _ in range(50):
            length, width = self.room
            x, y = self.chance.uniform(0.2, 0.8) * length, self.chance.uniform(0.2, 0.8) * width
            spots = self._touching(balls, x, y)
            if self._lay_all(balls, spots):
                return balls
        spots = [(0.5 * self.room[0], 0.5 * self.room[1])]  # in a row, if no cluster fits
        for before, ball in itertools.pairwise(balls):
            spots.append((spots[-1][0] + self._apart(before, ball), spots[-1][1]))
        return balls if self._lay_all(balls, spots) else []

    def _touching(self, balls: list[Draft], x: float, y: float) -> list[tuple[float, float]]:
        spots = [(x, y)]
        for k in range(1, len(balls)):
            a = self.chance.randrange(k)
            d = self._apart(balls[a], balls[k])
            c, s = _direction(self.chance)
            spot = (spots[a][0] + d * c, spots[a][1] + d * s)
            if k > 1 and self.chance.random() < 0.7:
                b = (a + 1) % k
                spot = _corner_of(spots[a], spots[b], d, self._apart(balls[b], balls[k])) or spot
            spots.append(spot)
        return spots

    def way_for(self, ball: Draft, others: list[Draft]) -> tuple[float, float]:
        """Return the direction of a shot, (c, s): towards another ball, or any direction."""
        chance = self.chance
        edge = reach(ball, self.physics)
        if self.table is not None and min(self.room) <= 2.0 * edge * (1.0 + 1e-9):
            return (chance.choice((1.0, -1.0)), 0.0)
        if not others or chance.random() < 0.3:
            return chance.choice((_direction(chance), (1.0, 0.0), (0.0, -1.0)))
        aim = chance.choice(others)
        dx, dy = (b - a for a, b in zip(ball["position"][:2], aim["position"][:2], strict=True))
        distance = math.sqrt(dx * dx + dy * dy)
        if distance == 0.0:
            return _direction(chance)
        wide = ball["radius"] + aim["radius"]
        aside = chance.choice((0.0, chance.uniform(-1.0, 1.0))) * wide / distance
        dx, dy = dx - aside * dy, dy + aside * dx
        size = math.sqrt(dx * dx + dy * dy)
        return (dx / size, dy / size)

    def rail_of(self, ball: Draft) -> tuple[float, float] | None:
        """Return the direction along the rail that a ball touches; None if it touches none."""
        edge = reach(ball, self.physics)
        sign = self.chance.choice((1.0, -1.0))
        for side in self.sides:
            if ball["position"][side.across] == side.inside(edge):
                return (sign * side.across, sign * (1 - side.across))
        return None

    def within(self, ball: Draft, x: float, y: float) -> tuple[float, float]:
        """Return the nearest position inside the table."""
        if self.table is None:
            return x, y
        edge = ball["radius"]
        x, y = (
            min(max(c, edge), side - edge) if side > 2.0 * edge else 0.5 * side
            for c, side in zip((x, y), self.room, strict=True)
        )
        return x, y

    def clear_above(self, ball: Draft) -> None:
        """Raise a ball in the air until it overlaps no other ball."""
        x, y, z = ball["position"]
        for other in self.balls:
            if other is ball:
                continue
            dx, dy = x - other["position"][0], y - other["position"][1]
            left = (ball["radius"] + other["radius"]) ** 2 - dx * dx - dy * dy
            if left > 0.0:
                z = max(z, other["radius"] + math.sqrt(left))
        ball["position"] = (x, y, z)

    def _corner(self) -> list[Side]:
        return [
            self.chance.choice([side for side in self.sides if side.across == across])
            for across in (0, 1)
        ]

    def _row(self, balls: list[Draft], sides: Sequence[Side]) -> list[Draft]:
        """Place balls in a row along the last of the sides; with two sides, from the first."""
        edges = [reach(ball, self.physics) for ball in balls]
        first, last = sides[0], sides[-1]
        if len(sides) == 2:
            at, sign = first.inside(edges[0]), first.normal[first.across]
        else:
            room = self.room[1 - last.across]
            at, sign = self.chance.uniform(edges[0], max(room - edges[0], edges[0])), 1.0
        spots = []
        across = [last.inside(edge) for edge in edges]
        for k, ball in enumerate(balls):
            if k > 0:
                d, aside = self._apart(balls[k - 1], ball), across[k] - across[k - 1]
                at += sign * math.sqrt(max(d * d - aside * aside, 0.0))
            spots.append((at, across[k]) if last.across else (across[k], at))
        return balls if self._lay_all(balls, spots) else []

    def _beside_rail(self, spot: tuple[float, float]) -> tuple[float, float]:
        """Return a position at the bottom rail, transferred to the last rail of the table."""
        along, side = spot[0], self.sides[-1]
        away = side.inside(spot[1])
        return (along, away) if side.across else (away, along)

    def _apart(self, one: Draft, other: Draft) -> float:
        """Return the horizontal distance of two touching balls on the cloth [m]."""
        if self.physics.get("airborne"):
            return 2.0 * math.sqrt(one["radius"] * other["radius"])
        both: float = one["radius"] + other["radius"]
        return both

    def _lay_all(self, balls: list[Draft], spots: list[tuple[float, float]]) -> bool:
        before = len(self.balls)
        laid = [self._lay(ball, *spot) for ball, spot in zip(balls, spots, strict=False)]
        if not all(laid):
            del self.balls[before:]
        return all(laid)

    def _lay(self, ball: Draft, x: float, y: float, apart: float = -1e-13) -> bool:
        """Place a ball if it has a gap of at least `apart` radii to all other balls.

        By default, touching balls may overlap by a rounding error.
        """
        edge = reach(ball, self.physics)
        if any(side.distance(x, y) < edge - 1e-15 for side in self.sides):
            return False
        if self.table is not None and not self._is_off_obstacles(ball, x, y):
            return False
        for other in self.balls:
            dx, dy = x - other["position"][0], y - other["position"][1]
            if math.sqrt(dx * dx + dy * dy) < self._apart(ball, other) + apart * ball["radius"]:
                return False
        ball["position"] = (x, y)
        self.balls.append(ball)
        return True

    def _is_off_obstacles(self, ball: Draft, x: float, y: float) -> bool:
        """Return True if a ball touches no polygon side, pocket, jaw or post."""
        assert self.table is not None
        at = np.array([x]), np.array([y])
        if not self.table.is_rectangle and not is_inside(self.table.outline, *at)[0]:
            return False
        return all(
            gap_to(one, *at)[0] > (0.0 if isinstance(one, Hole) else ball["radius"])
            for one in self.table.obstacles
        )


def _corner_of(
    a: tuple[float, float], b: tuple[float, float], to_a: float, to_b: float
) -> tuple[float, float] | None:
    """Return a point with given distances from two points; None if there is none."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    size = dx * dx + dy * dy
    if size == 0.0:
        return None
    along = 0.5 * (1.0 + (to_a * to_a - to_b * to_b) / size)
    aside = to_a * to_a / size - along * along
    if aside < 0.0:
        return None
    aside = math.sqrt(aside)
    return (a[0] + along * dx - aside * dy, a[1] + along * dy + aside * dx)
