"""Long runs: many collisions, of a gas and of Galperin's balls.

Time-stepping engines simulate only the shorter ones: the longest would take them hours.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from mpmath import mp, workdps

from ghostball.model import POOL_BALL_RADIUS as RADIUS, Ball, Scene, Table
from ghostball.validation.checks.criterion import Criterion
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.stress.gas import ICE, collision_rate, gas
from ghostball.validation.stress.shots import (
    StressFamily,
    StressShot,
    StressSize,
    limit,
    scene_of,
    shot,
)

ROWS, PACKING = 6, 0.5
"""A gas of rows x rows balls, and the share of the table that they cover."""

MOST_STEPPED = 1_000
"""Largest number of collisions of a gas for time-stepping engines."""

DRIFT = 16.0
"""Allowed drift of the energy by rounding, in standard deviations.

Each collision rounds the speeds of two of N balls by about EPS / 2, up or down: EPS / N of the
energy. As a random walk, n collisions cause sqrt(n) times as much. A law with one rounding error in
the same direction at each collision exceeds the limit after some hundred collisions.
"""

_SUM = 16.0
"""Roundings of the sum over all balls that gives the energy."""

_PREDICTED = (
    "The theory of gases predicts the number of collisions between balls, within a quarter."
)


def _gases(size: StressSize) -> Iterator[StressShot]:
    for collisions in (1_000, 10_000, 100_000) if size.full else (1_000, 100_000):
        t_max = collisions / collision_rate(ROWS**2, PACKING)
        drift = EPS * (_SUM + DRIFT * math.sqrt(collisions) / ROWS**2)
        scene = gas(ROWS, PACKING, t_max, 1 + size.seed)
        # The rate is for balls with a mean squared velocity of 1 m^2/s^2 in each direction.
        predicted = collisions * float(np.sqrt(np.mean(scene.velocities[:, :2] ** 2)))
        why = "Each collision rounds the energy up or down; the roundings add up as a random walk."
        yield shot(
            f"gas-{collisions}",
            scene,
            limit("energy_drift", why, claiming="rounding", at_most=drift),
            limit(
                "energy_drift",
                "No process dissipates energy; 1e-6 allows for the noise of a solver.",
                at_most=1e-6,
            ),
            # The initial lattice takes time to dissolve.
            limit("ball_ball_count", _PREDICTED, at_least=math.floor(0.75 * predicted)),
            limit("ball_ball_count", _PREDICTED, at_most=math.ceil(1.25 * predicted)),
            truth="none",
            stepped=collisions <= MOST_STEPPED,
            collisions=collisions,
        )


def _galperins() -> Iterator[StressShot]:
    """Yield a light ball between a cushion and a heavy one: the number of collisions spells pi."""
    for digits in range(6):
        count = galperin(digits)
        yield shot(
            f"galperin-{digits}",
            galperin_shot(digits),
            limit(
                "collision_count",
                "The number of collisions is given by the digits of pi.",
                equals=count,
            ),
            *_limits_of_rounding(digits, count),
            limit(
                "reversal_error",
                "The reversed shot returns to its start, so its final speeds are right, too.",
                claiming="rounding",
                at_most=1e-3 * RADIUS,
            ),
            # certifying so many collisions takes minutes
            truth=None if digits <= 2 else "none",
            stepped=digits <= 2,
            collisions=count,
        )


def _limits_of_rounding(digits: int, count: int) -> Iterator[Criterion]:
    """Yield limits on a shot of `count` collisions, for engines that claim rounding errors only.

    Collisions with the ball and the cushion alternate, starting with the ball.
    """
    alternate = "The collisions alternate: the heavy ball, the cushion, the heavy ball."
    yield limit("ball_ball_count", alternate, claiming="rounding", equals=(count + 1) // 2)
    yield limit("ball_cushion_count", alternate, claiming="rounding", equals=count // 2)
    yield limit(
        "energy_drift",
        "No process dissipates energy; each collision may round the energy once, by 2.2e-16.",
        claiming="rounding",
        at_most=count * EPS,
    )
    yield limit(
        "overlap_max",
        "Rounding the instant of a collision by up to 2e-16 s moves the light ball, at up to "
        f"1e{digits} m/s; 1e-14 m allows for the rounding of positions.",
        claiming="rounding",
        at_most=max(1e-14, 2e-16 * 10.0**digits),
    )


def galperin_shot(digits: int) -> Scene:
    """Return the shot on the centre line of a table 1 m wide, so y isn't rounded.

    The heavy ball has 100^digits times the mass.
    """
    table = Table(length=2.0, width=1.0, cushions=("left",))
    light = Ball(id="light", position=(0.5 + RADIUS, 0.5), mass=1.0)
    start, velocity = (1.0 + 3.0 * RADIUS, 0.5), (-1.0, 0.0)
    heavy = Ball(id="heavy", position=start, velocity=velocity, mass=100.0**digits)
    return scene_of(light, heavy, physics=ICE, t_max=5.0, table=table)


def galperin(digits: int) -> int:
    """Return the number of collisions with masses 1 : 100^digits.

    Galperin 2003, Regular and Chaotic Dynamics 8(4) 375: with X = sqrt(M) x, Y = sqrt(m) y, both
    balls are one point in a wedge of angle theta = atan(sqrt(m / M)). Unfolded, its path is a
    straight line, which crosses a mirror ceil(pi / theta) - 1 times.
    """
    with workdps(50):
        return int(mp.ceil(mp.pi / mp.atan(mp.mpf(10) ** -digits))) - 1


def _shots(size: StressSize) -> Iterator[StressShot]:
    yield from _gases(size)
    yield from _galperins()


FAMILY = StressFamily(
    "long-runs",
    "Long runs: a gas, Galperin's pi",
    "In 100 000 collisions an elastic gas changes its energy by no more than a random walk of "
    "roundings, and balls never overlap. The number of collisions of Galperin's balls is given by "
    "the digits of pi, up to 314 159. Time-stepping engines simulate the shots of at most "
    f"{MOST_STEPPED} collisions.",
    _shots,
)
