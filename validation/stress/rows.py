"""Balls of one size and rows of them, for the families about contact."""

from __future__ import annotations

from ghostball.engine import Ball

RADIUS = 2.0**-5
"""Radius [m]: with it, contacts along an axis are closed to the bit, and gaps what they say."""

Plane = tuple[float, float]
Spin = tuple[float, float, float]


def ball(name: str, place: Plane, velocity: Plane = (0.0, 0.0), spin: Spin | None = None) -> Ball:
    """Return a ball of radius `RADIUS` at a place [m], with velocity [m/s] and spin [rad/s]."""
    return Ball(id=name, radius=RADIUS, position=place, velocity=velocity, angular_velocity=spin)


def row(count: int, gap: float, first: float = 0.0) -> list[float]:
    """Return the places of a row's balls [m]; each gap [m] is what the doubles have."""
    places = [first]
    for _ in range(count - 1):
        places.append(places[-1] + (2.0 * RADIUS + gap))
    return places


def resting_row(count: int, gap: float, first: float = 0.0) -> list[Ball]:
    """Return balls "b0", "b1" ... at rest in a row along y = 0."""
    return [ball(f"b{k}", (x, 0.0)) for k, x in enumerate(row(count, gap, first))]
