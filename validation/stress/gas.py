"""An elastic gas of balls between cushions: its scenes, and the rate of its collisions."""

from __future__ import annotations

import math
from typing import Final

from ghostball.model import POOL_BALL_RADIUS as RADIUS, Physics, Scene
from ghostball.validation.scenes.gases import FRICTIONLESS, packed_gas

ICE: Final = Physics(rolling_friction=0.0)
"""Elastic and without friction."""


def gas(rows: int, packing: float, t_max: float, seed: int = 1) -> Scene:
    """Return rows x rows balls of 1 kg that cover the share `packing` of a square table.

    They start on a lattice; each component of their velocities has a variance of about 1 m^2/s^2.
    """
    scene = packed_gas(rows * rows, packing, FRICTIONLESS, t_max, seed)
    balls = tuple(ball.model_copy(update={"mass": 1.0}) for ball in scene.balls)
    return scene.model_copy(update={"balls": balls})


def collision_rate(count: int, packing: float) -> float:
    """Return the approximate number of collisions of two balls of 1 kg per second.

    By the virial theorem, p / (n k T) - 1 is the sum over collisions of m v_n d / (2 N k T t). The
    approach speed v_n has the mean sqrt(pi k T / m) over collisions. The pressure is that of
    Henderson 1975, accurate to 0.5 % up to a packing of 0.5.
    """
    excess = (1.0 + packing**2 / 8.0) / (1.0 - packing) ** 2 - 1.0
    return count * excess / (math.sqrt(math.pi) * RADIUS)
