"""The cushions of a scene as engines that step have them: infinite lines, or parts of these."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ghostball.model import CUSHIONS, Scene
from ghostball.reference_adapters.stepping.laws import fastest

Point = tuple[float, float]

INWARD = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Unit normal into the table of each cushion, in the order of `CUSHIONS`."""


class Side(NamedTuple):
    """A cushion, an infinite line.

    Attributes
    ----------
    cushion : int
        Its index in `CUSHIONS`.
    normal : two floats
        Unit normal into the table.
    point : two floats [m]
        A corner of the table that the line goes through.
    length : float [m]
        Of the table along it.
    """

    cushion: int
    normal: tuple[float, float]
    point: tuple[float, float]
    length: float

    def ends(self, beyond: float, outward: float = 0.0) -> tuple[Point, Point]:
        """Return the ends of a part of the line that goes `beyond` both corners [m].

        `outward` [m] is how far it is moved out of the table.
        """
        (nx, ny), (x, y) = self.normal, self.point
        if nx:
            x -= outward * nx
            return (x, -beyond), (x, self.length + beyond)
        y -= outward * ny
        return (-beyond, y), (self.length + beyond, y)


def sides_of(scene: Scene) -> list[Side]:
    """Return the cushions of a scene, in the order of `CUSHIONS`."""
    table = scene.table
    if table is None:
        return []
    return [
        Side(
            CUSHIONS.index(name),
            INWARD[CUSHIONS.index(name)],
            (table.length, table.width) if name in ("right", "top") else (0.0, 0.0),
            table.width if name in ("left", "right") else table.length,
        )
        for name in table.cushions
    ]


def reach_beyond(scene: Scene) -> float:
    """Return how far outside an open table a ball can get [m]; 0 where it is closed.

    A cushion is an infinite line; one ball can't have more than all the energy.
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
    outside = float(np.max(np.abs(scene.positions)))  # open sides: a ball may start anywhere
    return outside + min(distances, default=0.0)


def reach_beyond_corners(scene: Scene) -> float:
    """Return how far beyond the corners cushions that end must go [m]: a ball may come from there.

    With a length of the table for ends that are no corners to a ball.
    """
    return reach_beyond(scene) + (0.0 if scene.table is None else scene.table.length)
