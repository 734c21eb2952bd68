"""Balls on a line that nothing slows, in rational numbers: what a cradle does, exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise


@dataclass(frozen=True)
class LineEnd:
    """Where balls on a line are at an instant.

    Attributes
    ----------
    positions : list of Fraction [m]
        Of their centres.
    velocities : list of Fraction [m/s]
    collisions : int
        How many there were until then.
    least_gap : Fraction [m]
        The smallest gap that was open while two other balls collided; below some roundings of the
        coordinates, doubles can't tell which collision comes first.
    """

    positions: list[Fraction]
    velocities: list[Fraction]
    collisions: int
    least_gap: Fraction


def play_line(
    positions: Sequence[float],
    velocities: Sequence[float],
    masses: Sequence[float],
    radius: float,
    restitution: float,
    until: float,
) -> LineEnd:
    """Play balls of one radius on a line, without friction, collision by collision.

    Parameters
    ----------
    positions : n floats, increasing [m]
        Taken, as all numbers, for the rational numbers that they are.
    velocities : n floats [m/s]
    masses : n floats [kg]
    radius : float [m]
    restitution : float
    until : float [s]

    Returns
    -------
    LineEnd

    Raises
    ------
    ValueError
        Where two collisions of one instant share a ball: what they do is a convention.
    """
    x, v, m = ([Fraction(one) for one in ones] for ones in (positions, velocities, masses))
    diameter, e, left = 2 * Fraction(radius), Fraction(restitution), Fraction(until)
    collisions = 0
    least = x[-1] - x[0]
    while True:
        due: list[tuple[Fraction, int]] = []
        for i in range(len(x) - 1):
            closing = v[i] - v[i + 1]
            if closing > 0:
                due.append(((x[i + 1] - x[i] - diameter) / closing, i))
        soonest = min((t for t, _ in due), default=left)
        if soonest >= left:
            x = [a + left * b for a, b in zip(x, v, strict=True)]
            return LineEnd(x, v, collisions, least)
        x = [a + soonest * b for a, b in zip(x, v, strict=True)]
        left -= soonest
        now = [i for t, i in due if t == soonest]
        gaps = [x[i + 1] - x[i] - diameter for i in range(len(x) - 1) if i not in now]
        least = min([least, *gaps])
        if any(b - a == 1 for a, b in pairwise(now)):
            raise ValueError(f"balls {now} and their next ones collide at one instant")
        for i in now:
            impulse = (1 + e) * (v[i] - v[i + 1]) * m[i] * m[i + 1] / (m[i] + m[i + 1])
            v[i] -= impulse / m[i]
            v[i + 1] += impulse / m[i + 1]
            collisions += 1
